#!/usr/bin/env python3
"""Writes scenes/still_life.rib: wine, pears and copper by a window. Turned things are surfaces of revolution as NURBS, so that
their circles are exact and the file stays small.

The output is committed; run this again only to change it. One unit is ten centimetres.
"""
import math
import pathlib

SCENES = pathlib.Path(__file__).resolve().parent.parent / "scenes"


def number(x, digits=4):
    text = f"{x:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def numbers(values, digits=4):
    return " ".join(number(v, digits) for v in values)


def knots(n):
    return [0] * 4 + list(range(1, n - 3)) + [n - 3] * 4


def at(profile, t):
    """Point of the clamped uniform cubic B-spline at t in 0 .. 1 (de Boor)."""
    k, n = knots(len(profile)), len(profile)
    x = t * (n - 3)
    s = min(int(x), n - 4) + 3
    d = [profile[s - 3 + j] for j in range(4)]
    for r in range(1, 4):
        for j in range(3, r - 1, -1):
            low, high = k[s - 3 + j], k[s + 1 + j - r]
            a = (x - low) / (high - low) if high > low else 0
            d[j] = tuple((1 - a) * p + a * q for p, q in zip(d[j - 1], d[j]))
    return d[3]


def turned(profile, indent="    "):
    """The profile, pairs of radius and height, turned about y: rational quadratic circles of nine points."""
    half = math.sqrt(0.5)
    circle = [(1, 0, 1), (1, -1, half), (0, -1, 1), (-1, -1, half), (-1, 0, 1), (-1, 1, half), (0, 1, 1), (1, 1, half), (1, 0, 1)]
    points = [c for r, y in profile for x, z, w in circle for c in (r * x * w, y * w, r * z * w, w)]
    n = len(profile)
    return (f"{indent}NuPatch 9 3 [0 0 0 1 1 2 2 3 3 4 4 4] 0 4  {n} 4 [{numbers(knots(n))}] 0 {n - 3}\n"
            f"{indent}  \"vertex hpoint Pw\" [{numbers(points)}]\n")


def look(place, target, width, height):
    """Matrix of a rectangle of width by height at place whose +z, the side that shines, faces target."""
    z = [b - a for a, b in zip(place, target)]
    z = [c / math.sqrt(sum(v * v for v in z)) for c in z]
    x = [z[2], 0, -z[0]]
    x = [c / math.hypot(*x) for c in x]
    y = [z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]]
    return (f"[{numbers([c * width for c in x] + [0])}  {numbers([c * height for c in y] + [0])}  {numbers(z + [0])}  "
            f"{numbers(list(place) + [1])}]"), x, y


# The wine glass from the middle of its foot outwards, up, over the rim and down the inside; cubic B-spline points.
GLASS = [(0, 0.012), (0.2, 0.012), (0.345, 0), (0.385, 0.012), (0.36, 0.035), (0.22, 0.06), (0.07, 0.09), (0.042, 0.2), (0.036, 0.5),
         (0.036, 0.82), (0.05, 0.93), (0.20, 0.99), (0.40, 1.14), (0.475, 1.40), (0.445, 1.75), (0.385, 2.06), (0.368, 2.115),
         (0.352, 2.115), (0.352, 2.06), (0.412, 1.75), (0.442, 1.40), (0.372, 1.165), (0.19, 1.03), (0.06, 0.985), (0, 0.985)]
INSIDE = 18      # the first point of the inner wall
LEVEL = 1.50


def wine():
    """Profile of the wine: along the middle of the glass's wall, so that the two overlap (the glass has the higher
    priority), then level with a sharp edge."""
    inner = []
    for i in range(400):
        t = 1 - i / 400 * (1 - (INSIDE - 2) / (len(GLASS) - 1))
        r, y = at(GLASS, t)
        if y > LEVEL:
            break
        inner.append((r, y))
    # every few points, moved outwards by half the wall
    picked = [inner[round(k * (len(inner) - 1) / 9)] for k in range(10)]
    out = [(0, inner[0][1] - 0.014)]
    for k in range(1, 10):
        (r0, y0), (r1, y1) = picked[k - 1], picked[min(k + 1, 9)]
        d = math.hypot(r1 - r0, y1 - y0)
        out.append((picked[k][0] + (y1 - y0) / d * 0.015, picked[k][1] - (r1 - r0) / d * 0.015))
    edge = (out[-1][0], LEVEL)
    return out[:-1] + [edge, edge, edge, (0.2, LEVEL), (0, LEVEL)]


