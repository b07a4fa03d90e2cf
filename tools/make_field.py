#!/usr/bin/env python3
"""Writes scenes/field.rib and scenes/sky.hdr: a meadow of instances under a sky map, with depth of field and motion blur.

The output is committed; run this again only to change it. No random numbers but Python's seeded ones, so that a second
run writes the same bytes.
"""
import math
import pathlib
import random

SCENES = pathlib.Path(__file__).resolve().parent.parent / "scenes"
EXTENT = 9.0       # half the width of the meadow at its far end
TUFTS, FLOWERS, STONES = 2050, 300, 60


def number(x, digits=3):
    text = f"{x:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def numbers(values, digits=3):
    return " ".join(number(v, digits) for v in values)


def write_sky(path, width=256, height=128):
    """Latitude-longitude map, top row straight up: a gradient, haze at the horizon, a sun, brown ground. Radiance RGBE."""
    sun_turn, sun_from_zenith = math.radians(215), math.radians(58)

    def radiance(theta, phi):
        up = math.cos(theta)
        if up < 0:
            return (0.10, 0.09, 0.07)
        haze = math.exp(-up * 5)
        sky = [a + (b - a) * haze for a, b in zip((0.16, 0.32, 0.72), (0.85, 0.88, 0.90))]
        cosine = (math.cos(theta) * math.cos(sun_from_zenith) +
                  math.sin(theta) * math.sin(sun_from_zenith) * math.cos(phi - sun_turn))
        angle = math.degrees(math.acos(max(-1, min(1, cosine))))
        glow = 1.6 * math.exp(-angle / 9)
        disc = 2600 if angle < 1.6 else 0
        return tuple(c + glow * t + disc * t for c, t in zip(sky, (1, 0.86, 0.62)))

    def rgbe(color):
        largest = max(color)
        if largest < 1e-32:
            return bytes(4)
        mantissa, exponent = math.frexp(largest)
        scale = mantissa * 256 / largest
        return bytes([min(255, int(c * scale)) for c in color] + [exponent + 128])

    with open(path, "wb") as f:
        f.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n" + f"-Y {height} +X {width}\n".encode())
        for y in range(height):
            row = b"".join(rgbe(radiance(math.pi * (y + 0.5) / height, 2 * math.pi * (x + 0.5) / width))
                           for x in range(width))
            # run-length form with literal runs only: planes of at most 128 bytes
            f.write(bytes([2, 2, width >> 8, width & 255]))
            for plane in range(4):
                data = row[plane::4]
                for at in range(0, width, 128):
                    f.write(bytes([len(data[at:at + 128])]) + data[at:at + 128])


def grass(rng):
    """One tuft: bent blades of three quads each, as one mesh."""
    points, faces = [], []
    for _ in range(14):
        angle, lean = rng.uniform(0, 2 * math.pi), rng.uniform(0.05, 0.5)
        height, width = rng.uniform(0.25, 0.5), rng.uniform(0.010, 0.018)
        x, z = rng.gauss(0, 0.07), rng.gauss(0, 0.07)
        along, across = (math.cos(angle), math.sin(angle)), (-math.sin(angle), math.cos(angle))
        first = len(points)
        for i in range(4):
            t = i / 3
            offset, half = lean * height * t * t, width * (1 - 0.9 * t)
            for side in (-1, 1):
                points.append((x + along[0] * offset + across[0] * half * side, height * t,
                               z + along[1] * offset + across[1] * half * side))
        for i in range(3):
            a = first + 2 * i
            faces.append((a, a + 1, a + 3, a + 2))
    return points, faces


def mesh(points, faces):
    return (f"    PointsPolygons [{' '.join('4' for _ in faces)}]\n      [{' '.join(str(v) for f in faces for v in f)}]\n"
            f"      \"vertex point P\" [{numbers(c for p in points for c in p)}]\n")


