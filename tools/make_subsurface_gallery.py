#!/usr/bin/env python3
"""Writes scenes/candle.rib (a candle lit by its own flame), scenes/blocks.rib (blocks of milk, wax and soap with the
light behind them), scenes/head.rib (a head with closed eyes whose skin lets light through at the ears) and scenes/milk.rib
(milk in a tumbler and cloudy glass).

The outputs are committed; run this again only to change them. y is up, z goes into the picture, one unit is a
decimetre.
"""
import math

from make_wax import CUBE, EDGES, SCENES, lathe, mesh, thing


def head_of(name, comment, size, samples, bounces, fov, view, clamp=0):
    clamped = f' "float clampLuminance" [{clamp}]' if clamp else ""
    return f'''##RenderMan RIB-Structure 1.1
# Written by tools/make_subsurface_gallery.py: {comment}
Hider "raytrace" "int maxsamples" [{samples}] "int minsamples" [{samples}]
Integrator "PxrPathTracer" "integrator" "int maxIndirectBounces" [{bounces}]{clamped}
Option "searchpath" "string shader" ["shaders"]
Display "{name}.exr" "openexr" "rgba"
Display "+{name}.png" "png" "rgb"
Format {size} 1
PixelFilter "gaussian" 2 2
Projection "perspective" "fov" [{fov}]
{view}
WorldBegin
'''


def surface(name, color, reach, by, roughness, more=""):
    return (f'    Bxdf "PxrSurface" "{name}" "float diffuseGain" [0] "float subsurfaceGain" [1] "int subsurfaceType" [4]\n'
            f'      "color subsurfaceColor" [{color}] "float subsurfaceDmfp" [{reach}] "color subsurfaceDmfpColor" [{by}]\n'
            f'      "float unitLength" [1] "int specularFresnelMode" [1] "color specularEdgeColor" [1 1 1] "int specularModelType" [1]\n'
            f'      "color specularIor" [1.42 1.42 1.42] "float specularRoughness" [{roughness}]{more}\n')


def spline(keys, x):
    """Catmull and Rom through (x, value) in falling order of x; beyond the ends the end."""
    if x >= keys[0][0]:
        return keys[0][1]
    if x <= keys[-1][0]:
        return keys[-1][1]
    k = next(i for i in range(len(keys) - 1) if keys[i + 1][0] <= x)
    at = [keys[max(0, min(len(keys) - 1, k + d))] for d in (-1, 0, 1, 2)]
    t = (at[1][0] - x) / (at[1][0] - at[2][0])
    slope = lambda a, b: (b[1] - a[1]) / (b[0] - a[0]) * (at[2][0] - at[1][0])
    m0, m1 = slope(at[0], at[2]), slope(at[1], at[3])
    return ((2 * t**3 - 3 * t**2 + 1) * at[1][1] + (t**3 - 2 * t**2 + t) * m0 + (3 * t**2 - 2 * t**3) * at[2][1] +
            (t**3 - t**2) * m1)


# By height: how far the head reaches forward, back and to the side.
SECTIONS = [(1.19, 0.18, 0.24, 0.18), (1.1, 0.46, 0.56, 0.43), (0.9, 0.77, 0.84, 0.65), (0.6, 0.91, 1.02, 0.76),
            (0.25, 0.92, 1.07, 0.78), (0.0, 0.87, 1.03, 0.75), (-0.3, 0.84, 0.92, 0.69), (-0.6, 0.81, 0.76, 0.59),
            (-0.85, 0.76, 0.64, 0.47), (-0.98, 0.62, 0.59, 0.4), (-1.08, 0.36, 0.57, 0.37), (-1.3, 0.26, 0.57, 0.38),
            (-1.55, 0.27, 0.6, 0.42), (-1.78, 0.36, 0.66, 0.56), (-1.86, 0.36, 0.64, 0.56)]
