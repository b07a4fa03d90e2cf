#!/usr/bin/env python3
"""Writes scenes/osl_*.rib: six pictures whose looks are shaders of scenes/shaders. Distances are metres, or what reads as such."""
import math
import pathlib
import random

SCENES = pathlib.Path(__file__).resolve().parent.parent / "scenes"


def number(x):
    return f"{round(x, 4):g}"


def numbers(values):
    return " ".join(number(x) for x in values)


def unit(v):
    length = math.sqrt(sum(x * x for x in v))
    return [x / length for x in v]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def axes(eye, target):
    z = unit([b - a for a, b in zip(eye, target)])
    x = unit(cross([0, 1, 0] if abs(z[1]) < 0.999 else [0, 0, 1], z))
    return x, cross(z, x), z


def camera(eye, target):
    """World to camera."""
    x, y, z = axes(eye, target)
    rows = [[x[k], y[k], z[k], 0] for k in range(3)] + [[-dot(x, eye), -dot(y, eye), -dot(z, eye), 1]]
    return "ConcatTransform [" + "  ".join(numbers(r) for r in rows) + "]\n"


def area_light(name, centre, target, width, height, intensity, color):
    x, y, z = axes(centre, target)
    rows = [[width * a for a in x] + [0], [height * a for a in y] + [0], z + [0], centre + [1]]
    matrix = "  ".join(numbers(r) for r in rows)
    return (f"  AttributeBegin\n    Attribute \"visibility\" \"int camera\" [0]\n    ConcatTransform [{matrix}]\n    Light \"PxrRectLight\" \"{name}\" \"float intensity\" "
            f"[{number(intensity)}] \"color lightColor\" [{numbers(color)}]\n  AttributeEnd\n")


def sun(direction, intensity, color, extent=0.55):
    """`direction` points to it."""
    z = unit([-a for a in direction])
    x = unit(cross([0, 1, 0] if abs(z[1]) < 0.999 else [0, 0, 1], z))
    rows = [x + [0], cross(z, x) + [0], z + [0], [0, 0, 0, 1]]
    matrix = "  ".join(numbers(r) for r in rows)
    return (f"  AttributeBegin\n    ConcatTransform [{matrix}]\n    Light \"PxrDistantLight\" \"sun\" \"float intensity\" "
            f"[{number(intensity)}] \"color lightColor\" [{numbers(color)}] \"float angleExtent\" [{number(extent)}]\n  AttributeEnd\n")


def dome(intensity, color):
    return f"  Light \"PxrDomeLight\" \"air\" \"float intensity\" [{number(intensity)}] \"color lightColor\" [{numbers(color)}]\n"


def head(name, text, eye, target, fov, clamp=6, bounces=5, extra=""):
    return (f"##RenderMan RIB-Structure 1.1\n# {text}\n# Written by tools/make_shader_scenes.py. y is up, z goes into the picture.\n"
            "Hider \"raytrace\" \"int maxsamples\" [256] \"int minsamples\" [256]\n"
            f"Integrator \"PxrPathTracer\" \"integrator\" \"int maxIndirectBounces\" [{bounces}] \"float clampLuminance\" [{clamp}]\n"
            "Option \"searchpath\" \"string shader\" [\"shaders\"]\n"
            "DisplayChannel \"color Ci\"\nDisplayChannel \"float a\"\n"
            f"Display \"{name}.exr\" \"openexr\" \"rgba\"\nDisplay \"+{name}.png\" \"png\" \"rgba\"\nFormat 640 360 1\n"
            f"PixelFilter \"gaussian\" 2 2\n{extra}Projection \"perspective\" \"fov\" [{number(fov)}]\n" + camera(eye, target) + "WorldBegin\n")


def mesh(columns, rows, place, kind="bicubic", u_wrap="nonperiodic", v_wrap="nonperiodic", extra=""):
    """A b-spline patch mesh over place(i, j)."""
    points = "\n       ".join(numbers([x for i in range(columns) for x in place(i, j)]) for j in range(rows))
    return (f"    Basis \"b-spline\" 1 \"b-spline\" 1\n    PatchMesh \"{kind}\" {columns} \"{u_wrap}\" {rows} \"{v_wrap}\" \"P\" [\n       "
            f"{points}]{extra}\n")


