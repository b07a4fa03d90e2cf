#!/usr/bin/env python3
"""Writes scenes/fur.rib: a small furry animal. Its coat is a few tufts of hair, placed some thousand times along the surface of
a body of ellipsoids, combed from the nose to the tail and coloured place by place."""
import argparse
import math
import random

# centre, radii, length of the hair, colour of the coat; the animal looks to -z
PIECES = [
    ("body", (0, 0.62, 0.05), (0.50, 0.58, 0.48), 0.22, "coat"),
    ("head", (0, 1.34, -0.22), (0.41, 0.36, 0.37), 0.14, "coat"),
    ("snout", (0, 1.23, -0.56), (0.17, 0.13, 0.16), 0.055, "light"),
    ("left ear", (-0.27, 1.68, -0.12), (0.14, 0.17, 0.07), 0.07, "dark"),
    ("right ear", (0.27, 1.68, -0.12), (0.14, 0.17, 0.07), 0.07, "dark"),
    ("left arm", (-0.44, 0.74, -0.24), (0.14, 0.30, 0.17), 0.15, "coat"),
    ("right arm", (0.44, 0.74, -0.24), (0.14, 0.30, 0.17), 0.15, "coat"),
    ("left foot", (-0.28, 0.13, -0.46), (0.17, 0.12, 0.24), 0.09, "dark"),
    ("right foot", (0.28, 0.13, -0.46), (0.17, 0.12, 0.24), 0.09, "dark"),
    ("tail", (0.30, 0.30, 0.62), (0.19, 0.21, 0.33), 0.26, "light"),
]
NOSE = (0, 1.30, -0.74)
EYES = ((-0.165, 1.42, -0.545), (0.165, 1.42, -0.545))
COLORS = {"coat": (0.42, 0.17, 0.045), "light": (0.80, 0.60, 0.36), "dark": (0.12, 0.045, 0.015)}


def add(a, b, f=1.0):
    return tuple(x + f * y for x, y in zip(a, b))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = math.sqrt(dot(a, a)) or 1.0
    return tuple(x / length for x in a)


def depth(p, piece):
    """Below 1 inside of the piece's ellipsoid."""
    _, centre, radii, _, _ = piece
    return sum(((x - c) / r) ** 2 for x, c, r in zip(p, centre, radii))


def short(x, digits):
    text = f"{x:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text.replace("0.", ".", 1) if text.lstrip("-").startswith("0.") else text


def tuft(rng, hairs, name):
    """Hairs of length 1 about the origin: they rise along y and bend towards x."""
    points, widths, indices = [], [], []
    for i in range(hairs):
        angle, radius = rng.uniform(0, 2 * math.pi), 0.24 * math.sqrt(rng.random())
        root = (radius * math.cos(angle), -0.12, radius * math.sin(angle))
        length = rng.uniform(0.75, 1.1)
        lean, side = rng.gauss(0.85, 0.16), rng.gauss(0, 0.16)
        pull = 0.35  # tips of a tuft come together
        for t in (0.0, 0.36, 0.7, 1.0):
            away = length * lean * t ** 1.5
            up = length * (t - 0.42 * t * t)
            points += [root[0] * (1 - pull * t) + away, root[1] + up, root[2] * (1 - pull * t) + length * side * t]
        widths += [0.027, 0.008]
        indices.append(rng.randrange(100000))
    numbers = lambda values, digits: " ".join(short(v, digits) for v in values)
    return (f'ObjectBegin "{name}"\nCurves "cubic" [{" ".join(["4"] * hairs)}] "nonperiodic"\n'
            f'"P" [{numbers(points, 3)}]\n"varying float width" [{numbers(widths, 3)}]\n'
            f'"uniform float hair" [{numbers(indices, 0)}]\nObjectEnd\n')


def color_at(rng, piece, p, normal):
    color = COLORS[piece[4]]
    if piece[0] in ("body", "head"):
        # a light front and a dark stripe along the back
        front = max(0.0, min(1.0, (-normal[2] - 0.62) * 4))
        stripe = math.exp(-((p[0] / 0.12) ** 2)) * max(0.0, min(1.0, (normal[2] + 0.2) * 3))
        if piece[0] == "head":
            front *= 0.35
        color = tuple(c + front * (l - c) for c, l in zip(color, COLORS["light"]))
        color = tuple(c + stripe * (d - c) for c, d in zip(color, COLORS["dark"]))
    scale = math.exp(rng.gauss(0, 0.10))
    return tuple(min(0.92, c * scale) for c in color)


def coat(rng, spacing, tufts):
    out, cells = [], {}
    areas = []
    for piece in PIECES:
        a, b, c = piece[2]
        areas.append(((a * b) ** 1.6 + (a * c) ** 1.6 + (b * c) ** 1.6) ** (1 / 1.6))
    for piece, area in zip(PIECES, areas):
        _, centre, radii, length, _ = piece
        gap = spacing * min(max(length / 0.1, 0.5), 1.7)
        for _ in range(int(area * 8 * 4 * math.pi / 3 / (gap * gap))):
            d = unit([rng.gauss(0, 1) for _ in range(3)])
            p = tuple(c + r * x for c, r, x in zip(centre, radii, d))
            if any(depth(p, other) < 0.97 for other in PIECES if other is not piece) or p[1] < 0.03:
                continue
            if any(dot(add(p, e, -1), add(p, e, -1)) < 0.072 ** 2 for e in EYES):
                continue
            key = tuple(int(math.floor(x / gap)) for x in p)
            near = (cells.get((piece[0], key[0] + i, key[1] + j, key[2] + k), [])
                    for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1))
            if any(dot(add(p, q, -1), add(p, q, -1)) < gap * gap for cell in near for q in cell):
                continue
            cells.setdefault((piece[0],) + key, []).append(p)
            n = unit([x / r for x, r in zip(d, radii)])
            # from the nose backwards, then down
            flow = add(unit(add(p, NOSE, -1)), (0, -1.4 if piece[0] in ("body", "left arm", "right arm", "tail") else -0.25, 0.35))
            flow = add(flow, [rng.gauss(0, 0.18) for _ in range(3)])
            x = unit(add(flow, n, -dot(flow, n)))
            z = cross(x, n)
            s = length * rng.uniform(0.85, 1.15)
            rows = [s * v for axis in (x, n, z) for v in axis]
            m = " ".join([short(v, 3) + (" 0" if k % 3 == 2 else "") for k, v in enumerate(rows)] + [short(v, 3) for v in p])
            color = " ".join(short(c, 2) for c in color_at(rng, piece, p, n))
            out.append(f'AttributeBegin Color [{color}]ConcatTransform [{m} 1]ObjectInstance "t{rng.randrange(tufts)}"AttributeEnd\n')
    return out