# Forward, at x and y: how far, and how wide; on both sides.
FEATURES = [(0, 0.02, 0.1, 0.1, 0.2), (0, -0.22, 0.25, 0.12, 0.13), (0.13, -0.28, 0.1, 0.06, 0.07),
            (0.3, 0.12, -0.17, 0.17, 0.13), (0.3, 0.08, 0.12, 0.13, 0.085), (0.3, 0.28, 0.06, 0.24, 0.07),
            (0.4, -0.2, 0.06, 0.2, 0.2), (0.09, -0.49, 0.07, 0.1, 0.05), (0, -0.625, 0.09, 0.16, 0.05),
            (0, -0.555, -0.045, 0.2, 0.022), (0.25, -0.56, -0.04, 0.06, 0.07), (0, -0.76, -0.05, 0.2, 0.06),
            (0, -0.92, 0.1, 0.2, 0.11), (0, -0.4, -0.02, 0.03, 0.06)]


def rows_of_head():
    # closely where the face is
    rows, y = [], 1.19
    while y > -1.86:
        rows.append(y)
        y -= 0.042 if -0.75 < y < 0.35 else 0.085
    return rows + [-1.86]


def head(rows):
    columns = 60

    def place(v, u):
        r = round(v * (len(rows) + 1))
        if r == 0:
            return 0, 1.22, 0
        if r == len(rows) + 1:
            return 0, -1.87, 0.1
        y = rows[r - 1]
        # closely in front
        a = 2 * math.pi * u
        a -= 0.45 * math.sin(a)
        front, back, side = (spline([(s[0], s[k]) for s in SECTIONS], y) for k in (1, 2, 3))
        c, s = math.cos(a), math.sin(a)
        x, z = side * s, -(front if c > 0 else back) * c
        if c > 0:
            for fx, fy, far, wx, wy in FEATURES:
                for sign in ((1,) if fx == 0 else (1, -1)):
                    z -= far * math.exp(-((x - sign * fx) / wx)**2 - ((y - fy) / wy)**2) * min(1, 2 * c)
        turn = abs(math.remainder(a, 2 * math.pi))
        tall = 0.27 * (1 - 0.25 * min(0, y) ** 2)
        ear = math.exp(-((y - 0.02) / tall)**4 - ((turn - 1.75) / 0.1)**2)
        out = 0.34 * ear
        # the rim leans back and is thicker than the leaf before it
        return x + math.copysign(out, s), y + 0.04 * ear, z + 0.24 * ear**1.5

    return lathe(len(rows) + 1, columns, place)


def candle(height, hollow):
    keys = [(0, height - hollow), (0.2, height - hollow), (0.33, height - 0.8 * hollow), (0.385, height - 0.3 * hollow),
            (0.4, height), (0.425, height + 0.02), (0.45, height - 0.03), (0.45, height - 0.2), (0.45, 0.5 * height),
            (0.45, 0.2), (0.45, 0.03), (0.43, 0), (0, 0)]

    def place(v, u):
        r, y = keys[round(v * 12)]
        a = 2 * math.pi * u
        run = max(0, min(1, (y / height - 0.2) / 0.8))
        drip = 1 + (0.03 * math.sin(3 * a) + 0.035 * math.sin(8 * a + 1)) * run if r > 0.44 else 1
        lip = 0.05 * math.sin(3 * a + 0.4) + 0.03 * math.sin(5 * a + 2) if r > 0.35 and y > height - 0.1 else 0
        return r * drip * math.cos(a), y + lip, r * drip * math.sin(a)

    return lathe(12, 28, place)


TABLE = '''    Bxdf "PxrSurface" "table" "color diffuseColor" [{0}] "int specularFresnelMode" [1] "color specularEdgeColor" [1 1 1]
      "color specularIor" [1.45 1.45 1.45] "int specularModelType" [1] "float specularRoughness" [{1}]
    Polygon "vertex point P" [-20 0 -12  -20 0 {2}  20 0 {2}  20 0 -12]
    Polygon "vertex point P" [-20 0 {2}  -20 15 {2}  20 15 {2}  20 0 {2}]
'''