def box(x, y, z, bevel=0.0):
    """From the origin upwards, with its faces' own texture coordinates; a bevel makes it a subdivision cage with soft edges."""
    p = [[sx * x / 2, y * sy, sz * z / 2] for sy in (0, 1) for sz in (-1, 1) for sx in (-1, 1)]
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [3, 2, 6, 7], [2, 0, 4, 6], [1, 3, 7, 5]]
    flat = [v for f in faces for v in f]
    st = "0 0 1 0 1 1 0 1 " * 6
    if bevel:
        edges = sorted({tuple(sorted((f[k], f[(k + 1) % 4]))) for f in faces for k in range(4)})
        tags = " ".join(['"crease"'] * len(edges))
        return (f"    SubdivisionMesh \"catmull-clark\" [{'4 ' * 6}] [{' '.join(map(str, flat))}] [{tags}] [{'2 1 ' * len(edges)}] "
                f"[{' '.join(f'{a} {b}' for a, b in edges)}] [{(number(bevel) + ' ') * len(edges)}] \"P\" [{numbers(c for q in p for c in q)}]\n")
    return (f"    PointsPolygons [{'4 ' * 6}] [{' '.join(map(str, flat))}] \"P\" [{numbers(c for q in p for c in q)}] "
            f"\"facevarying float[2] st\" [{st}]\n")


def floor(size, y=0.0, back=None, st=1.0):
    z = size if back is None else back
    return (f"    Polygon \"P\" [{numbers([-size, y, -size, -size, y, z, size, y, z, size, y, -size])}] "
            f"\"st\" [{numbers([0, 0, 0, st, st, st, st, 0])}]\n")


def block(name, text):
    return f"  AttributeBegin\n    Attribute \"identifier\" \"string name\" [\"{name}\"]\n{text}  AttributeEnd\n"


# ---------------------------------------------------------------------------------------------------------------- wood

def wood_material(handle, seed, heart, early, late, rings=9.0, scale=1.0, coat=0.0):
    return (f"    Pattern \"wood\" \"{handle}\" \"int seed\" [{seed}] \"vector heart\" [{numbers(heart)}] \"float rings\" [{number(rings)}] "
            f"\"float scale\" [{number(scale)}] \"color early\" [{numbers(early)}] \"color late\" [{numbers(late)}]\n"
            f"    Bxdf \"PxrSurface\" \"{handle}Material\" \"reference color diffuseColor\" [\"{handle}:resultRGB\"] "
            f"\"reference normal bumpNormal\" [\"{handle}:bump\"] \"color specularFaceColor\" [.04 .04 .04] \"color specularEdgeColor\" [1 1 1] "
            f"\"reference float specularRoughness\" [\"{handle}:roughness\"] \"color clearcoatFaceColor\" [{numbers([coat] * 3)}] "
            "\"color clearcoatEdgeColor\" [" + ("1 1 1" if coat else "0 0 0") + "] \"float clearcoatRoughness\" [.08] \"int diffuseDoubleSided\" [1]\n")


PALE = ([0.62, 0.42, 0.22], [0.4, 0.22, 0.09])
RED = ([0.42, 0.17, 0.07], [0.2, 0.06, 0.022])
DARK = ([0.2, 0.105, 0.05], [0.075, 0.034, 0.016])
HONEY = ([0.55, 0.31, 0.12], [0.3, 0.13, 0.042])