COPPER = [(0, 0.01), (0.25, 0.01), (0.42, 0), (0.455, 0), (0.47, 0.03), (0.475, 0.1), (0.485, 0.35), (0.50, 0.7), (0.52, 1.02), (0.535, 1.06),
          (0.53, 1.085), (0.515, 1.08), (0.50, 1.05), (0.48, 0.7), (0.465, 0.35), (0.455, 0.08), (0.44, 0.045), (0.3, 0.04), (0, 0.04)]
TRAY = [(0, 0.02), (0.5, 0.02), (1.0, 0.02), (1.12, 0.02), (1.2, 0.03), (1.32, 0.10), (1.42, 0.135), (1.5, 0.14), (1.53, 0.14), (1.545, 0.15),
        (1.53, 0.165), (1.5, 0.165), (1.41, 0.16), (1.31, 0.125), (1.19, 0.055), (1.1, 0.045), (1.0, 0.045), (0.5, 0.045), (0, 0.045)]
PEAR = [(0, 0.03), (0.06, 0.03), (0.13, 0.0), (0.30, 0.01), (0.47, 0.16), (0.50, 0.40), (0.42, 0.66), (0.26, 0.86), (0.19, 1.02), (0.165, 1.16),
        (0.11, 1.24), (0.04, 1.22), (0, 1.20)]


def rest(tilt, turn, x, z, floor):
    """Transform of a pear tilted by so many degrees towards its turn, lowered until it touches the floor."""
    c, s = math.cos(math.radians(tilt)), math.sin(math.radians(tilt))
    low = min(c * y - abs(s) * r for i in range(400) for r, y in [at(PEAR, i / 399)])
    return f"Translate {number(x)} {number(floor - low)} {number(z)} Rotate {turn} 0 1 0 Rotate {tilt} 0 0 1"


STALK = ("      Curves \"cubic\" [4] \"nonperiodic\" \"P\" [0 1.17 0  .01 1.28 0  .03 1.36 .01  .07 1.44 .02] \"varying float width\" [.035 .055]\n")


