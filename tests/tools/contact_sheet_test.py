#!/usr/bin/env python3
"""Proves of tools/render_all --sheet: every scene is on the page with its picture, its messages and the author's picture that
belongs to it; archives are not; verdicts come back as they were saved and are summed up; a broken verdict is refused.

    contact_sheet_test.py TOOLS/render_all KINORA
"""
import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

SCRIPT, KINORA = (pathlib.Path(a).resolve() for a in sys.argv[1:3])
del sys.argv[1:3]

SCENE = """Projection "perspective" "fov" [40]
Translate 0 0 3
WorldBegin
{}
Light "PxrDomeLight" "sky"
Bxdf "PxrDiffuse" "m"
Sphere 1 -1 1 360
WorldEnd
"""


class Sheet(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        scenes = self.folder / "scenes" / "somebody"
        (scenes / "textures").mkdir(parents=True)
        (scenes / "ball.rib").write_text(SCENE.format(""))
        (scenes / "other.rib").write_text(SCENE.format('Geometry "noSuchShape"'))
        (scenes / "part.rib").write_text("Sphere 1 -1 1 360\n")
        for name in ("ball.jpg", "ball.tif", "textures/ball.png"):
            (scenes / name).write_bytes(b"")  # only their names matter here

    def run_sheet(self, verdicts=None, render=("--res", "16x16", "--spp", "1"), options=()):
        out = self.folder / "out"
        command = [sys.executable, SCRIPT, self.folder / "scenes", "--kinora", KINORA, "--out", out, "--sheet", out / "sheet.html"]
        if verdicts is not None:
            (self.folder / "v.json").write_text(json.dumps(verdicts))
            command += ["--verdicts", self.folder / "v.json"]
        r = subprocess.run([*map(str, command), *options, "--", *render], capture_output=True, text=True, check=False)
        return r, (out / "sheet.html").read_text() if r.returncode == 0 else ""

    def test_scenes_stand_beside_their_authors_pictures(self):
        r, page = self.run_sheet()
        self.assertEqual(r.returncode, 0, r.stdout + r.stderr)
        self.assertEqual(page.count('class="scene"'), 2)
        self.assertNotIn('data-file="somebody/part.rib"', page)
        ball, other = page.split('data-file="')[1:]
        self.assertIn("somebody_ball.rib.0000.png", ball)
        self.assertTrue((self.folder / "out/somebody_ball.rib.0000.png").exists())
        self.assertIn("author: somebody/ball.jpg", ball)
        self.assertNotIn("ball.tif", page)  # the same picture
        self.assertNotIn("textures/ball.png", page)
        self.assertIn("noSuchShape", other)
        self.assertIn("2 without a verdict", r.stdout)

    def test_verdicts_come_back(self):
        r, page = self.run_sheet({"somebody/ball.rib": {"verdict": "yes", "why": ""},
                                  "somebody/other.rib": {"verdict": "no", "why": "shape: no <shape>"}})
        self.assertIn("1 recognisable, 0 partly, 1 not, 0 wait, 0 have nothing to show, 0 without a verdict, 50 %", r.stdout)
        self.assertIn("no for shape 1", r.stdout)
        self.assertIn('value="yes" checked', page)
        self.assertIn("no &lt;shape&gt;", page)

    def test_what_has_nothing_to_show_is_not_judged(self):
        r, _ = self.run_sheet({"somebody/ball.rib": {"verdict": "yes"},
                               "somebody/other.rib": {"verdict": "empty", "why": "map: a pass that makes a map"}})
        self.assertIn("1 have nothing to show, 0 without a verdict, 100 %", r.stdout)

    def test_a_picture_has_the_shape_of_the_last_world(self):
        scenes = self.folder / "scenes" / "somebody"
        (scenes / "passes.rib").write_text("FrameBegin 1\nFormat 64 64 1\n" + SCENE.format("") + "FrameEnd\nFrameBegin 2\n"
                                           "Format 64 32 1\n" + SCENE.format("") + "FrameEnd\n")
        (scenes / "option.rib").write_text('Option "Ri" "int[2] FormatResolution" [96 24]\n' + SCENE.format(""))
        r, page = self.run_sheet(render=["--spp", "1"], options=["--longest", "40"])
        self.assertEqual(r.returncode, 0, r.stdout + r.stderr)
        for picture, size in (("somebody_passes.rib.0002.png", (40, 20)), ("somebody_option.rib.0000.png", (40, 16))):
            data = (self.folder / "out" / picture).read_bytes()
            self.assertEqual(struct.unpack(">II", data[16:24]), size, picture)

    def test_a_broken_verdict_is_refused(self):
        r, _ = self.run_sheet({"somebody/ball.rib": {"verdict": "maybe"}})
        self.assertNotEqual(r.returncode, 0)
        self.assertIn("somebody/ball.rib", r.stderr)


if __name__ == "__main__":
    unittest.main()