def wood():
    out = [head("osl_wood", "Toy blocks of four woods on a table: growth rings, fibres, pores and rays cut by each surface as a saw would.",
                [0.3, 4.0, -8.8], [0.4, 1.32, 0.1], 29)]
    out.append(area_light("window", [-6.5, 6.5, -3.5], [0, 0.8, 0], 4.2, 3.4, 16, [1, 0.93, 0.82]))
    out.append(area_light("rim", [6, 3.2, 5.5], [0, 1, 0], 3, 4, 5, [0.7, 0.83, 1]))
    out.append(dome(0.1, [0.85, 0.9, 1]))
    out.append(block("wall", "    Bxdf \"PxrSurface\" \"plaster\" \"color diffuseColor\" [.34 .33 .3] \"int diffuseDoubleSided\" [1]\n" + wall((-16, 9), (16, 9), -1, 12)))
    random.seed(4)
    # table: planks along x
    for k in range(12):
        z = -4.6 + 1.12 * k
        for side in range(4):
            x = -9.2 + 6.1 * side + (1.3 if k % 2 else -0.9)
            out.append(block(f"plank{k}{side}",
                wood_material("wood", 100 + 2 * k + side, [random.uniform(-.5, .5), 0, random.uniform(.35, 1.3)], *DARK, rings=11, coat=0.02) +
                f"    Translate {number(x)} -.06 {number(z)}\n    Rotate 90 0 0 1\n    Rotate 90 0 1 0\n"
                "    Translate 0 -3.03 0\n" + box(1.1, 6.06, 0.12)))
    def put(name, seed, colors, place, shape, heart=(0.35, 0, 0.5), rings=9.0, coat=0.0):
        out.append(block(name, wood_material("wood", seed, list(heart), *colors, rings=rings, coat=coat) + place + shape))
    post = box(0.72, 1.7, 0.72, 3.2)
    put("postLeft", 1, PALE, "    Translate -1.75 0 .7\n    Rotate 12 0 1 0\n", post)
    put("postRight", 2, PALE, "    Translate .15 0 .85\n    Rotate 4 0 1 0\n", post, heart=(-0.5, 0, 0.3))
    put("beam", 3, RED, "    Translate .85 1.7 .72\n    Rotate -3 0 1 0\n    Rotate 90 0 0 1\n    Translate .35 0 0\n", box(0.7, 3.3, 0.78, 3.2), heart=(0.2, 0, 1.1), rings=10, coat=0.02)
    put("cone", 4, HONEY, "    Translate -.8 2.4 .75\n    Rotate -90 1 0 0\n", "    Cone 1.15 .48 360\n    Disk 0 .48 360\n", heart=(0.1, 0.05, 0), rings=13)
    put("ball", 5, HONEY, "    Translate 1.75 .72 -.9\n    Rotate 62 1 0 .4\n", "    Sphere .72 -.72 .72 360\n", heart=(0.25, 0, 0.1), rings=8, coat=0.03)
    put("barrel", 6, RED, "    Translate -.75 .5 -1.5\n    Rotate 76 0 1 0\n    Rotate 90 1 0 0\n    Rotate 90 1 0 0\n",
        "    Cylinder .5 -.62 .62 360\n    Disk .62 .5 360\n    Disk -.62 .5 360\n", heart=(0.12, 0.1, 0.04), rings=12)
    put("cube", 7, PALE, "    Translate 2.55 0 1.35\n    Rotate 31 0 1 0\n", box(1.25, 1.25, 1.25, 3.6), heart=(0.1, 0, -0.3), rings=8)
    put("slab", 8, DARK, "    Translate 2.5 1.25 1.3\n    Rotate 8 0 1 0\n    Rotate 90 0 0 1\n    Translate .17 -.8 0\n", box(0.34, 1.6, 0.7, 3.2), heart=(0.1, 0, 0.6), coat=0.02)
    out.append("WorldEnd\n")
    (SCENES / "osl_wood.rib").write_text("".join(out))


# --------------------------------------------------------------------------------------------------------------- brick

def brick_material(handle, rows, **more):
    extra = "".join(f" \"{'color' if isinstance(v, list) else 'float'} {k}\" [{numbers(v if isinstance(v, list) else [v])}]" for k, v in more.items())
    return (f"    Pattern \"brick\" \"{handle}\" \"float rows\" [{number(rows)}]{extra}\n"
            f"    Bxdf \"PxrSurface\" \"{handle}Material\" \"reference color diffuseColor\" [\"{handle}:resultRGB\"] \"float diffuseRoughness\" [.6] "
            f"\"reference normal bumpNormal\" [\"{handle}:bump\"] \"color specularFaceColor\" [.03 .03 .03] \"color specularEdgeColor\" [.4 .4 .4] "
            f"\"float specularRoughness\" [.7] \"int diffuseDoubleSided\" [1]\n")


def wall(a, b, low, high):
    """A vertical rectangle from a to b (x, z), texture coordinates in metres."""
    width = math.dist(a, b)
    return (f"    Polygon \"P\" [{numbers([a[0], low, a[1], a[0], high, a[1], b[0], high, b[1], b[0], low, b[1]])}] "
            f"\"st\" [{numbers([0, low, 0, high, width, high, width, low])}]\n")