def rect(name, at, towards, size, intensity, color):
    """A rectangle that emits towards a point; the camera does not see it."""
    cross = lambda a, b: [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    unit = lambda a: [v / math.hypot(*a) for v in a]
    z = unit([t - o for t, o in zip(towards, at)])
    x = unit(cross([0, 1, 0], z))
    rows = [[size[0] * v for v in x], [size[1] * v for v in cross(z, x)], z]
    matrix = "  ".join(" ".join(f"{v:.3f}" for v in row) + f" {w}" for row, w in zip(rows + [at], (0, 0, 0, 1)))
    return (f'  AttributeBegin\n    Attribute "visibility" "int camera" [0]\n    ConcatTransform [{matrix}]\n'
            f'    Light "PxrRectLight" "{name}" "float intensity" [{intensity}] "color lightColor" [{color}]\n  AttributeEnd\n')


def dome(intensity, color):
    return (f'  AttributeBegin\n    # the dome\'s own up is z: it becomes y\n    Attribute "visibility" "int camera" [0]\n'
            f'    ConcatTransform [0 0 -1 0  -1 0 0 0  0 1 0 0  0 0 0 1]\n'
            f'    Light "PxrDomeLight" "fill" "float intensity" [{intensity}] "color lightColor" [{color}]\n  AttributeEnd\n')


def write_candle():
    out = head_of("candle", "a flame is a medium that emits, and lights the wax from within.", "270 360", 256, 5, 24,
                  "Rotate -9 1 0 0\nTranslate 0.05 -2.05 6.6", clamp=2.5)
    out += dome(0.05, "0.5 0.65 1")
    out += thing("room", "", TABLE.format("0.16 0.09 0.05", 0.35, "2.5"))
    wax = surface("wax", "0.95 0.86 0.68", 0.5, "1 0.62 0.3", 0.35)
    out += thing("candle", "Translate 0 0.06 0", wax + mesh(*candle(1.5, 0.28)))
    out += thing("stub", "Translate 0.98 0 0.55 Rotate 50 0 1 0", wax + mesh(*candle(0.62, 0.12)))
    wick = '    Bxdf "PxrDiffuse" "soot" "color diffuseColor" [0.03 0.025 0.02]\n    Curves "cubic" [4] "nonperiodic" "P" [{}] "constantwidth" [0.035]\n'
    out += thing("wick", "", wick.format("0 1.2 0  0 1.4 0  0 1.48 0  0.06 1.53 0"))
    out += thing("cold wick", "", wick.format("0.98 0.4 0.55  0.98 0.6 0.55  0.97 0.66 0.55  0.9 0.68 0.52"))
    out += thing("dish", "", '    Bxdf "PxrSurface" "brass" "color diffuseColor" [0 0 0] "color specularFaceColor" [0.88 0.67 0.33] "color specularEdgeColor" [1 0.95 0.85]\n'
                 '      "int specularModelType" [1] "float specularRoughness" [0.25]\n'
                 '    AttributeBegin Translate 0 0.05 0 Scale 1 0.06 1 Rotate 90 1 0 0 Sphere 0.62 -0.62 0.62 360 AttributeEnd\n'
                 '    AttributeBegin Translate 0 0.075 0 Rotate 90 1 0 0 Torus 0.6 0.028 0 360 360 AttributeEnd\n')
    out += thing("flame", "Translate 0.02 1.72 0 Scale 0.2 0.32 0.2",
                 '    Pattern "candle_flame" "gas" "float power" [480]\n'
                 '    Bxdf "PxrVolume" "flame" "float densityFloat" [0] "reference color emitColor" ["gas:glow"]\n'
                 '    Volume "box" [-1 1 -1 1 -1 1] [0 0 0]\n')
    (SCENES / "candle.rib").write_text(out + "WorldEnd\n")


def write_blocks():
    out = head_of("blocks", "blocks of milk, wax, soap and marble before a low light.", "480 270", 256, 5, 20,
                  "Rotate -14 1 0 0\nTranslate 0 -2.05 7")
    out += rect("window", (-1.9, 2.4, 3.6), (0, 0.4, 0), (2.2, 1.6), 75, "1 0.86 0.68")
    out += rect("key", (-4, 4, -4), (0, 0.3, 0), (2, 2), 5, "0.95 0.97 1")
    out += dome(0.1, "0.75 0.87 1")
    out += thing("room", "", TABLE.format("0.16 0.16 0.17", 0.65, "9"))
    creases = ('["crease"' + ' "crease"' * (len(EDGES) - 1) + "] [" + " ".join(["2 1"] * len(EDGES)) + "] [" +
               " ".join(f"{a} {b}" for a, b in EDGES) + "] [" + " ".join(["2.6"] * len(EDGES)) + "] ")
    block = mesh(*CUBE, tags=creases)
    for name, place, material in [
            ("milk", "Translate -1.55 0 0.3 Rotate 24 0 1 0 Scale 0.9 1.35 1.1", surface("milk", "0.97 0.96 0.92", 0.3, "1 0.85 0.7", 0.15)),
            ("wax", "Translate -0.45 0 -0.15 Rotate -16 0 1 0 Scale 0.9 1.0 1.1", surface("wax", "0.94 0.6 0.2", 0.2, "1 0.55 0.3", 0.35)),
            ("soap", "Translate 0.6 0 0.35 Rotate 12 0 1 0 Scale 0.9 1.5 1.1", surface("soap", "0.62 0.88 0.68", 0.24, "0.5 1 0.6", 0.25)),
            ("rose", "Translate 1.6 0 0.0 Rotate -28 0 1 0 Scale 0.9 0.9 1.1", surface("rose", "0.92 0.55 0.52", 0.16, "1 0.5 0.45", 0.4)),
            ("slice", "Translate -0.46 0.64 -0.15 Rotate 20 0 1 0 Scale 0.75 0.25 0.8", surface("cheese", "0.96 0.78 0.36", 0.12, "1 0.7 0.4", 0.3))]:
        out += thing(name, place, material + block)
    (SCENES / "blocks.rib").write_text(out + "WorldEnd\n")


def write_head():
    out = head_of("head", "skin by random walks; the light behind comes through the ears.", "320 400", 256, 4, 25,
                  "Rotate -2 1 0 0\nTranslate 0 -0.05 7.6")
    out += rect("key", (-3.6, 3, -4), (0, 0, 0), (2, 2), 15, "1 0.93 0.84")
    out += rect("rim", (2.4, 1.1, 2.6), (0.3, 0.1, 0), (1.2, 2), 60, "1 0.82 0.62")
    out += dome(0.13, "0.72 0.84 1")
    out += thing("wall", "", '    Bxdf "PxrDiffuse" "wall" "color diffuseColor" [0.12 0.13 0.15]\n'
                 '    Polygon "vertex point P" [-20 -10 7  -20 15 7  20 15 7  20 -10 7]\n'
                 '    Polygon "vertex point P" [-20 -1.84 -12  -20 -1.84 7  20 -1.84 7  20 -1.84 -12]\n')
    skin = ('    Pattern "skin" "skin"\n' +
            surface("skin", "0.8 0.6 0.5", 0.11, "1 0.4 0.22", 0.42,
                    '\n      "reference color subsurfaceColor" ["skin:albedo"] "reference float specularRoughness" ["skin:roughness"]'))
    skin = skin.replace('"color subsurfaceColor" [0.8 0.6 0.5] ', "").replace(' "float specularRoughness" [0.42]', "")
    out += thing("head", "Rotate 22 0 1 0 Rotate 3 1 0 0", skin + mesh(*head(rows_of_head())))
    (SCENES / "head.rib").write_text(out + "WorldEnd\n")


def write_milk():
    """Insides of PxrSurface: milk in a tumbler, a marble of cloudy glass, and a block of resin with dye."""
    out = head_of("milk", "milk in a tumbler and cloudy glass: surfaces that refract, and what fills them.", "320 240", 128,
                  48, 20, "Rotate -11 1 0 0\nTranslate 0.1 -1.62 6.2")
    out += rect("window", (-2.2, 2.6, 3.4), (0, 0.4, 0), (2.2, 1.8), 26, "1 0.9 0.76")
    out += rect("key", (-3.6, 4, -4), (0, 0.3, 0), (2.4, 2.4), 5, "0.86 0.93 1")
    out += dome(0.12, "0.75 0.87 1")
    out += thing("room", "", TABLE.format("0.22 0.19 0.16", 0.5, "9"))

    def turned(profile, columns=24):
        return lathe(len(profile) - 1, columns, lambda v, u: (
            profile[round(v * (len(profile) - 1))][0] * math.cos(2 * math.pi * u), profile[round(v * (len(profile) - 1))][1],
            profile[round(v * (len(profile) - 1))][0] * math.sin(2 * math.pi * u)))

    def cloudy(name, ior, extinction, albedo, g, color="1 1 1"):
        return (f'    Bxdf "PxrSurface" "{name}" "float diffuseGain" [0] "float refractionGain" [1] "float reflectionGain" [1]\n'
                f'      "float glassRoughness" [0] "float glassIor" [{ior}] "color refractionColor" [{color}]\n'
                f'      "color extinction" [{extinction}] "color ssAlbedo" [{albedo}] "float g" [{g}] "int multiScatter" [1]\n')

    tumbler = [(0, 0.14), (0.28, 0.14), (0.325, 0.2), (0.345, 0.6), (0.365, 1.12), (0.372, 1.15), (0.385, 1.15), (0.392, 1.12),
               (0.375, 0.6), (0.355, 0.06), (0.34, 0.02), (0, 0.02)]
    milk = [(0, 0.86), (0.3, 0.86), (0.352, 0.862), (0.3605, 0.85), (0.351, 0.6), (0.331, 0.2), (0.29, 0.132), (0, 0.132)]
    place = "Translate -0.42 0 0.1"
    out += thing("tumbler", place + ' Attribute "trace" "int intersectpriority" [2]',
                 '    Bxdf "PxrSurface" "glass" "float diffuseGain" [0] "float refractionGain" [1] "float reflectionGain" [1]\n'
                 '      "float glassRoughness" [0] "float glassIor" [1.5]\n' + mesh(*turned(tumbler)))
    out += thing("milk", place + ' Attribute "trace" "int intersectpriority" [1]',
                 cloudy("milk", 1.35, "15 16 19", "0.9992 0.9985 0.994", 0.6) + mesh(*turned(milk)))
    out += thing("marble", "Translate 0.42 0.27 -0.35", cloudy("opal", 1.5, "2.2 3.2 5", "0.97 0.985 0.99", 0.2) +
                 "    Sphere 0.27 -0.27 0.27 360\n")
    creases = ('["crease"' + ' "crease"' * (len(EDGES) - 1) + "] [" + " ".join(["2 1"] * len(EDGES)) + "] [" +
               " ".join(f"{a} {b}" for a, b in EDGES) + "] [" + " ".join(["3.5"] * len(EDGES)) + "] ")
    out += thing("resin", "Translate 0.62 0 0.62 Rotate 24 0 1 0 Scale 0.7 1.15 0.9",
                 cloudy("resin", 1.45, "1.2 3.5 7", "0.96 0.8 0.4", 0.3) + mesh(*CUBE, tags=creases))
    (SCENES / "milk.rib").write_text(out + "WorldEnd\n")


if __name__ == "__main__":
    write_candle()
    write_blocks()
    write_head()
    write_milk()
