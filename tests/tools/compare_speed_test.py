#!/usr/bin/env python3
"""Proves of tools/compare_speed: the intervals of medians; which way is better; that another commit is built with this
build's options, once, and found again; that both sides are measured in turns and a figure that one lacks is "-"; what
a failing build or program says. Programs and builds are stand-ins of a few lines; that the real ones give the figures
is tools.CompareSpeedRunsTheRealPrograms.

    compare_speed_test.py TOOLS/compare_speed
"""
import importlib.machinery
import json
import os
import pathlib
import shutil
import stat
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(sys.argv.pop(1)).resolve()
sys.dont_write_bytecode = True
compare = importlib.machinery.SourceFileLoader("compare_speed", str(SCRIPT)).load_module()

# `FACTOR` is how many times longer this version takes; it notes each call in the log.
KINORA = """#!/usr/bin/env python3
import json, sys, time
open({log!r}, "a").write({name!r} + " " + " ".join(sys.argv[1:2]) + "\\n")
if {fails}:
    sys.exit("kinora: it does not work")
if sys.argv[1] == "render":
    arguments = sys.argv
    samples = int(arguments[arguments.index("--samples") + 1].split(":")[1]) - 16 if "--samples" in arguments else 1
    end = time.process_time() + 0.006 * samples * {factor}
    while time.process_time() < end:
        pass
    n = 1000 * samples
    seconds = 0.006 * samples * {factor}
    stages = dict((s, dict(seconds=seconds / 8)) for s in ("trace camera", "trace indirect", "trace shadow", "film"))
    j = dict(seconds=dict(render=seconds), stages=stages, rays=dict(camera=n, indirect=4 * n, shadow=5 * n))
    if {first_group}:
        j["seconds"]["first_group"] = 0.1
    open(arguments[arguments.index("--stats") + 1], "w").write(json.dumps(j))
"""
BENCH = """#!/usr/bin/env python3
import json, pathlib, sys
open({log!r}, "a").write({name!r} + " bench " + " ".join(sys.argv[1:4]) + "\\n")
if sys.argv[1] == "scenes":
    pathlib.Path(sys.argv[3]).mkdir()
else:
    j = dict(trace_vs_embree_10k=0.8 / {factor}, ns_frame_10k=100 * {factor}, ns_bare_10k=50, lpe_cost_12=0.04,
             ns_bare_camera_rich=10, ns_bare_indirect_rich=200, ns_bare_shadow_rich=100)
    open(sys.argv[sys.argv.index("--json") + 1], "w").write(json.dumps(j))
"""