def brick():
    out = [head("osl_brick", "An alley in the evening sun: worn bricks in walls, a chimney and the pavement, joints that hold from near to far.",
                [0.55, 1.62, -5.4], [-0.35, 1.42, 1.5], 58, clamp=4)]
    out.append(sun([0.66, 0.52, -0.3], 15500, [1, 0.8, 0.55], 0.9))
    out.append(dome(0.3, [0.55, 0.74, 1]))
    out.append(block("wallLeft", brick_material("brick", 12.5) + wall((-2.4, -8), (-2.4, 4.2), 0, 5.5)))
    out.append(block("wallBack", brick_material("brick", 12.5) + wall((-2.4, 4.2), (-0.5, 4.2), 0, 5.5) + wall((-0.5, 4.2), (-0.5, 4.2 + 3), 0, 5.5)))
    out.append(block("wallFar", brick_material("brick", 12.5, brickColor=[0.3, 0.17, 0.12]) + wall((-0.5, 9.5), (9, 9.5), 0, 4.6)))
    out.append(block("wallRight", brick_material("brick", 11, brickColor=[0.3, 0.1, 0.06], mortarColor=[0.33, 0.31, 0.28]) +
                     wall((3.1, 9.5), (3.1, -3.2), 0, 2.3)))
    # a plinth, a buttress and a round chimney stump give the sun something to cast
    for k, z in enumerate((-2.6, 1.0)):
        t = (f"    Translate -2.22 0 {number(z)}\n")
        out.append(block(f"buttress{k}", brick_material("brick", 12.5) + t + wall((0.26, -0.32), (0.26, 0.32), 0, 3.3) +
                         wall((-0.2, -0.32), (0.26, -0.32), 0, 3.3) + wall((0.26, 0.32), (-0.2, 0.32), 0, 3.3)))
        out.append(block(f"cap{k}", "    Bxdf \"PxrSurface\" \"stone\" \"color diffuseColor\" [.4 .37 .33] \"int diffuseDoubleSided\" [1]\n" + t +
                         "    Translate .02 3.3 0\n" + box(0.62, 0.09, 0.8)))
    out.append(block("chimney", brick_material("brick", 1.0 / 0.08, aspect=2.6) + "    Translate 1.75 0 4.4\n    Rotate -90 1 0 0\n"
                     "    Cylinder .55 0 1.15 360 \"varying float s\" [0 3.456 0 3.456] \"varying float t\" [0 0 1.15 1.15]\n"))
    out.append(block("chimneyCap", "    Bxdf \"PxrSurface\" \"stone\" \"color diffuseColor\" [.42 .39 .35] \"int diffuseDoubleSided\" [1]\n    Translate 1.75 1.15 4.4\n    Rotate -90 1 0 0\n"
                     "    Cylinder .62 0 .1 360\n    Disk .1 .62 360\n"))
    out.append(block("pavement", brick_material("brick", 9, brickColor=[0.22, 0.15, 0.12], mortarColor=[0.16, 0.15, 0.13], aspect=2.0, mortar=0.1, wear=0.8, relief=0.008) +
                     "    Polygon \"P\" [-2.4 0 -9  -2.4 0 12  9 0 12  9 0 -9] \"st\" [0 0  21 0  21 11.4  0 11.4]\n"))
    out.append(block("sky", "    Attribute \"visibility\" \"int indirect\" [0] \"int transmission\" [0]\n    Pattern \"sky\" \"sky\" \"vector sun\" [.62 .3 -.46] \"float amount\" [.42]\n"
                     "    Bxdf \"PxrConstant\" \"skyMaterial\" \"reference color emitColor\" [\"sky:resultRGB\"]\n    Sphere 60 -60 60 360\n"))
    out.append("WorldEnd\n")
    (SCENES / "osl_brick.rib").write_text("".join(out))


# ---------------------------------------------------------------------------------------------------------------- rust

def rust_material(handle, amount, size, painted=1, paint=(0.06, 0.16, 0.17)):
    return (f"    Pattern \"rust\" \"{handle}\" \"float amount\" [{number(amount)}] \"float size\" [{number(size)}] \"int isPainted\" [{painted}] "
            f"\"color paint\" [{numbers(paint)}]\n"
            f"    Bxdf \"PxrDisney\" \"{handle}Material\" \"reference color baseColor\" [\"{handle}:resultRGB\"] \"reference float metallic\" [\"{handle}:metal\"] "
            f"\"reference float roughness\" [\"{handle}:roughness\"] \"reference normal bumpNormal\" [\"{handle}:bump\"]\n")


def pipe(radius, length, wall_width=0.06):
    r = radius - wall_width
    return (f"    Cylinder {number(radius)} 0 {number(length)} 360\n    Cylinder {number(r)} 0 {number(length)} 360\n"
            f"    Hyperboloid {number(radius)} 0 0  {number(r)} 0 0  360\n")


def flange(radius, z, width=0.14, bolts=8):
    text = (f"    AttributeBegin\n    Translate 0 0 {number(z)}\n    Cylinder {number(radius)} 0 {number(width)} 360\n    Disk {number(width)} {number(radius)} 360\n    Disk 0 {number(radius)} 360\n")
    for k in range(bolts):
        a = 2 * math.pi * (k + 0.5) / bolts
        x, y = 0.84 * radius * math.cos(a), 0.84 * radius * math.sin(a)
        text += (f"    AttributeBegin\n    Translate {number(x)} {number(y)} {number(-0.05)}\n    Cylinder .065 0 {number(width + 0.1)} 360\n    Disk {number(width + 0.1)} .065 360\n"
                 f"    Disk 0 .065 360\n    AttributeEnd\n")
    return text + "    AttributeEnd\n"


