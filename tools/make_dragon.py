#!/usr/bin/env python3
"""Writes scenes/dragon.rib: a small dragon modelled as one subdivision cage (body, limbs), with horns, plates and claws that
have creases, texture coordinates by face corner, under a sky map.

The output is committed; run this again only to change it. One unit is a metre or so; the dragon looks along +x.
"""
import math
import pathlib

SCENES = pathlib.Path(__file__).resolve().parent.parent / "scenes"


def number(x, digits=3):
    text = f"{x:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text.replace("-0.", "-.") if text.startswith("-0.") else text.lstrip("0") or "0"


def numbers(values, digits=3):
    return " ".join(number(v, digits) for v in values)


def add(a, b, k=1.0):
    return tuple(x + k * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = math.sqrt(sum(c * c for c in a))
    return tuple(c / length for c in a)


class Cage:
    """Quads with s, t by corner, and tags."""

    def __init__(self):
        self.points, self.faces, self.st, self.creases, self.corners = [], [], [], [], []

    def ring(self, centre, right, up, width, height, sides, turn=0.0):
        """Vertices of a ring: index 0 at the top, then towards -right."""
        first = len(self.points)
        for k in range(sides):
            a = 2 * math.pi * k / sides + turn
            self.points.append(add(add(centre, right, -width * math.sin(a)), up, height * math.cos(a)))
        return list(range(first, first + sides))

    def quad(self, corners, st):
        self.faces.append(tuple(corners))
        self.st.append(tuple(st))

    def join(self, a, b, s0, s1, skip=()):
        """Quads between two rings; t runs once around, so that the seam lies on top."""
        n = len(a)
        for k in range(n):
            if k in skip:
                continue
            j = (k + 1) % n
            self.quad((a[k], a[j], b[j], b[k]), ((s0, k / n), (s0, (k + 1) / n), (s1, (k + 1) / n), (s1, k / n)))

    def cap(self, r, s, forward):
        """Closes a ring of four or eight."""
        if len(r) == 4:
            faces = [(r[0], r[1], r[2], r[3])]
        else:
            faces = [(r[0], r[1], r[2], r[7]), (r[7], r[2], r[3], r[6]), (r[6], r[3], r[4], r[5])]
        n = len(r)
        where = {v: k / n for k, v in enumerate(r)}
        for f in faces:
            f = f if forward else f[::-1]
            self.quad(f, [(s, where[v]) for v in f])

    def limb(self, hole, rings, s0, crease_last=0.0):
        """A limb of four sides from the quad `hole` (indices in order) through rings of four points each."""
        previous, s = list(hole), s0
        for points in rings:
            first = len(self.points)
            self.points += points
            ring = list(range(first, first + 4))
            for k in range(4):
                j = (k + 1) % 4
                self.quad((previous[k], previous[j], ring[j], ring[k]), ((s, k / 8), (s, (k + 1) / 8), (s + 0.05, (k + 1) / 8), (s + 0.05, k / 8)))
            previous, s = ring, s + 0.05
        self.quad(previous, [(s, k / 8) for k in range(4)])
        if crease_last:
            self.creases.append((previous + previous[:1], crease_last))

    def rib(self, indent="    "):
        names, counts, integers, floats = ["interpolateboundary"], ["1 0"], ["1"], []
        for chain, sharpness in self.creases:
            names.append("crease")
            counts.append(f"{len(chain)} 1")
            integers.append(" ".join(map(str, chain)))
            floats.append(number(sharpness))
        for v, sharpness in self.corners:
            names.append("corner")
            counts.append("1 1")
            integers.append(str(v))
            floats.append(number(sharpness))
        tags = " ".join(f'"{n}"' for n in names)
        return (f"{indent}SubdivisionMesh \"catmull-clark\" [{' '.join(['4'] * len(self.faces))}]\n"
                f"{indent}  [{' '.join(str(v) for f in self.faces for v in f)}]\n"
                f"{indent}  [{tags}] [{' '.join(counts)}] [{' '.join(integers)}] [{' '.join(floats)}]\n"
                f"{indent}  \"vertex point P\" [{numbers(c for p in self.points for c in p)}]\n"
                f"{indent}  \"facevarying float[2] st\" [{numbers(c for f in self.st for corner in f for c in corner)}]\n")


# The spine from the tip of the tail to the snout: place, half width, half height.
SPINE = [((-2.75, 0.98, -0.55), 0.035, 0.035), ((-2.62, 0.66, -0.52), 0.09, 0.09), ((-2.3, 0.42, -0.36), 0.145, 0.14),
         ((-1.85, 0.36, -0.14), 0.21, 0.20), ((-1.4, 0.48, 0.0), 0.30, 0.29), ((-1.0, 0.72, 0.02), 0.43, 0.43),
         ((-0.55, 0.90, 0.0), 0.55, 0.54), ((0.0, 0.95, 0.0), 0.57, 0.55), ((0.45, 1.02, 0.0), 0.50, 0.50), ((0.78, 1.24, 0.0), 0.36, 0.38),
         ((0.95, 1.55, -0.02), 0.25, 0.27), ((1.03, 1.88, -0.06), 0.215, 0.23), ((1.09, 2.16, -0.12), 0.26, 0.25), ((1.23, 2.40, -0.23), 0.37, 0.31),
         ((1.46, 2.44, -0.42), 0.385, 0.33), ((1.67, 2.35, -0.60), 0.30, 0.24), ((1.86, 2.28, -0.76), 0.25, 0.19), ((1.98, 2.25, -0.86), 0.20, 0.15)]


def frames():
    out = []
    for i, (p, w, h) in enumerate(SPINE):
        t = unit(add(SPINE[min(i + 1, len(SPINE) - 1)][0], SPINE[max(i - 1, 0)][0], -1))
        right = unit(add((0, 0, -1), t, -sum(a * b for a, b in zip((0, 0, -1), t))))
        out.append((p, t, right, cross(t, right), w, h))
    return out


def body():
    c = Cage()
    rings = [c.ring(p, right, up, w, h, 8) for p, _, right, up, w, h in frames()]
    holes = {(5, 2): "hind", (5, 5): "hind", (8, 2): "fore", (8, 5): "fore"}
    for i in range(len(rings) - 1):
        c.join(rings[i], rings[i + 1], i / 17, (i + 1) / 17, [k for (r, k) in holes if r == i])
    c.cap(rings[0], 0, False)
    c.cap(rings[-1], 1, True)
    for (i, k), kind in holes.items():
        a, b, j = rings[i], rings[i + 1], k + 1
        hole = [a[k], a[j], b[j], b[k]]
        side = 1 if c.points[a[k]][2] > 0 else -1

        def ring(x, y, z, dx, dz, slope=0.0):
            # in the order of the hole: back outer, back inner, front inner, front outer (mirrored on the other side)
            quad = [(x - dx, y - slope, z + dz), (x - dx, y + slope, z - dz), (x + dx, y + slope, z - dz), (x + dx, y - slope, z + dz)]
            quad = [(px, py, side * pz) for px, py, pz in quad]
            return quad if abs(c.points[hole[0]][2]) > abs(c.points[hole[1]][2]) else [quad[1], quad[0], quad[3], quad[2]]

        if kind == "hind":
            rings_ = [ring(-0.62, 0.62, 0.50, 0.27, 0.16, 0.05), ring(-0.66, 0.36, 0.52, 0.20, 0.14), ring(-0.68, 0.17, 0.53, 0.18, 0.15),
                      ring(-0.60, 0.06, 0.54, 0.25, 0.18), ring(-0.58, 0.0, 0.54, 0.25, 0.18)]
        else:
            rings_ = [ring(0.68, 0.66, 0.44, 0.20, 0.13, 0.05), ring(0.70, 0.40, 0.46, 0.15, 0.115), ring(0.69, 0.17, 0.47, 0.14, 0.125),
                      ring(0.75, 0.06, 0.48, 0.20, 0.155), ring(0.77, 0.0, 0.48, 0.20, 0.155)]
        c.limb(hole, rings_, i / 17, 3.0)
    return c


def plates():
    """Crest: flat diamonds along the back whose edges are creased."""
    c = Cage()
    f = frames()
    for i in range(1, 13):
        for half in (0.0, 0.5) if i > 3 else (0.0,):
            (p, t, right, up, _, h), (p2, t2, _, up2, _, h2) = f[i], f[i + 1]
            at, along, top = (tuple(a + (b - a) * half for a, b in zip(x, y)) for x, y in ((p, p2), (t, t2), (up, up2)))
            high = h + (h2 - h) * half
            size = 0.10 + 0.42 * min(1.0, high / 0.5) ** 1.2 * 0.55
            root = add(at, top, high * 0.86)
            n = len(c.points)
            front, back, tip = add(root, along, size * 0.72), add(root, along, -size * 0.6), add(add(root, top, size * 1.12), along, -size * 0.45)
            mid = add(add(root, top, size * 0.45), along, -size * 0.08)
            thick = 0.16 * size
            low = add(root, top, -0.05)
            c.points += [front, back, tip, add(mid, right, thick), add(mid, right, -thick), add(low, right, thick * 0.8), add(low, right, -thick * 0.8)]
            e, b_, x, l, r, dl, dr = range(n, n + 7)
            quads = [(e, x, l, dl), (l, x, b_, dl), (x, e, dr, r), (b_, x, r, dr), (e, dl, b_, dr)]
            for q in quads:
                c.quad(q, [(0, 0), (1, 0), (1, 1), (0, 1)])
            c.creases.append(([e, x, b_], 10.0))
            c.corners.append((x, 10.0))
    return c


def horn(base, direction, bend, length, width):
    c = Cage()
    rings, p, d = [], base, unit(direction)
    for i in range(6):
        right = unit(cross(d, (0.3, 0.1, 1)))
        up = cross(right, d)
        w = width * (1 - i / 5.6) ** 0.8
        rings.append(c.ring(p, right, up, w, w, 4, 0.4 * i))
        if i in (1, 2, 3):   # rings as on a goat's
            c.creases.append((rings[-1] + rings[-1][:1], 1.5))
        p, d = add(p, d, length / 5), unit(add(d, bend, 0.24))
    for i in range(5):
        c.join(rings[i], rings[i + 1], i / 5, (i + 1) / 5)
    c.cap(rings[0], 0, False)
    c.cap(rings[-1], 1, True)
    return c


def ball(p, radius, stretch=(1, 1, 1), turn=0):
    return (f"    AttributeBegin Translate {numbers(p)} Rotate {turn} 0 1 0 Scale {numbers(radius * s for s in stretch)} "
            "Sphere 1 -1 1 360 AttributeEnd\n")


def main():
    f = frames()
    out = ["""##RenderMan RIB-Structure 1.1
# A small dragon under a sky map: one subdivision cage for body and limbs (creased soles, texture coordinates by face corner),
# a creased crest, ringed horns. Written by tools/make_dragon.py. y is up, z goes into the picture.
Option "searchpath" "string texture" [".:@"]
Hider "raytrace" "int maxsamples" [64] "int minsamples" [64]
Integrator "PxrPathTracer" "integrator" "int maxIndirectBounces" [4]
DisplayChannel "color Ci"
DisplayChannel "float a"
Display "dragon.exr" "openexr" "rgba"
Display "+dragon.png" "png" "rgba"
Format 640 400 1
PixelFilter "gaussian" 2 2
DepthOfField 4 0.35 9
Projection "perspective" "fov" [23.5]
# the eye stands at (1.9, 1.9, -8.9) and looks a little to the left and down
Rotate -3 1 0 0
Rotate 11 0 1 0
Translate -1.9 -1.9 8.9
WorldBegin
  AttributeBegin
    # the dome's own up is z: it becomes y
    Rotate 215 0 1 0
    ConcatTransform [0 0 -1 0  -1 0 0 0  0 1 0 0  0 0 0 1]
    Light "PxrDomeLight" "sky" "string lightColorMap" ["sky.hdr"] "float intensity" [1]
  AttributeEnd
  AttributeBegin
    Attribute "identifier" "string name" ["sand"]
    Pattern "PxrFractal" "dunes" "int layers" [5] "float frequency" [.8] "float dimension" [.8]
    Pattern "PxrMix" "sandColor" "color color1" [.20 .135 .075] "color color2" [.36 .265 .16] "reference float mix" ["dunes:resultF"]
    Bxdf "PxrSurface" "sand" "reference color diffuseColor" ["sandColor:resultRGB"] "float diffuseRoughness" [.8]
    Polygon "vertex point P" [-4000 0 -12  -4000 0 4000  4000 0 4000  4000 0 -12]
  AttributeEnd

  AttributeBegin
    Attribute "identifier" "string name" ["body"]
    # t runs around the body from the crest: belly, flanks, back; cells on the flanks
    Pattern "PxrRamp" "around" "int rampType" [1] "float[8] colorRamp_Knots" [0 .16 .36 .44 .56 .64 .84 1]
      "color[8] colorRamp_Colors" [.02 .10 .09  .03 .19 .13  .09 .33 .14  .62 .55 .28  .62 .55 .28  .09 .33 .14  .03 .19 .13  .02 .10 .09]
      "string colorRamp_Interpolation" ["linear"]
    Pattern "PxrWorley" "cells" "float frequency" [7] "float c1" [1.1] "float c2" [0] "float jitter" [.9]
    Pattern "PxrRemap" "spots" "reference color inputRGB" ["cells:resultRGB"] "float inputMin" [.25] "float inputMax" [.42]
    Pattern "PxrMix" "spotted" "color color1" [.015 .085 .09] "reference color color2" ["around:resultRGB"]
      "reference float mix" ["spots:resultR"]
    Bxdf "PxrSurface" "hide" "reference color diffuseColor" ["spotted:resultRGB"] "int specularFresnelMode" [1]
      "color specularEdgeColor" [1 1 1] "float specularRoughness" [.42] "int specularModelType" [1] "float specularEnergyCompensation" [1]
      "int clearcoatFresnelMode" [1] "color clearcoatEdgeColor" [.4 .4 .4] "float clearcoatRoughness" [.12] "int clearcoatModelType" [1]
      "float clearcoatEnergyCompensation" [1]
"""]
    out.append(body().rib())
    # lids over the eyes
    head, t, right, up, w, h = f[14]
    eyes = [add(add(add(head, right, s * w * 0.78), up, h * 0.36), t, 0.02) for s in (-1, 1)]
    out.append("  AttributeEnd\n  AttributeBegin\n    Attribute \"identifier\" \"string name\" [\"crest\"]\n"
               "    Bxdf \"PxrDisney\" \"crest\" \"color baseColor\" [.62 .13 .03] \"float roughness\" [.35] \"float subsurface\" [.3]\n"
               "      \"float clearcoat\" [.4]\n")
    out.append(plates().rib())
    out.append("  AttributeEnd\n  AttributeBegin\n    Attribute \"identifier\" \"string name\" [\"horns and claws\"]\n"
               "    Bxdf \"PxrDisney\" \"horn\" \"color baseColor\" [.72 .62 .44] \"float roughness\" [.3] \"float specular\" [.5]\n")
    head, t, right, up, w, h = f[13]
    for s in (-1, 1):
        out.append(horn(add(add(head, right, s * w * 0.42), up, h * 0.72), add(add(up, t, -0.55), right, s * 0.3), add(t, up, 0.2), 0.52, 0.10).rib())
    for x, y in ((-0.36, 0.54), (0.94, 0.48)):
        for s in (-1, 1):
            for k in (-1, 0, 1):
                out.append(ball((x + 0.03 * (1 - abs(k)), 0.045, s * (y + 0.1 * k)), 1, (0.10, 0.05, 0.045)))
    out.append("  AttributeEnd\n  AttributeBegin\n    Attribute \"identifier\" \"string name\" [\"eyes\"]\n")
    for s, eye in zip((-1, 1), eyes):
        gaze = unit(add(add(right, t, 0.9 * s), up, 0.1 * s))
        gaze = tuple(s * g for g in gaze)
        out.append("    Bxdf \"PxrDisney\" \"white\" \"color baseColor\" [.85 .82 .72] \"float roughness\" [.1] \"float clearcoat\" [1]\n")
        out.append(ball(eye, 0.125))
        out.append("    Bxdf \"PxrDisney\" \"iris\" \"color baseColor\" [.02 .015 .01] \"float roughness\" [.05] \"float clearcoat\" [1]\n")
        out.append(ball(add(eye, gaze, 0.055), 0.085))
    # mouth and nostrils
    out.append("    Bxdf \"PxrDiffuse\" \"dark\" \"color diffuseColor\" [.01 .02 .02]\n")
    mouth = []
    for i, angle in ((14, 88), (14, 96), (15, 108), (16, 108), (17, 100)):
        p, t, right, up, w, h = f[i]
        g = {17: 0.74, 16: 0.9, 15: 0.93, 14: 0.95}[i]   # of the cage: where the smooth surface lies
        a, k = math.radians(angle), 0.05 if i == 14 and angle < 90 else 0.22 if i == 14 else 0
        mouth.append(tuple(add(add(add(p, t, k), right, s * w * g * math.sin(a)), up, h * g * math.cos(a)) for s in (-1, 1)))
    p, t, right, up, w, h = f[17]
    front = [add(add(p, t, -0.022), up, -0.12 * h)]
    line = [m[0] for m in mouth] + front + [m[1] for m in reversed(mouth)]
    out.append(f"    AttributeBegin Basis \"catmull-rom\" 1 \"catmull-rom\" 1\n    Curves \"cubic\" [{len(line) + 2}] \"nonperiodic\" \"P\" "
               f"[{numbers(c for q in [line[0]] + line + [line[-1]] for c in q)}] \"constantwidth\" [.02]\n    AttributeEnd\n")
    nose, t, right, up, w, h = f[16]
    for s in (-1, 1):
        out.append(ball(add(add(add(nose, right, s * w * 0.42), up, h * 0.72), t, 0.1), 0.035))
    out.append("  AttributeEnd\nWorldEnd\n")
    (SCENES / "dragon.rib").write_text("".join(out))


if __name__ == "__main__":
    main()