def write_scene(path):
    rng = random.Random(7)
    out = ["""##RenderMan RIB-Structure 1.1
# A meadow: some 2,400 instances of a tuft of grass, a flower and a stone under a sky map, seen through a wide lens opening
# while a ball flies past and some flowers sway. Written by tools/make_field.py. y is up, z goes into the picture.
Option "searchpath" "string texture" [".:@"]
Hider "raytrace" "int maxsamples" [64] "int minsamples" [64]
Integrator "PxrPathTracer" "integrator" "int maxIndirectBounces" [3]
DisplayChannel "color Ci"
DisplayChannel "float a"
Display "field.exr" "openexr" "rgba"
Display "+field.png" "png" "rgba"
Format 640 360 1
PixelFilter "gaussian" 2 2
Shutter 0 1
DepthOfField 9 0.28 3.6
Projection "perspective" "fov" [38]
# the eye stands at (0, 0.9, -3.6) and looks 8 degrees down
ConcatTransform [1 0 0 0  0 0.99027 -0.13917 0  0 0.13917 0.99027 0  0 0 0 1]
Translate 0 -0.9 3.6
WorldBegin
  AttributeBegin
    # the dome's own up is z: it becomes y
    ConcatTransform [0 0 -1 0  -1 0 0 0  0 1 0 0  0 0 0 1]
    Light "PxrDomeLight" "sky" "string lightColorMap" ["sky.hdr"] "float intensity" [1]
  AttributeEnd
  ObjectBegin "grass"
    Bxdf "PxrDiffuse" "blade" "color diffuseColor" [0.13 0.27 0.05] "int transmissionBehavior" [1]
      "color transmissionColor" [0.10 0.20 0.02]
"""]
    out.append(mesh(*grass(rng)))
    out.append("""  ObjectEnd
  ObjectBegin "flower"
    AttributeBegin
      Bxdf "PxrDiffuse" "stem" "color diffuseColor" [0.10 0.22 0.05]
      ConcatTransform [1 0 0 0  0 0 -1 0  0 1 0 0  0 0 0 1]
      Cylinder 0.008 0 0.5 360
    AttributeEnd
    AttributeBegin
      Bxdf "PxrSurface" "heart" "color diffuseColor" [0.75 0.42 0.02] "float diffuseRoughness" [0.8]
      Translate 0 0.5 0
      Sphere 0.03 -0.03 0.03 360
    AttributeEnd
    AttributeBegin
      Bxdf "PxrDiffuse" "petal" "color diffuseColor" [0.72 0.66 0.74] "int transmissionBehavior" [1]
        "color transmissionColor" [0.20 0.16 0.20]
""")
    points, faces = [], []
    for i in range(9):
        a = 2 * math.pi * i / 9
        c, s = math.cos(a), math.sin(a)
        first = len(points)
        for r, w, h in ((0.025, 0.010, 0.500), (0.075, 0.024, 0.515), (0.120, 0.012, 0.505)):
            points += [(c * r - s * w, h, s * r + c * w), (c * r + s * w, h, s * r - c * w)]
        faces += [(first, first + 1, first + 3, first + 2), (first + 2, first + 3, first + 5, first + 4)]
    out.append(mesh(points, faces).replace("    Points", "      Points"))
    out.append("""    AttributeEnd
  ObjectEnd
  ObjectBegin "stone"
    Pattern "PxrFractal" "grain" "int layers" [5] "float frequency" [6]
    Pattern "PxrMix" "stoneColor" "color color1" [0.12 0.11 0.10] "color color2" [0.42 0.40 0.37]
      "reference float mix" ["grain:resultF"]
    Bxdf "PxrSurface" "stone" "reference color diffuseColor" ["stoneColor:resultRGB"] "float diffuseRoughness" [0.7]
    SubdivisionMesh "catmull-clark" [4 4 4 4 4 4] [0 1 2 3  7 6 5 4  0 4 5 1  1 5 6 2  2 6 7 3  3 7 4 0] [] [] [] []
      "vertex point P" [-1 -0.5 -0.9  1.1 -0.5 -1  0.9 -0.5 1  -1.1 -0.5 0.9  -0.8 0.7 -0.9  0.9 0.5 -0.7  0.7 0.6 0.9  -0.9 0.4 0.8]
  ObjectEnd

  AttributeBegin
    Attribute "identifier" "string name" ["earth"]
    Bxdf "PxrDiffuse" "earth" "color diffuseColor" [0.11 0.085 0.05]
    Polygon "vertex point P" [-60 0 -10  60 0 -10  60 0 90  -60 0 90]
  AttributeEnd
  AttributeBegin
    Attribute "identifier" "string name" ["ball"]
    Bxdf "PxrSurface" "rubber" "color diffuseColor" [0.62 0.05 0.03] "int specularFresnelMode" [1]
      "color specularEdgeColor" [1 1 1] "color specularIor" [1.5 1.5 1.5] "float specularRoughness" [0.2]
    MotionBegin [0 1]
      Translate 0.62 0.83 0.1
      Translate 0.80 0.87 0.1
    MotionEnd
    Sphere 0.17 -0.17 0.17 360
  AttributeEnd
""")

    def place(name, size, sway):
        # denser near the eye, where each instance covers more of the picture
        depth = 18 * rng.random() ** 1.6 - 2.4
        x = rng.uniform(-1, 1) * (1.1 + (depth + 2.4) * EXTENT / 15.6)
        scale = size * rng.uniform(0.7, 1.3)
        lines = [f"Translate {number(x, 2)} 0 {number(depth, 2)}"]
        if sway:
            lines.append(f"MotionBegin [0 1] Rotate 0 0 0 1 Rotate {number(rng.uniform(4, 9), 1)} 0 0 1 MotionEnd")
        lines.append(f"Rotate {rng.randrange(360)} 0 1 0 Scale {' '.join([number(scale, 2)] * 3)}")
        out.append(f"AttributeBegin {' '.join(lines)} ObjectInstance \"{name}\" AttributeEnd\n")

    for _ in range(TUFTS):
        place("grass", 1.0, False)
    for i in range(FLOWERS):
        place("flower", 0.9, i % 4 == 0)
    for _ in range(STONES):
        place("stone", 0.13, False)
    out.append("WorldEnd\n")
    path.write_text("".join(out))


write_sky(SCENES / "sky.hdr")
write_scene(SCENES / "field.rib")
