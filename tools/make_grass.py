#!/usr/bin/env python3
"""Writes scenes/grass.rib: barley and poppies in the wind under a low sun, all of it curves, points and petals that deform
while the shutter is open, and two butterflies that fly through.

The output is committed; run this again only to change it. No random numbers but Python's seeded ones, so that a second
run writes the same bytes.
"""
import math
import pathlib
import random

SCENES = pathlib.Path(__file__).resolve().parent.parent / "scenes"
EYE, HALF_WIDTH = (0, 0.8, -2), 0.5   # of the view at distance 1
NEAR, FAR = 5.0, 26.0                   # from the eye: full detail to NEAR, plain stalks to FAR
NEAR_SIDE, FAR_SIDE = 0.8, 1.6          # tiles, metres


def ints(values):
    return " ".join(str(round(v)) for v in values)


def number(x, digits=2):
    text = f"{x:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text.replace("-0.", "-.") if text.startswith("-0.") else text.lstrip("0") or "0"


def numbers(values, digits=2):
    return " ".join(number(v, digits) for v in values)


def wind(time, phase):
    """How far it bends what is one unit high."""
    return 0.11 + 0.10 * math.sin(0.35 * time + phase + 0.3)


class Stalk:
    """A stem as an arc, millimetres: it leans by the wind's push, more and more with height; the ear nods beyond 1."""

    def __init__(self, rng, side, height=(640, 900)):
        self.x, self.z = (rng.uniform(-500, 500) * side for _ in "xz")
        self.height, self.lean, self.turn = rng.uniform(*height), rng.gauss(0, 90), rng.uniform(0, 2 * math.pi)
        self.phase, self.give, self.nod = rng.uniform(-0.5, 0.5), rng.uniform(0.7, 1.3), rng.uniform(0.5, 1.6)

    def at(self, h, time):
        push, nod = self.give * wind(time, self.phase) * h * h * self.height, self.nod * max(0.0, h - 0.85)
        return (self.x + push + math.cos(self.turn) * self.lean * h * h + 1300 * nod * nod,
                self.height * h - 0.55 * push * push / self.height - 1700 * nod * nod,
                self.z + math.sin(self.turn) * self.lean * h * h)

    def bezier(self, h0, h1, time):
        """Cubic piece from h0 to h1, by points and slopes."""
        p, q, e = self.at(h0, time), self.at(h1, time), 1e-3
        a, b = self.at(h0 + e, time), self.at(h1 - e, time)
        k = (h1 - h0) / 3 / e
        return [p, tuple(x + (y - x) * k for x, y in zip(p, a)), tuple(x + (y - x) * k for x, y in zip(q, b)), q]


def moving(request, tail, keys, points_at):
    out = [f"    MotionBegin [{numbers(keys)}]\n"]
    for t in keys:
        out.append(f"    {request} \"P\" [{ints(c for p in points_at(t) for c in p)}] {tail}\n")
    return "".join(out + ["    MotionEnd\n"])


def curves(kind, counts, tail, keys, points_at):
    return moving(f"Curves \"{kind}\" [{' '.join(map(str, counts))}] \"nonperiodic\"", tail, keys, points_at)


def tint(rng, low, high, color):
    f = rng.uniform(low, high)
    return [c * f for c in color]


LEAF = ("    Bxdf \"PxrDiffuse\" \"leaf\" \"reference color diffuseColor\" [\"tint:resultRGB\"] \"int transmissionBehavior\" [1]\n"
        "      \"reference color transmissionColor\" [\"tint:resultRGB\"]\n")
STEM = "    Bxdf \"PxrDiffuse\" \"stem\" \"reference color diffuseColor\" [\"tint:resultRGB\"]\n"
HAIR = ("    Bxdf \"PxrDiffuse\" \"hair\" \"color diffuseColor\" [.42 .35 .17] \"int transmissionBehavior\" [1]\n"
        "      \"color transmissionColor\" [.42 .33 .14]\n    Attribute \"dice\" \"int roundcurve\" [0]\n")


def leaf(s, h, a, size, t):
    x, y, z = s.at(h, t)
    sway = 60 * math.sin(2 * t + s.phase + a)
    c, d = math.cos(a) * size, math.sin(a) * size
    return [(x, y, z), (x + c * 0.25, y + size * 0.5, z + d * 0.25), (x + c * 0.6 + sway, y + size * 0.55, z + d * 0.6),
            (x + c + 2 * sway, y + size * 0.15, z + d)]