def rust():
    out = [head("osl_rust", "Pipes, a valve wheel and a drum, painted once: rust grows from stains, runs down and lifts the paint at its rims.",
                [-1.7, 2.15, -7.6], [0.1, 1.12, 0.4], 30)]
    out.append(area_light("sky", [-5, 7, -5], [0, 0.8, 0], 6, 5, 7, [0.88, 0.94, 1]))
    out.append(area_light("low", [7, 2.4, -1], [0, 1, 0.5], 2, 3, 7, [1, 0.8, 0.58]))
    out.append(dome(0.22, [0.75, 0.86, 1]))
    # a run of pipe across, with a flanged joint and a wheel on its valve
    out.append(block("pipe", rust_material("rust", 0.5, 0.9) + "    Translate -6 1.55 1.7\n    Rotate 90 0 1 0\n" + pipe(0.46, 12) + flange(0.72, 5.7) + flange(0.72, 5.9)))
    out.append(block("stem", rust_material("rust", 0.56, 0.6, 0) + "    Translate -.12 1.55 1.7\n    Rotate -90 1 0 0\n    Cylinder .2 0 .95 360\n    Cylinder .07 .9 1.42 360\n    Cylinder .3 .78 .95 360\n    Disk .95 .3 360\n"))
    wheel = "    Torus .52 .062 0 360 360\n    Sphere .12 -.12 .12 360\n"
    for k in range(5):
        wheel += f"    AttributeBegin\n    Rotate {72 * k + 10} 0 0 1\n    Rotate 90 0 1 0\n    Cylinder .038 .05 .5 360\n    AttributeEnd\n"
    out.append(block("wheel", rust_material("rust", 0.36, 0.5, 1, (0.42, 0.03, 0.018)) + "    Translate -.12 2.92 1.7\n    Rotate -90 1 0 0\n    Rotate 9 1 0 0\n" + wheel))
    for k, x in enumerate((-3.2, 2.9)):
        out.append(block(f"leg{k}", rust_material("rust", 0.5, 0.8, 1, (0.16, 0.15, 0.14)) + f"    Translate {number(x)} 0 1.7\n" + box(0.3, 1.2, 0.3)))
    # a drum in front and pieces of pipe on the ground
    drum = "    Cylinder .66 0 1.7 360\n    Disk 1.66 .66 360\n"
    for z in (0.02, 0.57, 1.13, 1.69):
        drum += f"    AttributeBegin\n    Translate 0 0 {number(z)}\n    Torus .66 .032 0 360 360\n    AttributeEnd\n"
    drum += "    AttributeBegin\n    Translate .34 .1 1.66\n    Cylinder .1 0 .07 360\n    Disk .07 .1 360\n    AttributeEnd\n"
    out.append(block("drum", rust_material("rust", 0.47, 1.15, 1, (0.035, 0.12, 0.26)) + "    Translate 1.7 0 -.35\n    Rotate 40 0 1 0\n    Rotate -90 1 0 0\n" + drum))
    for k, (x, z, turn, radius, length) in enumerate(((-1.55, -1.15, 62, 0.3, 1.9), (-0.75, -0.35, 74, 0.3, 2.1), (-1.2, -0.8, 66, 0.26, 1.7))):
        y = radius if k < 2 else 0.3 + 0.5
        out.append(block(f"piece{k}", rust_material("rust", 0.62 - 0.14 * (k == 2), 0.7, k % 2, (0.3, 0.29, 0.24)) + f"    Translate {number(x)} {number(y)} {number(z)}\n    Rotate {turn} 0 1 0\n    Translate 0 0 {number(-length / 2)}\n" + pipe(radius, length, 0.045)))
    out.append(block("ground", "    Pattern \"PxrFractal\" \"stains\" \"int surfacePosition\" [1] \"float frequency\" [1.3] \"int layers\" [8] \"float dimension\" [.7] \"color colorScale\" [.22 .21 .2] \"color colorOffset\" [.16 .155 .15]\n"
                     "    Bxdf \"PxrSurface\" \"concrete\" \"reference color diffuseColor\" [\"stains:resultRGB\"] \"float diffuseRoughness\" [.5] \"int diffuseDoubleSided\" [1]\n" + floor(30, 0, 30)))
    out.append(block("wall", "    Pattern \"brick\" \"bricks\" \"float rows\" [7] \"color brickColor\" [.24 .21 .19] \"color mortarColor\" [.2 .19 .18]\n"
                     "    Bxdf \"PxrSurface\" \"wallMaterial\" \"reference color diffuseColor\" [\"bricks:resultRGB\"] \"reference normal bumpNormal\" [\"bricks:bump\"] \"int diffuseDoubleSided\" [1]\n" + wall((-12, 4.2), (12, 4.2), 0, 8)))
    out.append("WorldEnd\n")
    (SCENES / "osl_rust.rib").write_text("".join(out))