def main():
    out = ["""##RenderMan RIB-Structure 1.1
# Wine, pears and copper by a window: nested dielectrics, polished and brushed metals, rough gold, a natural skin. Written by
# tools/make_still_life.py. y is up, z goes into the picture, one unit is ten centimetres.
Hider "raytrace" "int maxsamples" [256] "int minsamples" [256]
Integrator "PxrPathTracer" "integrator" "int maxIndirectBounces" [10] "int allowCaustics" [1] "float clampLuminance" [4]
DisplayChannel "color Ci"
DisplayChannel "float a"
Display "still_life.exr" "openexr" "rgba"
Display "+still_life.png" "png" "rgba"
Format 640 400 1
PixelFilter "gaussian" 2 2
DepthOfField 4 0.7 11.2
Projection "perspective" "fov" [15.6]
# the eye stands at (.15, 3, -11) and looks 11 degrees down
ConcatTransform [1 0 0 0  0 .98163 -.19081 0  0 .19081 .98163 0  0 0 0 1]
Translate -.15 -3 11
WorldBegin
"""]
    # a window of six panes on the left, a dim strip behind on the right
    centre, target, pane, gap = (-6.5, 4.4, -3.0), (0, 0.9, 0), 1.9, 0.25
    _, x, y = look(centre, target, 1, 1)
    for i in range(2):
        for j in range(3):
            a, b = (i - 0.5) * (pane + gap), (j - 1) * (pane + gap)
            place = [centre[k] + x[k] * a + y[k] * b for k in range(3)]
            matrix, _, _ = look(place, [place[k] + target[k] - centre[k] for k in range(3)], pane, pane)
            out.append(f"  AttributeBegin\n    ConcatTransform {matrix}\n    Light \"PxrRectLight\" \"pane{i}{j}\" \"float intensity\" [10] "
                       "\"color lightColor\" [1 .93 .82] \"string lightGroup\" [\"window\"]\n  AttributeEnd\n")
    matrix, _, _ = look((5.2, 3.2, 3.4), (0.2, 0.9, 0), 0.7, 4)
    out.append(f"  AttributeBegin\n    ConcatTransform {matrix}\n    Light \"PxrRectLight\" \"rim\" \"float intensity\" [5] "
               "\"color lightColor\" [.62 .78 1] \"string lightGroup\" [\"rim\"]\n  AttributeEnd\n")
    out.append("""  AttributeBegin
    # the dome's own up is z: it becomes y
    ConcatTransform [0 0 -1 0  -1 0 0 0  0 1 0 0  0 0 0 1]
    Light "PxrDomeLight" "fill" "float intensity" [.09] "color lightColor" [.75 .85 1] "string lightGroup" ["fill"]
  AttributeEnd

  AttributeBegin
    Attribute "identifier" "string name" ["table"]
    # the veins are stretched along x by the transform
    Scale 5 1 .55
    Pattern "PxrFractal" "veins" "int layers" [6] "float frequency" [1.6] "float dimension" [.8] "int turbulent" [1]
    Pattern "PxrMix" "wood" "color color1" [.045 .018 .008] "color color2" [.24 .105 .045] "reference float mix" ["veins:resultF"]
    Bxdf "PxrSurface" "oiled" "reference color diffuseColor" ["wood:resultRGB"] "int specularFresnelMode" [1]
      "color specularEdgeColor" [1 1 1] "float specularRoughness" [.38] "int specularModelType" [1] "float specularEnergyCompensation" [1]
    Polygon "vertex point P" [-3 0 -6  -3 0 6.4  3 0 6.4  3 0 -6]
  AttributeEnd
  AttributeBegin
    Attribute "identifier" "string name" ["wall"]
    Pattern "PxrFractal" "mottle" "int layers" [6] "float frequency" [.35] "float dimension" [.9]
    Pattern "PxrMix" "plaster" "color color1" [.10 .115 .105] "color color2" [.20 .205 .175] "reference float mix" ["mottle:resultF"]
    Bxdf "PxrSurface" "mottled plaster" "reference color diffuseColor" ["plaster:resultRGB"] "float diffuseRoughness" [.7]
    Polygon "vertex point P" [-16 0 3.5  -16 14 3.5  16 14 3.5  16 0 3.5]
  AttributeEnd

  AttributeBegin
    Attribute "identifier" "string name" ["wine glass"]
    Translate -1.5 0 -.3
    AttributeBegin
      Attribute "trace" "int intersectpriority" [2]
      Bxdf "PxrGlass" "crystal" "float ior" [1.52]
""" + turned(GLASS, "      ") + """    AttributeEnd
    AttributeBegin
      Attribute "trace" "int intersectpriority" [1]
      Bxdf "PxrGlass" "wine" "float ior" [1.34] "color absorptionColor" [.09 1 .82] "float absorptionGain" [9]
""" + turned(wine(), "      ") + """    AttributeEnd
  AttributeEnd

  AttributeBegin
    Attribute "identifier" "string name" ["copper beaker"]
    Translate 1.75 0 1.3
    Bxdf "PxrSurface" "brushed copper" "float diffuseGain" [0] "int specularFresnelMode" [1] "color specularEdgeColor" [1 1 1]
      "color specularIor" [.27 .68 1.22] "color specularExtinctionCoeff" [3.6 2.6 2.3]
      "float specularRoughness" [.42] "float specularAnisotropy" [-.85] "int specularModelType" [1]
""" + turned(COPPER) + """  AttributeEnd

  AttributeBegin
    Attribute "identifier" "string name" ["silver tray"]
    Translate .45 0 -.55
    Bxdf "PxrSurface" "silver" "float diffuseGain" [0] "int specularFresnelMode" [1] "color specularEdgeColor" [1 1 1]
      "color specularIor" [.16 .14 .14] "color specularExtinctionCoeff" [4.0 3.3 2.5]
      "float specularRoughness" [.30] "float specularAnisotropy" [-.7] "int specularModelType" [1]
""" + turned(TRAY) + """  AttributeEnd

  AttributeBegin
    Attribute "identifier" "string name" ["pear"]
    """ + rest(-7, 20, -0.34, 0.0, 0.045) + """
    Pattern "PxrFractal" "russet" "int layers" [6] "float frequency" [3] "float dimension" [.6]
    Pattern "PxrFractal" "blush" "int layers" [2] "float frequency" [.8] "float floatScale" [1.4]
    Pattern "PxrMix" "skin" "color color1" [.42 .40 .05] "color color2" [.50 .16 .04] "reference float mix" ["blush:resultF"]
    Pattern "PxrRemap" "specks" "reference color inputRGB" ["russet:resultRGB"] "float inputMin" [.55] "float inputMax" [.75]
    Pattern "PxrMix" "speckled" "reference color color1" ["skin:resultRGB"] "color color2" [.17 .09 .025]
      "reference float mix" ["specks:resultR"]
    Bxdf "PxrDisney" "pear" "reference color baseColor" ["speckled:resultRGB"] "float roughness" [.42] "float specular" [.5]
      "float subsurface" [.4] "float clearcoat" [.5] "float clearcoatGloss" [.8]
""" + turned(PEAR) + """    AttributeBegin
      Bxdf "PxrDiffuse" "stalk" "color diffuseColor" [.09 .05 .02]
""" + STALK + """    AttributeEnd
  AttributeEnd
  AttributeBegin
    Attribute "identifier" "string name" ["gold pear"]
    """ + rest(-76, 200, 0.80, -1.30, 0.045) + """
    Bxdf "PxrDisney" "gold" "color baseColor" [.95 .60 .19] "float metallic" [1] "float roughness" [.22] "float specular" [1]
""" + turned(PEAR) + STALK[2:] + """  AttributeEnd
  AttributeBegin
    Attribute "identifier" "string name" ["glass pear"]
    """ + rest(5, 150, 1.42, -0.45, 0.045) + """
    Bxdf "PxrSurface" "green glass" "float diffuseGain" [0] "float refractionGain" [1] "float reflectionGain" [1]
      "float glassRoughness" [0] "float glassIor" [1.5] "color extinction" [.75 .12 .45]
""" + turned(PEAR) + """    AttributeBegin
      Bxdf "PxrSurface" "steel" "float diffuseGain" [0] "int specularFresnelMode" [1] "color specularEdgeColor" [1 1 1]
        "color specularIor" [2.9 2.9 2.6] "color specularExtinctionCoeff" [3.1 3.3 3.4] "float specularRoughness" [.2]
""" + STALK + """    AttributeEnd
  AttributeEnd
  AttributeBegin
    Attribute "identifier" "string name" ["balls"]
    Bxdf "PxrSurface" "polished steel" "float diffuseGain" [0] "int specularFresnelMode" [1] "color specularEdgeColor" [1 1 1]
      "color specularIor" [2.9 2.9 2.6] "color specularExtinctionCoeff" [3.1 3.3 3.4] "float specularRoughness" [.03] "int specularModelType" [1]
    AttributeBegin Translate -1.15 .17 -1.7 Sphere .17 -.17 .17 360 AttributeEnd
    Bxdf "PxrGlass" "marble" "color absorptionColor" [.05 .45 1] "float absorptionGain" [6]
    AttributeBegin Translate -.72 .14 -2.1 Sphere .14 -.14 .14 360 AttributeEnd
    Bxdf "PxrGlass" "frosted" "float roughness" [.3] "color absorptionColor" [1 .4 .1] "float absorptionGain" [3]
    AttributeBegin Translate -1.5 .12 -1.25 Sphere .12 -.12 .12 360 AttributeEnd
  AttributeEnd
WorldEnd
""")
    (SCENES / "still_life.rib").write_text("".join(out))


if __name__ == "__main__":
    main()
