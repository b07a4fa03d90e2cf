#!/usr/bin/env python3
"""Writes scenes/wax.rib: what light does below a surface. A waxen idol with thin ears (a subdivision mesh), a candle, a
block of milk glass with soft edges, a ring of jade and a ball of skin by a profile, before a low warm light behind
them.

The output is committed; run this again only to change it. y is up, z goes into the picture, one unit is a decimetre.
"""
import math
import pathlib

SCENES = pathlib.Path(__file__).resolve().parent.parent / "scenes"


def number(x):
    text = f"{x:.3f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def numbers(values):
    return " ".join(number(v) for v in values)


def wrap(text, width=116):
    lines, line = [], ""
    for word in text.split(" "):
        if len(line) + len(word) + 1 > width:
            lines.append(line)
            line = ""
        line = f"{line} {word}" if line else word
    return "\n    ".join(lines + [line])


def lathe(rows, columns, place):
    """Faces and points of a closed cage: two poles and rows of columns between them."""
    points = [place(0, 0)]
    for r in range(1, rows):
        points += [place(r / rows, c / columns) for c in range(columns)]
    points.append(place(1, 0))
    at = lambda r, c: 0 if r == 0 else len(points) - 1 if r == rows else 1 + (r - 1) * columns + c % columns
    faces = []
    for r in range(rows):
        for c in range(columns):
            ring = [at(r, c), at(r, c + 1), at(r + 1, c + 1), at(r + 1, c)]
            faces.append([v for i, v in enumerate(ring) if v not in ring[:i]])
    return faces, points


def mesh(faces, points, tags=""):
    counts = wrap(" ".join(str(len(f)) for f in faces))
    corners = wrap(" ".join(str(v) for f in faces for v in f))
    return f'    SubdivisionMesh "catmull-clark" [{counts}]\n    [{corners}]\n    {tags}"vertex point P" [{wrap(numbers(x for p in points for x in p))}]\n'


def sphere(v, u):
    a, b = math.pi * v, 2 * math.pi * u
    return math.sin(a) * math.cos(b), math.cos(a), math.sin(a) * math.sin(b)


def idol(v, u):
    x, y, z = sphere(v, u)
    bump = lambda ax, ay, az, width: math.exp(-(math.acos(max(-1, min(1, x * ax + y * ay + z * az))) / width) ** 2)
    px, py, pz = 0.62 * x, 0.74 * y, 0.58 * z
    ear = bump(0.83, 0.55, 0, 0.3) + bump(-0.83, 0.55, 0, 0.3)
    px, py, pz = px * (1 + 0.85 * ear), py * (1 + 1.0 * ear), pz * (1 - 0.82 * min(1, ear)) + 0.05 * ear
    nose = bump(0, -0.12, -0.99, 0.2)
    pz -= 0.26 * nose
    eyes = bump(0.33, 0.26, -0.9, 0.17) + bump(-0.33, 0.26, -0.9, 0.17)
    pz += 0.1 * eyes
    mouth = bump(0.14, -0.5, -0.85, 0.14) + bump(-0.14, -0.5, -0.85, 0.14) + bump(0, -0.53, -0.84, 0.13)
    pz += 0.07 * mouth
    return px, py + 0.72, pz


def candle(v, u):
    # down the axis of the hollow, over the rim, down the side and to the middle of the foot
    shape = [(0, 1.28), (0.16, 1.28), (0.27, 1.33), (0.34, 1.47), (0.39, 1.49), (0.42, 1.44), (0.42, 1.2), (0.42, 0.6),
             (0.42, 0.05), (0.4, 0), (0, 0)]
    r, y = shape[round(v * 10)]
    a = 2 * math.pi * u
    drip = 1 + (0.05 * math.sin(3 * a) + 0.04 * math.sin(7 * a + 1)) * max(0, min(1, (y - 0.2) / 1.2)) if r > 0.41 else 1
    lip = 0.05 * math.sin(3 * a) + 0.03 * math.sin(5 * a + 2) if y > 1.3 else 0
    return r * drip * math.cos(a), y + lip, r * drip * math.sin(a)


CUBE = ([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]],
        [(x, y, z) for x in (-0.4, 0.4) for y in (0, 0.62) for z in (-0.3, 0.3)])
EDGES = [(0, 1), (1, 3), (3, 2), (2, 0), (4, 5), (5, 7), (7, 6), (6, 4), (0, 4), (1, 5), (2, 6), (3, 7)]


def material(name, kind, color, reach, by, more=""):
    return (f'    Bxdf "PxrSurface" "{name}" "float diffuseGain" [0] "float subsurfaceGain" [1] "int subsurfaceType" [{kind}]\n'
            f'      "color subsurfaceColor" [{color}] "float subsurfaceDmfp" [{reach}] "color subsurfaceDmfpColor" [{by}]\n'
            f'      "float unitLength" [1] "int specularFresnelMode" [1] "color specularEdgeColor" [1 1 1] "int specularModelType" [1]\n'
            f'      "color specularIor" [1.42 1.42 1.42]{more}\n')