# --------------------------------------------------------------------------------------------------------------- cloth

def weave_material(handle, threads, warp, weft, over=2, under=1, stripes=0, stripe=(0.45, 0.05, 0.04)):
    return (f"    Pattern \"weave\" \"{handle}\" \"float threads\" [{threads}] \"color warpColor\" [{numbers(warp)}] \"color weftColor\" [{numbers(weft)}] "
            f"\"int over\" [{over}] \"int under\" [{under}] \"int stripes\" [{stripes}] \"color stripeColor\" [{numbers(stripe)}]\n"
            f"    Bxdf \"PxrSurface\" \"{handle}Material\" \"reference color diffuseColor\" [\"{handle}:resultRGB\"] \"float diffuseRoughness\" [.7] "
            f"\"reference normal bumpNormal\" [\"{handle}:bump\"] \"float fuzzGain\" [.25] \"color fuzzColor\" [{numbers([min(1, 0.3 + c) for c in weft])}] \"float fuzzConeAngle\" [20] \"int diffuseDoubleSided\" [1]\n")


def weave():
    out = [head("osl_weave", "A tablecloth over a table's edge and a folded napkin: every thread of the twill is the shader's, with its spin and its dye.",
                [0.35, 2.0, -4.9], [0.05, 0.42, 0.0], 28, extra="")]
    out.append(area_light("window", [-4.2, 3.6, -1.2], [0, 0.6, 0.2], 3, 2.6, 12, [1, 0.94, 0.85]))
    out.append(area_light("fill", [4.5, 3, -3.5], [0, 0.6, 0], 3, 3, 2.2, [0.72, 0.84, 1]))
    out.append(dome(0.1, [0.9, 0.94, 1]))
    # the cloth lies on the table and hangs in folds in front of it
    columns, rows, edge = 48, 22, 9

    def cloth(i, j):
        x = -3.0 + 6.0 * i / (columns - 1)
        if j >= edge:  # on the table, with lazy ripples
            z = -0.85 + 3.2 * (j - edge) / (rows - 1 - edge)
            return [x, 0.6 + 0.014 * math.sin(2.2 * x + 1.3 * z) * min(1, (j - edge) / 3), z]
        down = (edge - j) / edge
        fold = down ** 0.75
        wave = math.sin(5.1 * x + 0.7 * math.sin(1.7 * x)) + 0.35 * math.sin(9.3 * x + 1)
        return [x + 0.05 * fold * math.cos(5.1 * x), 0.6 - 0.03 * min(1, down * 6) - 1.35 * down, -0.97 - 0.13 * fold * (1 + wave) - 0.02]

    out.append(block("cloth", weave_material("weave", 400, [0.055, 0.11, 0.25], [0.46, 0.45, 0.4], over=2, under=2, stripes=150, stripe=(0.4, 0.035, 0.03)) +
                     mesh(columns, rows, cloth, extra=f" \"vertex float s\" [{numbers(1.0 * i / (columns - 1) for j in range(rows) for i in range(columns))}]"
                          f" \"vertex float t\" [{numbers(0.72 * j / (rows - 1) for j in range(rows) for i in range(columns))}]")))
    # a napkin, folded twice: a soft pillow of a mesh
    n = 16

    def napkin(i, j):
        x, z = -1 + 2 * i / (n - 1), -1 + 2 * j / (n - 1)
        bulge = max(0.0, (1 - abs(x) ** 4) * (1 - abs(z) ** 4)) ** 0.5
        return [0.62 * x, 0.012 + 0.085 * bulge + 0.012 * math.sin(4 * x + 2 * z), 0.5 * z]

    for k, (place, turn) in enumerate((("-.75 .615 -.05", 18), ("-.71 .68 -.03", 12))):
        out.append(block(f"napkin{k}", weave_material("weave", 150, [0.42, 0.09, 0.045], [0.55, 0.3, 0.1], over=1, under=1) + f"    Translate {place}\n    Rotate {turn} 0 1 0\n" +
                         mesh(n, n, napkin, extra=f" \"vertex float s\" [{numbers(i / (n - 1) for j in range(n) for i in range(n))}] \"vertex float t\" [{numbers(j / (n - 1) for j in range(n) for i in range(n))}]")))
    # a bowl of oranges to eat from it
    out.append(block("bowl", "    Bxdf \"PxrSurface\" \"glaze\" \"color diffuseColor\" [.62 .63 .6] \"color specularFaceColor\" [.045 .045 .045] \"color specularEdgeColor\" [1 1 1] \"float specularRoughness\" [.12] \"int diffuseDoubleSided\" [1]\n"
                     "    Translate .72 1.1 .1\n    Rotate -90 1 0 0\n    Sphere .48 -.48 -.08 360\n    Sphere .45 -.45 -.08 360\n    Hyperboloid .4733 0 -.08  .4428 0 -.08  360\n"
                     "    Translate 0 0 -.5\n    Cylinder .2 0 .09 360\n"))
    for k, (x, y, z, r) in enumerate(((0.52, 0.98, 0.05, 0.19), (0.9, 0.99, -0.02, 0.2), (0.74, 0.97, 0.32, 0.19), (0.71, 1.23, 0.1, 0.19), (-0.05, 0.8, -0.42, 0.19))):
        out.append(block(f"orange{k}", "    Pattern \"PxrWorley\" \"pores\" \"float frequency\" [24]\n"
                         "    Bxdf \"PxrSurface\" \"peel\" \"color diffuseColor\" [.78 .25 .015] \"color specularFaceColor\" [.04 .04 .04] \"color specularEdgeColor\" [1 1 1] \"float specularRoughness\" [.3]\n"
                         f"    Translate {number(x)} {number(y)} {number(z)}\n    Sphere {number(r)} {number(-r)} {number(r)} 360\n"))
    out.append(block("wall", "    Bxdf \"PxrSurface\" \"plaster\" \"color diffuseColor\" [.36 .34 .3] \"int diffuseDoubleSided\" [1]\n" + wall((-9, 3.2), (9, 3.2), -3, 7)))
    out.append("WorldEnd\n")
    (SCENES / "osl_weave.rib").write_text("".join(out))