def write_program(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    path.chmod(path.stat().st_mode | stat.S_IXUSR)


class Intervals(unittest.TestCase):
    def test_order_statistics_of_the_median(self):
        # P(1st < median < 7th of 7) = 1 - 2 / 2^7; of 9 the 2nd to the 8th hold it with 1 - 20 / 512
        self.assertEqual(compare.interval([3, 1, 2, 7, 5, 6, 4]), (1, 7, 1 - 2 / 128))
        self.assertEqual(compare.interval([9, 1, 2, 7, 5, 6, 4, 3, 8]), (2, 8, 1 - 20 / 512))
        self.assertEqual(compare.interval([2]), (2, 2, 0))

    def test_too_few_turns_say_so(self):
        low, high, probability = compare.interval([1, 3, 2])
        self.assertEqual((low, high), (1, 3))
        self.assertLess(probability, 0.95)

    def test_which_way_is_better(self):
        self.assertEqual(compare.verdict(1.1, 1.2, compare.HIGHER), "better")
        self.assertEqual(compare.verdict(1.1, 1.2, compare.LOWER), "worse")
        self.assertEqual(compare.verdict(0.8, 0.9, compare.LOWER), "better")
        self.assertEqual(compare.verdict(0.9, 1.1, compare.LOWER), "same")

    def test_ratios_are_of_pairs_and_not_of_medians(self):
        # the machine slowed down on the way: every pair says 1.1, the medians alone would not say how surely
        before = {"glass_ray": [100, 200, 400, 800, 1600, 3200]}
        after = {"glass_ray": [110, 220, 440, 880, 1760, 3520]}
        row = compare.table(before, after).splitlines()[-1]
        self.assertIn("| 1.100 | 1.100 .. 1.100 (96.9 %) | worse |", row)

    def test_a_missing_figure_is_a_dash(self):
        row = compare.table({}, {"first_group": [0.1]}).splitlines()[-1]
        self.assertEqual(row, "| first group after a start, s | - | 0.1 | - | - |  |")


class Runs(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="kinora-compare-test-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.log = self.folder / "log"
        # a repository whose build copies the two stand-ins of its commit
        self.repository = self.folder / "repository"
        (self.repository / "tools").mkdir(parents=True)
        shutil.copy(SCRIPT, self.repository / "tools/compare_speed")
        (self.repository / "scenes").mkdir()
        (self.repository / "scenes/cornell.rib").write_text("")
        (self.repository / ".gitignore").write_text("build\n")
        (self.repository / "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.20)\nproject(standin NONE)\noption(KINORA_THING \"\" OFF)\n"
            "foreach(p kinora kinora-bench)\n  configure_file(programs/${p} ${p} COPYONLY)\n"
            "  add_custom_target(${p} COMMAND ${CMAKE_COMMAND} -E echo built >> ${CMAKE_SOURCE_DIR}/../builds)\n"
            "endforeach()\nfile(WRITE ${CMAKE_BINARY_DIR}/thing \"${KINORA_THING}\")\n")
        self.git("init", "-q")

    def git(self, *arguments):
        who = ["-c", "user.name=t", "-c", "user.email=t@t"]
        return subprocess.run(["git", *who, "-C", self.repository, *arguments], check=True, capture_output=True,
                              text=True).stdout.strip()

    def commit(self, factor, first_group=False, fails=False):
        values = dict(log=str(self.log), name=f"x{factor}", factor=factor, first_group=first_group, fails=fails)
        write_program(self.repository / "programs/kinora", KINORA.format(**values))
        write_program(self.repository / "programs/kinora-bench", BENCH.format(**values))
        self.git("add", "-A")
        self.git("commit", "-qm", f"{factor}")
        return self.git("rev-parse", "HEAD")

    def configure(self):
        subprocess.run(["cmake", "-S", self.repository, "-B", self.repository / "build", "-G", "Ninja",
                        "-DKINORA_THING=ON"], check=True, capture_output=True)

    def compare(self, *arguments):
        self.log.write_text("")
        return subprocess.run([sys.executable, self.repository / "tools/compare_speed", "--quick", "--cache",
                               self.folder / "cache", *arguments], capture_output=True, text=True, check=False,
                              env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"})

    def test_a_commit_is_built_once_and_measured_in_turns(self):
        first = self.commit(3)
        self.commit(1, first_group=True)
        self.configure()
        r = self.compare()  # HEAD~1: the tree is as its commit
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertIn(first[:12] + " (HEAD~1)", r.stdout)
        built = self.folder / "cache" / first[:12]
        self.assertEqual([(f / "thing").read_text() for f in built.glob("source/build-*")], ["ON"])
        self.assertEqual((built / "builds").read_text().count("built"), 2)  # two targets
        calls = self.log.read_text().split("\n")
        turns = [c for c in calls if c.endswith("core --only tracing")]
        self.assertEqual([c.split()[0] for c in turns], ["x3", "x1", "x1", "x3"])

        rows = {l.split(" | ")[0][2:]: l.split(" | ") for l in r.stdout.splitlines() if l.startswith("| ")}
        self.assertIn("too few turns", rows["trace_vs_embree_10k"][-1])  # two
        self.assertEqual(rows["trace_vs_embree_10k"][3], "3.000")
        self.assertEqual(rows["ns a ray above bare Embree, 10k"][1:4], ["250", "50", "0.200"])
        self.assertEqual(rows["first group after a start, s"][1:4], ["-", "0.1", "-"])
        self.assertNotIn("curves_vs_embree", rows)  # neither has it
        self.assertEqual(self.log.read_text().count("x3 render"), 2 * 2 * 6 + 2)
        ray = float(rows["rich frame, ns a ray"][3])
        self.assertTrue(0.2 < ray < 0.5, ray)  # a third, of busy loops
        # of 6 ms for 10,000 rays, 3/8 in the trace stages
        self.assertAlmostEqual(float(rows["rich frame, ns a ray outside the trace stages"][2])
                               / float(rows["rich frame, ns a ray"][2]), 5 / 8, places=2)

        again = self.compare("--only", "tracing", first)
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual((built / "builds").read_text().count("built"), 2)

    def test_changes_that_are_not_committed_are_compared_with_head(self):
        head = self.commit(2)
        self.configure()
        with (self.repository / "CMakeLists.txt").open("a") as f:
            f.write("# a change\n")
        r = self.compare("--only", "curves")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertIn(head[:12] + " (HEAD)", r.stdout)
        self.assertIn("-dirty", r.stdout)

    def test_every_turn_is_kept_as_json(self):
        self.commit(2)
        self.commit(1)
        self.configure()
        r = self.compare("--only", "light_paths", "--turns", "3", "--json", self.folder / "out.json")
        self.assertEqual(r.returncode, 0, r.stderr)
        j = json.loads((self.folder / "out.json").read_text())
        self.assertEqual(j, {"before": {"lpe_frame_12": [1.04] * 3}, "after": {"lpe_frame_12": [1.04] * 3}})

    def test_failures_are_said(self):
        self.commit(1, fails=True)
        self.commit(1)
        missing = self.compare()
        self.assertEqual(missing.returncode, 1)
        self.assertIn("no configured build folder", missing.stderr)
        self.configure()
        unknown = self.compare("nosuchcommit")
        self.assertEqual(unknown.returncode, 1)
        self.assertIn("nosuchcommit", unknown.stderr)
        broken = self.compare("--only", "glass")
        self.assertEqual(broken.returncode, 1)
        self.assertIn("it does not work", broken.stderr)
        self.assertIn("before: ", broken.stderr)
        for arguments in (["--only", "nothing"], ["--turns", "0"], ["--nothing"]):
            self.assertEqual(self.compare(*arguments).returncode, 2, arguments)


if __name__ == "__main__":
    unittest.main()