HEAD = '''##RenderMan RIB-Structure 1.1
# A furry animal. Written by tools/make_fur.py; {count} tufts of {hairs} hairs.
Hider "raytrace" "int maxsamples" [128]
Integrator "PxrPathTracer" "integrator" "int maxIndirectBounces" [12]
Display "fur.exr" "openexr" "rgba"
Display "+fur.png" "png" "rgb"
Format 640 360 1
PixelFilter "gaussian" 2 2
Projection "perspective" "fov" [25.5]
Translate 0 -0.9 5.2
Rotate -7 1 0 0
Rotate 24 0 1 0
WorldBegin
  AttributeBegin  # from the left and above
    Rotate -24 0 1 0
    Translate -2.6 3.2 -2.4  Rotate 47 0 1 0  Rotate 40 1 0 0
    Scale 1.5 1.5 1
    Light "PxrRectLight" "key" "float intensity" [13] "color lightColor" [1 0.93 0.84]
  AttributeEnd
  AttributeBegin  # from behind, through the coat
    Rotate -24 0 1 0
    Translate 2.2 2.5 3.0  Rotate 215 0 1 0  Rotate 25 1 0 0
    Scale 1.4 1.6 1
    Attribute "visibility" "int camera" [0]
    Light "PxrRectLight" "rim" "float intensity" [26] "color lightColor" [0.85 0.92 1]
  AttributeEnd
  AttributeBegin
    Light "PxrDomeLight" "sky" "float intensity" [0.1] "color lightColor" [0.7 0.85 1]
  AttributeEnd
  AttributeBegin
    Bxdf "PxrDiffuse" "ground" "color diffuseColor" [0.14 0.15 0.16]
    Polygon "vertex point P" [-40 0 -40  40 0 -40  40 0 40  -40 0 40]
  AttributeEnd
  AttributeBegin
    Bxdf "PxrSurface" "glossy black" "color diffuseColor" [0.01 0.008 0.006] "int specularFresnelMode" [1]
      "color specularEdgeColor" [1 1 1] "float specularRoughness" [0.08]
    AttributeBegin Translate -0.165 1.42 -0.545 Sphere 0.075 -0.075 0.075 360 AttributeEnd
    AttributeBegin Translate 0.165 1.42 -0.545 Sphere 0.075 -0.075 0.075 360 AttributeEnd
    AttributeBegin Translate 0 1.275 -0.715 Scale 1.3 0.85 0.8 Sphere 0.048 -0.048 0.048 360 AttributeEnd
  AttributeEnd
  AttributeBegin
    Bxdf "PxrDiffuse" "skin" "color diffuseColor" [0.22 0.13 0.09]
{skin}  AttributeEnd
  Pattern "PxrPrimvar" "coat" "string varname" ["Cs"] "string type" ["color"]
  Pattern "PxrHairColor" "hairColor" "int mode" [1] "reference color color" ["coat:resultRGB"]
    "color randomColor" [0.25 0.25 0.25] "string hairIndexPrimvar" ["hair"] "float strayDensity" [0.02]
    "color strayColor" [0.85 0.8 0.7] "float darkenRoots" [0.12]
  Bxdf "PxrMarschnerHair" "fur" "float diffuseGain" [0.25] "reference color diffuseColor" ["hairColor:resultDiff"]
    "reference color specularColorTT" ["hairColor:resultTT"] "reference color specularColorTRT" ["hairColor:resultTRT"]
    "float specularConeAngleR" [7] "float specularConeAngleTT" [10] "float specularConeAngleTRT" [13]
    "float specularEnergyCompensation" [1]
  Attribute "dice" "int roundcurve" [1]
  Basis "b-spline" 1 "catmull-rom" 1
'''


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("output", nargs="?", default="scenes/fur.rib")
    parser.add_argument("--hairs", type=int, default=56, help="hairs of a tuft")
    parser.add_argument("--spacing", type=float, default=0.0215, help="between tufts of hair .1 long")
    args = parser.parse_args()
    rng = random.Random(5)
    tufts = 6
    prototypes = "".join(tuft(rng, args.hairs, f"t{k}") for k in range(tufts))
    placed = coat(rng, args.spacing, tufts)
    skin = "".join(f"    AttributeBegin Translate {c[0]} {c[1]} {c[2]} Scale {r[0]} {r[1]} {r[2]} "
                   f"Sphere 0.985 -0.985 0.985 360 AttributeEnd\n" for _, c, r, _, _ in PIECES)
    with open(args.output, "w", encoding="utf-8") as f:
        f.write(HEAD.format(count=len(placed), hairs=args.hairs, skin=skin))
        f.write(prototypes)
        f.writelines(placed)
        f.write("WorldEnd\n")


if __name__ == "__main__":
    main()