# --------------------------------------------------------------------------------------------------------------- paint

def paint_material(handle, facing, grazing, flake):
    return (f"    Pattern \"flakes\" \"{handle}\" \"color facing\" [{numbers(facing)}] \"color grazing\" [{numbers(grazing)}] \"color flakeColor\" [{numbers(flake)}] \"float size\" [.0055]\n"
            f"    Bxdf \"PxrSurface\" \"{handle}Material\" \"reference color diffuseColor\" [\"{handle}:resultRGB\"] \"float diffuseGain\" [.45]\n"
            f"         \"reference color specularFaceColor\" [\"{handle}:flake\"] \"reference color specularEdgeColor\" [\"{handle}:flake\"] \"reference float specularRoughness\" [\"{handle}:roughness\"]\n"
            f"         \"reference normal bumpNormal\" [\"{handle}:bump\"] \"reference normal clearcoatBumpNormal\" [\"{handle}:coat\"] \"color clearcoatFaceColor\" [.05 .05 .05] \"color clearcoatEdgeColor\" [1 1 1] \"float clearcoatRoughness\" [.012]\n")


def speed_form(length=4.4, width=1.75, height=1.05):
    """The drop that paint makers show their colours on: rounded below, creased at the shoulder, drawn out behind."""
    around, along = 22, 17

    def place(i, j):
        a = -2 * math.pi * i / around
        f = j / (along - 1)
        x = -length / 2 + length * f
        # fuller in front
        profile = math.sqrt(max(0.0, math.sin(math.pi * min(1, max(0, f)) ** 0.78)))
        profile = profile if 0 < j < along - 1 else 0.0
        c, s = math.cos(a), math.sin(a)
        up = (abs(s) ** 0.85) * (1 if s > 0 else -1)
        y = height * profile * (0.62 * up if up > 0 else 0.34 * up)
        roof = max(0.0, up) * 0.42 * math.exp(-((f - 0.47) / 0.2) ** 2)
        side = (abs(c) ** 0.8) * (1 if c > 0 else -1)
        return [x, 0.42 + y + roof * height * 0.9, 0.5 * width * profile * side * (1 - 0.25 * max(0.0, up) * math.exp(-((f - 0.47) / 0.25) ** 2))]

    return mesh(around, along, place, u_wrap="periodic")