def leaves(rng, stalks, most, keys):
    """Ribbons that stand as their normals say; light comes through."""
    all_ = [(s, rng.uniform(0.2, 0.65), rng.uniform(0, 2 * math.pi), rng.uniform(150, 300)) for s in stalks
            for _ in range(rng.randint(1, most))]
    normals = [c for _, _, a, _ in all_ for n in ((-math.cos(a), 0.4, -math.sin(a)), (math.cos(a), 0.9, math.sin(a))) for c in n]
    tints = [c for _ in all_ for c in tint(rng, 0.6, 1.2, (0.17, 0.22, 0.045))]
    tail = (f"\"varying float width\" [{' '.join('13 1' for _ in all_)}] \"varying normal N\" [{numbers(normals, 1)}] "
            f"\"uniform color tint\" [{numbers(tints)}]")
    return LEAF + curves("cubic", [4] * len(all_), tail, keys, lambda t: [p for l in all_ for p in leaf(*l, t)])


def hair(s, h, side, size, bend, t):
    p, q = s.at(h, t), s.at(h + 0.02, t)
    d = [b - a for a, b in zip(p, q)]
    length = math.sqrt(sum(c * c for c in d))
    d = [c / length * size for c in d]
    return [p, (p[0] + 0.5 * d[0], p[1] + 0.5 * d[1] + 5, p[2] + 0.5 * d[2] + side * 17 + bend * 0.4),
            (p[0] + d[0], p[1] + d[1], p[2] + d[2] + side * 42 + bend)]


def barley(rng, name):
    keys = (0, 0.5, 1)
    stalks = [Stalk(rng, NEAR_SIDE) for _ in range(34)]
    tints = [c for _ in stalks for c in tint(rng, 0.8, 1.2, (0.42, 0.36, 0.12))]
    out = [f"  ObjectBegin \"{name}\"\n", STEM]
    out.append(curves("cubic", [4] * len(stalks), f"\"varying float width\" [{' '.join('8 5' for _ in stalks)}] "
                      f"\"uniform color tint\" [{numbers(tints)}]", keys, lambda t: [p for s in stalks for p in s.bezier(0, 1, t)]))
    out.append(leaves(rng, stalks, 2, keys))
    grains = [(s, 0.96 + 0.15 * k / 10, (k % 2 * 2 - 1) * 6) for s in stalks for k in range(11)]
    out.append("    Bxdf \"PxrSurface\" \"ear\" \"color diffuseColor\" [.50 .36 .12] \"float diffuseRoughness\" [.5]\n")
    out.append(moving("Points", "\"constantwidth\" [17] \"uniform string type\" \"sphere\"", keys,
                      lambda t: [(x, y, z + side) for s, h, side in grains for x, y, z in [s.at(h, t)]]))
    hairs = [(s, 0.97 + 0.13 * k / 7, k % 2 * 2 - 1, rng.uniform(90, 150), rng.gauss(0, 20)) for s in stalks for k in range(7)]
    out.append(HAIR + curves("linear", [3] * len(hairs), f"\"varying float width\" [{' '.join('2.6 1.8 .6' for _ in hairs)}]", keys,
                             lambda t: [p for h in hairs for p in hair(*h, t)]))
    return "".join(out) + "  ObjectEnd\n"


def far_barley(rng, name):
    """Stalks with ears that are one thick curve, hairs one ribbon: for the distance."""
    keys = (0, 1)
    stalks = [Stalk(rng, FAR_SIDE) for _ in range(64)]
    tints = [c for _ in stalks for c in tint(rng, 0.8, 1.2, (0.44, 0.36, 0.12))]
    out = [f"  ObjectBegin \"{name}\"\n", STEM]
    out.append(curves("cubic", [7] * len(stalks), f"\"varying float width\" [{' '.join('9 7 20' for _ in stalks)}] "
                      f"\"uniform color tint\" [{numbers(tints)}]", keys,
                      lambda t: [p for s in stalks for p in s.bezier(0, 0.95, t) + s.bezier(0.95, 1.13, t)[1:]]))
    out.append(leaves(rng, stalks, 1, keys))
    hairs = [(s, 1.02, k * 2 - 1, 150, rng.gauss(0, 20)) for s in stalks for k in range(2)]
    out.append(HAIR + curves("linear", [3] * len(hairs), f"\"varying float width\" [{' '.join('9 7 1' for _ in hairs)}]", keys,
                             lambda t: [p for h in hairs for p in hair(*h, t)]))
    return "".join(out) + "  ObjectEnd\n"


