#!/usr/bin/env python3
"""Writes scenes/grass.rib: a field of barley in the wind, all of it curves and points that deform while the shutter is open.

The output is committed; run this again only to change it. No random numbers but Python's seeded ones, so that a second
run writes the same bytes.
"""
import math
import pathlib
import random

SCENES = pathlib.Path(__file__).resolve().parent.parent / "scenes"
CLUMPS, INSTANCES = 5, 1500
KEYS = (0, 0.5, 1)


def number(x, digits=3):
    text = f"{x:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text.replace("-0.", "-.") if text.startswith("-0.") else text.lstrip("0") or "0"


def numbers(values, digits=3):
    return " ".join(number(v, digits) for v in values)


class Stalk:
    """A stem as an arc: it leans by the wind's push, more and more with height."""

    def __init__(self, rng):
        self.x, self.z = rng.gauss(0, 0.10), rng.gauss(0, 0.10)
        self.height, self.lean, self.turn = rng.uniform(0.62, 0.95), rng.gauss(0, 0.10), rng.uniform(0, 2 * math.pi)
        self.phase, self.give = rng.uniform(-0.5, 0.5), rng.uniform(0.7, 1.3)

    def at(self, h, time):
        """Point at h (0 root, 1 top; the ear nods beyond)."""
        wind = self.give * (0.20 + 0.16 * math.sin(1.3 * time + self.phase + 0.4))
        push, nod = wind * h * h * self.height, max(0.0, h - 0.85)
        return (self.x + push + math.cos(self.turn) * self.lean * h * h + 1.1 * nod * nod,
                self.height * h - 0.55 * push * push / self.height - 1.6 * nod * nod,
                self.z + math.sin(self.turn) * self.lean * h * h)

    def bezier(self, h0, h1, time):
        """Cubic piece from h0 to h1, by points and slopes."""
        p, q, e = self.at(h0, time), self.at(h1, time), 1e-3
        a, b = self.at(h0 + e, time), self.at(h1 - e, time)
        k = (h1 - h0) / 3 / e
        return [p, tuple(x + (y - x) * k for x, y in zip(p, a)), tuple(x + (y - x) * k for x, y in zip(q, b)), q]


def moving(request, tail, points_at):
    out = [f"    MotionBegin [{numbers(KEYS)}]\n"]
    for t in KEYS:
        out.append(f"    {request} \"P\" [{numbers(c for p in points_at(t) for c in p)}] {tail}\n")
    return "".join(out + ["    MotionEnd\n"])


def clump(rng, index):
    stalks = [Stalk(rng) for _ in range(11)]
    out = [f"  ObjectBegin \"clump{index}\"\n"]
    # stems: tubes
    tints = [c for _ in stalks for f in [rng.uniform(0.8, 1.2)] for c in (0.42 * f, 0.36 * f, 0.12)]
    out.append("    Bxdf \"PxrDiffuse\" \"stem\" \"reference color diffuseColor\" [\"tint:resultRGB\"]\n")
    out.append(moving(f"Curves \"cubic\" [{' '.join('4' for _ in stalks)}] \"nonperiodic\"",
                      f"\"varying float width\" [{' '.join('.009 .005' for _ in stalks)}] \"uniform color tint\" [{numbers(tints, 2)}]",
                      lambda t: [p for s in stalks for p in s.bezier(0, 1, t)]))
    # leaves: ribbons that stand as their normals say, light comes through
    leaves = []
    for s in stalks:
        for _ in range(rng.choice((1, 2))):
            leaves.append((s, rng.uniform(0.15, 0.6), rng.uniform(0, 2 * math.pi), rng.uniform(0.14, 0.30)))

    def leaf(s, h, a, size, t):
        x, y, z = s.at(h, t)
        sway = 0.05 * math.sin(2 * t + s.phase + a)
        return [(x, y, z), (x + math.cos(a) * size * 0.25, y + size * 0.5, z + math.sin(a) * size * 0.25),
                (x + math.cos(a) * size * 0.6 + sway, y + size * 0.55, z + math.sin(a) * size * 0.6),
                (x + math.cos(a) * size + 2 * sway, y + size * 0.15, z + math.sin(a) * size)]

    normals = [c for _, _, a, _ in leaves for n in ((-math.cos(a), 0.4, -math.sin(a)), (math.cos(a), 0.9, math.sin(a))) for c in n]
    tints = [c for _ in leaves for f in [rng.uniform(0.6, 1.2)] for c in (0.20 * f, 0.27 * f, 0.05)]
    out.append("    Bxdf \"PxrDiffuse\" \"leaf\" \"reference color diffuseColor\" [\"tint:resultRGB\"] \"int transmissionBehavior\" [1]\n"
               "      \"color transmissionColor\" [.16 .22 .02]\n")
    out.append(moving(f"Curves \"cubic\" [{' '.join('4' for _ in leaves)}] \"nonperiodic\"",
                      f"\"varying float width\" [{' '.join('.014 .001' for _ in leaves)}] \"varying normal N\" [{numbers(normals, 2)}] "
                      f"\"uniform color tint\" [{numbers(tints, 2)}]",
                      lambda t: [p for l in leaves for p in leaf(*l, t)]))
    # ears: grains in two rows, and their long hairs
    grains = [(s, 0.95 + 0.16 * k / 12, k % 2 * 2 - 1) for s in stalks for k in range(13)]

    def grain(s, h, side, t):
        x, y, z = s.at(h, t)
        return (x, y, z + side * 0.006)

    out.append("    Bxdf \"PxrSurface\" \"ear\" \"color diffuseColor\" [.52 .38 .13] \"float diffuseRoughness\" [.5]\n")
    out.append(moving("Points", "\"constantwidth\" [.017] \"uniform string type\" \"sphere\"", lambda t: [grain(*g, t) for g in grains]))
    hairs = [(s, 0.97 + 0.13 * k / 7, k % 2 * 2 - 1, rng.uniform(0.10, 0.16), rng.gauss(0, 0.02)) for s in stalks for k in range(8)]

    def hair(s, h, side, size, bend, t):
        p, q = s.at(h, t), s.at(h + 0.02, t)
        d = [b - a for a, b in zip(p, q)]
        length = math.sqrt(sum(c * c for c in d))
        d = [c / length * size for c in d]
        return [p, (p[0] + 0.5 * d[0], p[1] + 0.5 * d[1] + 0.004, p[2] + 0.5 * d[2] + side * 0.018 + bend * 0.4),
                (p[0] + d[0], p[1] + d[1], p[2] + d[2] + side * 0.045 + bend)]

    out.append("    Bxdf \"PxrDiffuse\" \"hair\" \"color diffuseColor\" [.62 .50 .24] \"int transmissionBehavior\" [1]\n"
               "      \"color transmissionColor\" [.25 .20 .08]\n    Attribute \"dice\" \"int roundcurve\" [0]\n")
    out.append(moving(f"Curves \"linear\" [{' '.join('3' for _ in hairs)}] \"nonperiodic\"",
                      f"\"varying float width\" [{' '.join('.0024 .0017 .0005' for _ in hairs)}]",
                      lambda t: [p for h in hairs for p in hair(*h, t)]))
    return "".join(out) + "  ObjectEnd\n"