def paint():
    out = [head("osl_paint", "The form that paint makers show their colours on: flakes tilt each its own way beneath a clear coat.",
                [-2.2, 1.7, -6.6], [0.2, 0.5, 0.1], 33, clamp=12, bounces=6)]
    # long soft lamps draw the form
    for k, z in enumerate((-1.5, 0.1, 1.7)):
        out.append(area_light(f"strip{k}", [0.2, 4.6, z], [0.2, 0, z], 7, 0.42, 9, [1, 0.98, 0.95]))
    out.append(area_light("side", [-6, 2.2, -3.4], [0, 0.5, 0], 1.3, 3, 7, [0.8, 0.9, 1]))
    out.append(area_light("back", [6.5, 2.6, 4], [0, 0.5, 0], 2, 3, 5, [1, 0.85, 0.7]))
    out.append(dome(0.05, [0.8, 0.88, 1]))
    out.append(block("backdrop", "    Bxdf \"PxrSurface\" \"backdropMaterial\" \"color diffuseColor\" [.2 .21 .23] \"int diffuseDoubleSided\" [1]\n" + wall((-30, 9), (30, 9), 0, 14)))
    out.append(block("form", paint_material("flakes", [0.5, 0.018, 0.02], [0.09, 0.0, 0.05], [1, 0.34, 0.16]) + "    Rotate 14 0 1 0\n" + speed_form()))
    out.append(block("blue", paint_material("flakes", [0.015, 0.09, 0.38], [0.06, 0.0, 0.12], [0.4, 0.75, 1]) + "    Translate 1.9 .37 -1.6\n    Sphere .37 -.37 .37 360\n"))
    out.append(block("gold", paint_material("flakes", [0.42, 0.23, 0.03], [0.1, 0.07, 0.0], [1, 0.78, 0.35]) + "    Translate -2.15 .3 -1.7\n    Sphere .3 -.3 .3 360\n"))
    out.append(block("green", paint_material("flakes", [0.02, 0.17, 0.07], [0.0, 0.05, 0.12], [0.6, 1, 0.6]) + "    Translate 1.0 .28 -2.3\n    Sphere .28 -.28 .28 360\n"))
    out.append(block("floor", "    Bxdf \"PxrSurface\" \"floorMaterial\" \"color diffuseColor\" [.1 .1 .105] \"color specularFaceColor\" [.04 .04 .04] \"color specularEdgeColor\" [1 1 1] \"float specularRoughness\" [.22] \"int diffuseDoubleSided\" [1]\n" + floor(40, 0, 60)))
    out.append("WorldEnd\n")
    (SCENES / "osl_paint.rib").write_text("".join(out))


# ----------------------------------------------------------------------------------------------------------------- sky

def sky():
    to_sun = [-0.8, 0.33, 0.1]
    out = [head("osl_sky", "A dome of sky over hills: air, veils and heaps of cloud by the direction of view; the land is a shader too.",
                [0, 6.5, -36], [-2, 12.5, 10], 60, clamp=8, bounces=3)]
    out.append(sun(to_sun, 42000, [1, 0.84, 0.62], 0.6))
    out.append(dome(0.5, [0.5, 0.66, 1]))
    out.append(block("sky", "    Attribute \"visibility\" \"int indirect\" [0] \"int transmission\" [0]\n"
                     f"    Pattern \"sky\" \"sky\" \"vector sun\" [{numbers(to_sun)}] \"float amount\" [.6]\n"
                     "    Bxdf \"PxrConstant\" \"skyMaterial\" \"reference color emitColor\" [\"sky:resultRGB\"]\n    Sphere 900 -900 900 360\n"))
    random.seed(11)
    bumps = [(random.uniform(-70, 70), random.uniform(-10, 120), random.uniform(7, 26), random.uniform(0.6, 2.6)) for _ in range(90)]
    bumps += [(-34, 95, 22, 9), (30, 120, 30, 13), (70, 100, 24, 8), (-78, 120, 34, 13), (0, 140, 34, 8)]

    def land(i, j, columns=44, rows=40):
        z = -38 + 190 * (j / (rows - 1)) ** 1.5
        x = (-1 + 2 * i / (columns - 1)) * (34 + 0.85 * (z + 38))
        y = sum(h * math.exp(-((x - a) ** 2 + (z - b) ** 2) / (r * r)) for a, b, r, h in bumps)
        return [x, y - 1.3, z]

    out.append(block("land", "    Pattern \"land\" \"land\"\n    Bxdf \"PxrSurface\" \"landMaterial\" \"reference color diffuseColor\" [\"land:resultRGB\"] \"float diffuseRoughness\" [.8] \"int diffuseDoubleSided\" [1] "
                     "\"float glowGain\" [1] \"reference color glowColor\" [\"land:glow\"]\n" + mesh(44, 40, land)))
    out.append("WorldEnd\n")
    (SCENES / "osl_sky.rib").write_text("".join(out))


if __name__ == "__main__":
    wood()
    brick()
    rust()
    weave()
    paint()
    sky()