def poppy(rng, name):
    """A stem with a bowl of four petals that follows its tip; the petals flutter."""
    keys = (0, 0.5, 1)
    stem = Stalk(rng, 0, (860, 980))
    stem.nod, stem.give = 0.4, 0.8
    out = [f"  ObjectBegin \"{name}\"\n    Bxdf \"PxrDiffuse\" \"stem\" \"color diffuseColor\" [.10 .16 .04]\n"]
    out.append(curves("cubic", [4], "\"varying float width\" [6 4]", keys, lambda t: stem.bezier(0, 1, t)))
    open_, turn = rng.uniform(1.15, 1.6), rng.uniform(0, math.pi)
    crinkle = [[rng.gauss(0, 3) for _ in range(20)] for _ in range(4)]

    def frame(t):
        """Tip of the stem and axes with y along it."""
        p, q = stem.at(0.99, t), stem.at(1.0, t)
        d = [b - a for a, b in zip(p, q)]
        length = math.sqrt(sum(c * c for c in d))
        y = [c / length for c in d]
        x = [y[1], -y[0], 0]
        length = math.hypot(*x)
        x = [c / length for c in x]
        z = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]
        return q, x, y, z

    def place(t, local):
        o, x, y, z = frame(t)
        return [tuple(o[i] + x[i] * a + y[i] * b + z[i] * c for i in range(3)) for a, b, c in local]

    def petals(t):
        points = []
        for k in range(4):
            angle, size = turn + k * math.pi / 2, (52, 46)[k % 2] * (1 if k != 2 else 0.93)
            flutter = 0.12 * math.sin(5 * t + k * 2 + stem.phase)
            c, s = math.cos(angle), math.sin(angle)
            for j in range(4):       # along
                b = j / 3
                bow = b * (open_ + flutter)
                for i in range(5):   # across
                    a = (i - 2) / 2
                    radius, height = size * math.sin(bow) / 1.1 + 2, size * (1 - math.cos(bow)) * 0.9
                    radius *= 1 - 0.18 * a * a * b
                    wide, rim = a * size * 0.95 * (0.15 + 0.85 * math.sqrt(b)), crinkle[k][5 * j + i] * b * b * 1.6
                    points.append((c * radius - s * wide, height + rim + 5 * a * a * b, s * radius + c * wide))
        return place(t, points)

    faces = [(20 * k + 5 * j + i, 20 * k + 5 * j + i + 1, 20 * k + 5 * j + i + 6, 20 * k + 5 * j + i + 5)
             for k in range(4) for j in range(3) for i in range(4)]
    out.append("    Bxdf \"PxrDiffuse\" \"petal\" \"color diffuseColor\" [.50 .022 .010] \"int transmissionBehavior\" [1]\n"
               "      \"color transmissionColor\" [.42 .020 .004]\n")
    out.append(moving(f"SubdivisionMesh \"catmull-clark\" [{' '.join('4' for _ in faces)}] [{' '.join(str(v) for f in faces for v in f)}] "
                      "[\"interpolateboundary\"] [1 0] [1] []", "", keys, petals))
    heart = [(0, 6, 0)] + [(10 * math.cos(k), 8, 10 * math.sin(k)) for k in range(0, 30, 3)]
    out.append("    Bxdf \"PxrDiffuse\" \"heart\" \"color diffuseColor\" [.015 .012 .02]\n")
    out.append(moving("Points", f"\"varying float width\" [18 {' '.join('5' for _ in heart[1:])}] \"uniform string type\" \"sphere\"", keys,
                      lambda t: place(t, heart)))
    return "".join(out) + "  ObjectEnd\n"


def butterfly(start, step, heading, phase, color):
    """Wings that beat about the body while it flies on, millimetres."""
    keys = (0, 0.25, 0.5, 0.75, 1)
    outline = [(0, 14), (16, 34), (38, 30), (34, 8), (30, -14), (16, -26), (0, -14)]

    def wings(t):
        points = []
        for side in (-1, 1):
            lift = math.radians(38 + 26 * math.sin(2.6 * t + phase))
            points += [(side * x * math.cos(lift), x * math.sin(lift), z) for x, z in outline]
        return points

    loops = " ".join(str(i) for i in list(range(7)) + list(range(13, 6, -1)))
    return (f"""  AttributeBegin
    MotionBegin [0 1]
      Translate {numbers(start)}
      Translate {numbers(a + b for a, b in zip(start, step))}
    MotionEnd
    Rotate {heading} 0 1 0
    Rotate -25 1 0 0
    Scale .001 .001 .001
    Bxdf "PxrDiffuse" "wing" "color diffuseColor" [{color}] "int transmissionBehavior" [1] "color transmissionColor" [{color}]
""" + moving(f"PointsPolygons [7 7] [{loops}]", "", keys, wings) +
            "    Bxdf \"PxrDiffuse\" \"body\" \"color diffuseColor\" [.03 .025 .02]\n"
            "    Curves \"cubic\" [4] \"nonperiodic\" \"P\" [0 0 -20 0 2 -8 0 2 8 0 0 20] \"varying float width\" [2 4]\n  AttributeEnd\n")