def main():
    rng = random.Random(11)
    out = ["""##RenderMan RIB-Structure 1.1
# Barley in the wind: stems are tubes, leaves ribbons with normals, ears spheres and hairs ribbons that face the ray; all
# deform over three keys while the shutter is open. Written by tools/make_grass.py. y is up, z goes into the picture.
Option "searchpath" "string texture" [".:@"]
Hider "raytrace" "int maxsamples" [64] "int minsamples" [64]
Integrator "PxrPathTracer" "integrator" "int maxIndirectBounces" [3]
DisplayChannel "color Ci"
DisplayChannel "float a"
Display "grass.exr" "openexr" "rgba"
Display "+grass.png" "png" "rgba"
Format 640 360 1
PixelFilter "gaussian" 2 2
Shutter 0 1
DepthOfField 8 0.22 2.2
Projection "perspective" "fov" [34]
# the eye stands at (0, 0.95, -2) and looks 9 degrees down
ConcatTransform [1 0 0 0  0 0.98769 -0.15643 0  0 0.15643 0.98769 0  0 0 0 1]
Translate 0 -0.95 2
WorldBegin
  AttributeBegin
    # the dome's own up is z: it becomes y
    ConcatTransform [0 0 -1 0  -1 0 0 0  0 1 0 0  0 0 0 1]
    Light "PxrDomeLight" "sky" "string lightColorMap" ["sky.hdr"] "float intensity" [1.1]
  AttributeEnd
  AttributeBegin
    Attribute "identifier" "string name" ["earth"]
    Bxdf "PxrDiffuse" "earth" "color diffuseColor" [0.13 0.10 0.06]
    Polygon "vertex point P" [-60 0 -10  60 0 -10  60 0 90  -60 0 90]
  AttributeEnd
  Pattern "PxrPrimvar" "tint" "string varname" ["tint"] "string type" ["color"]
"""]
    for i in range(CLUMPS):
        out.append(clump(rng, i))
    for _ in range(INSTANCES):
        # denser near the eye, where each instance covers more of the picture
        depth = 16 * rng.random() ** 1.5 - 0.9
        x = rng.uniform(-1, 1) * (0.9 + (depth + 0.9) * 0.62)
        size = rng.uniform(0.8, 1.15)
        out.append(f"AttributeBegin Translate {number(x, 2)} 0 {number(depth, 2)} Rotate {rng.randrange(-30, 31)} 0 1 0 "
                   f"Scale {' '.join([number(size, 2)] * 3)} ObjectInstance \"clump{rng.randrange(CLUMPS)}\" AttributeEnd\n")
    out.append("WorldEnd\n")
    (SCENES / "grass.rib").write_text("".join(out))


if __name__ == "__main__":
    main()