def thing(name, place, body):
    return f'  AttributeBegin\n    Attribute "identifier" "string name" ["{name}"]\n    {place}\n{body}  AttributeEnd\n'


def main():
    creases = '["crease" ' + '"crease" ' * (len(EDGES) - 1) + "] [" + "2 1 " * len(EDGES) + "] [" + \
              " ".join(f"{a} {b}" for a, b in EDGES) + "] [" + "3 " * len(EDGES) + "] "
    creases = creases.replace('" ]', '"]').replace(" ]", "]")
    out = '''##RenderMan RIB-Structure 1.1
# Written by tools/make_wax.py: subsurface scattering by random walks and, on the ball, by a profile of diffusion.
Hider "raytrace" "int maxsamples" [128] "int minsamples" [128]
Integrator "PxrPathTracer" "integrator" "int maxIndirectBounces" [6]
DisplayChannel "color Ci"
DisplayChannel "float a"
Display "wax.exr" "openexr" "rgba"
Display "+wax.png" "png" "rgba"
Format 768 432 1
PixelFilter "gaussian" 2 2
Projection "perspective" "fov" [25]
# the eye stands at (0, 2.1, -8) and looks 9 degrees down
ConcatTransform [1 0 0 0  0 0.98769 -0.15643 0  0 0.15643 0.98769 0  0 0 0 1]
Translate 0 -2.1 8
WorldBegin
  AttributeBegin
    # behind and to the right: 2 by 2 at (2.6, 3, 4.2), turned to the middle; +z is the side that emits
    Attribute "visibility" "int camera" [0]
    ConcatTransform [1.7 0 1.06 0  -0.47 1.8 0.75 0  -0.49 -0.43 -0.79 0  2.6 3 4.2 1]
    Light "PxrRectLight" "sun" "float intensity" [130] "color lightColor" [1 0.8 0.56]
  AttributeEnd
  AttributeBegin
    # key: 2 by 2 at (-4, 4, -4)
    ConcatTransform [1.4 0 -1.4 0  0.75 1.7 0.75 0  0.6 -0.53 0.6 0  -4 4 -4 1]
    Light "PxrRectLight" "key" "float intensity" [2.4] "color lightColor" [0.85 0.92 1]
  AttributeEnd
  AttributeBegin
    # the dome's own up is z: it becomes y
    Attribute "visibility" "int camera" [0]
    ConcatTransform [0 0 -1 0  -1 0 0 0  0 1 0 0  0 0 0 1]
    Light "PxrDomeLight" "fill" "float intensity" [0.16] "color lightColor" [0.8 0.9 1]
  AttributeEnd
  AttributeBegin
    Attribute "identifier" "string name" ["table"]
    Bxdf "PxrSurface" "slate" "color diffuseColor" [0.07 0.07 0.075] "int specularFresnelMode" [1] "color specularEdgeColor" [1 1 1]
      "color specularIor" [1.4 1.4 1.4] "float specularRoughness" [0.45]
    Polygon "vertex point P" [-30 0 -12  -30 0 40  30 0 40  30 0 -12]
  AttributeEnd
'''
    out += thing("idol", "Translate -0.2 0 0.2 Rotate -14 0 1 0",
                 material("wax", 5, "0.95 0.72 0.5", 1.3, "1 0.14 0.05", ' "float specularRoughness" [0.35] "float subsurfaceBleed" [0.4]') +
                 mesh(*lathe(22, 40, idol)))
    out += thing("candle", "Translate -1.75 0 0.5",
                 material("tallow", 4, "0.95 0.92 0.85", 0.8, "1 0.6 0.25", ' "float specularRoughness" [0.4]') +
                 mesh(*lathe(10, 28, candle)))
    out += thing("flame", "Translate -1.75 1.62 0.5",
                 '    Scale 0.06 0.16 0.06\n    Light "PxrSphereLight" "flame" "float intensity" [220] "color lightColor" [1 0.62 0.25]\n')
    out += thing("block", "Translate 1.15 0 1.2 Rotate 25 0 1 0",
                 material("milk", 4, "0.96 0.96 0.94", 0.9, "1 0.75 0.5", ' "float specularRoughness" [0.15]') +
                 mesh(*CUBE, tags=creases.replace('" "', '" "') ))
    out += thing("ring", "Translate 1.75 0.62 0 Rotate -50 0 1 0",
                 material("jade", 4, "0.6 0.86 0.66", 0.3, "0.35 1 0.4", ' "float specularRoughness" [0.1] "float subsurfaceDirectionality" [0.5]') +
                 "    Torus 0.44 0.18 0 360 360\n")
    out += thing("ball", "Translate -1.02 0.34 -0.75",
                 material("skin", 2, "0.82 0.6 0.5", 0.16, "1 0.42 0.28", ' "float specularRoughness" [0.45]') +
                 "    Sphere 0.34 -0.34 0.34 360\n")
    (SCENES / "wax.rib").write_text(out + "WorldEnd\n")


if __name__ == "__main__":
    main()