HEAD = """##RenderMan RIB-Structure 1.1
# Barley and poppies in the wind under a low sun: stems are tubes, leaves ribbons with normals, grains spheres, hairs ribbons
# that face the ray, petals subdivision surfaces; all deform while the shutter is open. Written by tools/make_grass.py.
# y is up, z goes into the picture; objects are in millimetres.
Hider "raytrace" "int maxsamples" [64] "int minsamples" [64]
Integrator "PxrPathTracer" "integrator" "int maxIndirectBounces" [3]
DisplayChannel "color Ci"
DisplayChannel "float a"
Display "grass.exr" "openexr" "rgba"
Display "+grass.png" "png" "rgba"
Format 640 360 1
PixelFilter "gaussian" 2 2
Shutter 0 1
DepthOfField 8 0.12 2.0
Projection "perspective" "fov" [30]
# the eye stands at (0, .8, -2) and looks 1 degree down
Rotate -1 1 0 0
Translate 0 -.8 2
WorldBegin
  AttributeBegin
    # the sky's own up is z: it becomes y; its sun stands low on the left, before us
    ConcatTransform [0 0 -1 0  -1 0 0 0  0 1 0 0  0 0 0 1]
    Light "PxrEnvDayLight" "sky" "int month" [0] "vector sunDirection" [-.52 .80 .27] "float haziness" [4]
      "float sunSize" [2] "float exposure" [2.9]
  AttributeEnd
  AttributeBegin
    Attribute "identifier" "string name" ["earth"]
    Bxdf "PxrDiffuse" "earth" "color diffuseColor" [.16 .12 .05]
    Polygon "vertex point P" [-200 0 -10  200 0 -10  200 0 400  -200 0 400]
  AttributeEnd
  AttributeBegin
    Attribute "identifier" "string name" ["hills"]
    Bxdf "PxrDiffuse" "woods" "color diffuseColor" [.30 .33 .36]
    AttributeBegin Translate -46 0 150 Scale 90 9 20 Sphere 1 -1 1 360 AttributeEnd
    AttributeBegin Translate 70 0 190 Scale 120 17 30 Sphere 1 -1 1 360 AttributeEnd
  AttributeEnd
  Pattern "PxrPrimvar" "tint" "string varname" ["tint"] "string type" ["color"]
"""


def main():
    rng = random.Random(11)
    near, far, poppies = ["barley0", "barley1"], ["far0", "far1"], ["poppy0", "poppy1", "poppy2", "poppy3"]
    out = [HEAD]
    out += [barley(rng, n) for n in near] + [far_barley(rng, n) for n in far] + [poppy(rng, n) for n in poppies]

    def place(name, x, z, turn, size):
        out.append(f"AttributeBegin Translate {number(x)} 0 {number(z)} Rotate {turn} 0 1 0 "
                   f"Scale {' '.join([number(size * 0.001, 6)] * 3)} ObjectInstance \"{name}\" AttributeEnd\n")

    def tiles(names, side, first, last):
        depth = first + side / 2
        while depth < last:
            half = HALF_WIDTH * (depth + side) + side
            count = math.ceil(2 * half / side)
            for i in range(count):
                x = (i + 0.5 - count / 2) * side + rng.uniform(-0.15, 0.15) * side
                place(rng.choice(names), EYE[0] + x, EYE[2] + depth + rng.uniform(-0.15, 0.15) * side, rng.randrange(-25, 26),
                      rng.uniform(0.93, 1.08))
            depth += side

    tiles(near, NEAR_SIDE, 1.0, NEAR)
    tiles(far, FAR_SIDE, NEAR, FAR)
    # the ones in focus, then more anywhere
    for x, z, turn, size in ((-0.33, -0.12, 10, 1.03), (-0.22, 0.02, -30, 0.93), (-0.52, 0.16, 30, 1.08), (0.36, 0.05, -10, 0.98), (0.55, 0.3, 20, 1.06)):
        place(poppies[round(abs(x) * 100) % 4], x, z, turn, size)
    for _ in range(40):
        depth = 2.6 + 14 * rng.random() ** 1.5
        place(rng.choice(poppies), rng.uniform(-1, 1) * (HALF_WIDTH * depth + 0.2), EYE[2] + depth, rng.randrange(-40, 41), rng.uniform(0.95, 1.15))
    out.append(butterfly((0.13, 1.0, -0.05), (0.045, 0.02, 0.02), 60, 0.4, ".75 .74 .68"))
    out.append(butterfly((-0.5, 1.05, 1.0), (-0.06, 0.01, 0.01), -80, 2.0, ".70 .45 .06"))
    out.append("WorldEnd\n")
    (SCENES / "grass.rib").write_text("".join(out))


if __name__ == "__main__":
    main()
