#!/usr/bin/env python3
"""Writes a forest as a small RIB: objects in objects, ten million plants of three kinds.

  tools/make_forest.py [LEVELS] > scenes/forest.rib

A plant is a few primitives; a tuft holds ten plants, a clump ten tufts, and so on, LEVELS (6) times; the world holds ten
of the largest: 10 ** (LEVELS + 1) plants. Each level places its ten on a sunflower's spiral, turned and scaled, so that
no two places look alike; the ground is one polygon.
"""
import math
import random
import sys

LEVELS = int(sys.argv[1]) if len(sys.argv) > 1 else 6
FAR = 10  # one level's width over that of the one below: its root, since area counts
random.seed(17)


def place(x, z, turn, size):
    c, s = math.cos(turn) * size, math.sin(turn) * size
    return f"ConcatTransform [{c:.5g} 0 {-s:.5g} 0  0 {size:.5g} 0 0  {s:.5g} 0 {c:.5g} 0  {x:.5g} 0 {z:.5g} 1]"


def spiral(k, radius):
    r, a = radius * math.sqrt((k + .5) / 10), 2.399963 * k + random.uniform(-.3, .3)
    return r * math.cos(a), r * math.sin(a)


def quad(points):
    return f'PointsPolygons [4] [0 1 2 3] "P" [{" ".join("%.4g" % v for p in points for v in p)}]'


def conifer(out):
    out('AttributeBegin Bxdf "PxrDiffuse" "bark" "color diffuseColor" [.16 .09 .05]')
    out('TransformBegin Rotate -90 1 0 0 Cone 1.1 .04 360 TransformEnd AttributeEnd')
    for k in range(4):
        shade = .75 + .12 * k
        out(f'AttributeBegin Bxdf "PxrDiffuse" "needles{k}" "color diffuseColor" [{.09 * shade:.3g} {.24 * shade:.3g} {.1 * shade:.3g}]')
        out(f"TransformBegin Translate 0 {.18 + .22 * k:.3g} 0 Rotate -90 1 0 0 Cone {.42 - .03 * k:.3g} {.3 - .055 * k:.3g} 360 "
            "TransformEnd AttributeEnd")


def broadleaf(out):
    out('AttributeBegin Bxdf "PxrDiffuse" "wood" "color diffuseColor" [.2 .13 .08]')
    out('TransformBegin Rotate -90 1 0 0 Cylinder .035 0 .5 360 TransformEnd AttributeEnd')
    for k in range(5):
        a = 1.2566 * k
        x, y, z = .16 * math.cos(a), .55 + .07 * (k % 3), .16 * math.sin(a)
        r = .2 + .03 * (k % 2)
        out(f'AttributeBegin Bxdf "PxrDiffuse" "leaves{k}" "color diffuseColor" [{.2 + .03 * k:.3g} {.32 + .01 * k:.3g} .07]')
        out(f"TransformBegin Translate {x:.3g} {y:.3g} {z:.3g} Sphere {r:.3g} -{r:.3g} {r:.3g} 360 TransformEnd AttributeEnd")


def shrub(out):
    for k in range(6):
        a = 1.0472 * k
        c, s = math.cos(a), math.sin(a)
        points = [(-.05 * s, 0, .05 * c), (.05 * s, 0, -.05 * c), (.22 * c + .05 * s, .22, .22 * s - .05 * c),
                  (.22 * c - .05 * s, .22, .22 * s + .05 * c)]
        out(f'AttributeBegin Bxdf "PxrDiffuse" "blade{k}" "color diffuseColor" [{.2 + .02 * k:.3g} .26 .07]')
        out(quad(points) + " AttributeEnd")


def main():
    out = print
    out("# Made by tools/make_forest.py: ten million plants, objects in objects.")
    out('Display "forest.exr" "openexr" "rgba"\nFormat 480 270 1\nPixelVariance 0.02')
    out('Hider "raytrace" "int minsamples" [16] "int maxsamples" [64]')
    out('Integrator "PxrPathTracer" "path" "int maxIndirectBounces" [3]')
    out('Projection "perspective" "fov" [32]')
    out("Rotate -14 1 0 0\nRotate 75 0 1 0\nTranslate 0 -5 14\nWorldBegin")
    out('Light "PxrDomeLight" "sky" "color lightColor" [.45 .6 .9]')
    out('AttributeBegin Rotate 40 0 1 0 Rotate 35 1 0 0')
    out('Light "PxrDistantLight" "sun" "float intensity" [2.6] "color lightColor" [1 .9 .75] "float angleExtent" [.5] AttributeEnd')
    out('AttributeBegin Bxdf "PxrDiffuse" "soil" "color diffuseColor" [.24 .21 .11]')
    out('Polygon "P" [-9000 0 -9000  -9000 0 9000  9000 0 9000  9000 0 -9000] AttributeEnd')
    for name, make in (("conifer", conifer), ("broadleaf", broadleaf), ("shrub", shrub)):
        out(f'ObjectBegin "{name}"')
        make(out)
        out("ObjectEnd")
    below, radius = None, 1.1
    for level in range(1, LEVELS + 1):
        out(f'ObjectBegin "level{level}"')
        for k in range(10):
            x, z = spiral(k, radius)
            turn = random.uniform(0, 6.2832)
            if below:
                what, size = below, random.uniform(.93, 1.05)
            else:
                what = ("conifer", "broadleaf", "shrub", "conifer", "shrub")[k % 5]
                size = random.uniform(.7, 1.3)
            out(f'TransformBegin {place(x, z, turn, size)} ObjectInstance "{what}" TransformEnd')
        out("ObjectEnd")
        below, radius = f"level{level}", radius * math.sqrt(FAR)
    for k in range(10):
        x, z = spiral(k, radius)
        out(f'TransformBegin {place(x, z, random.uniform(0, 6.2832), 1)} ObjectInstance "{below}" TransformEnd')
    out("WorldEnd")


main()
