#!/usr/bin/env python3
"""Writes scenes/fairy_lights.rib: a square at night under 100 chains of 100 small lamps, 10,000 lights in all.

    tools/make_fairy_lights.py [FILE]

Lamps are objects of four colours; a chain places 100 of them, the square 100 chains, so that the file is short and each
lamp is still a light of its own.
"""
import math
import random
import sys

COLOURS = {"warm": (1, 0.72, 0.36), "amber": (1, 0.5, 0.16), "rose": (1, 0.36, 0.3), "pale": (0.8, 0.9, 1)}
LAMPS = 100
CHAINS = 100


def main():
    rng = random.Random(3)
    out = []
    say = out.append
    say('##RenderMan RIB-Structure 1.1')
    say('# A square at night under 10,000 small lamps: 100 chains of 100. Made by tools/make_fairy_lights.py.')
    say('Display "fairy_lights.exr" "openexr" "rgba"')
    say('Display "+fairy_lights.png" "png" "rgb"')
    say('Hider "raytrace" "int maxsamples" [64]')
    say('Integrator "PxrPathTracer" "pt" "int maxIndirectBounces" [4]')
    say('Format 320 240 1')
    say('Projection "perspective" "fov" [50]')
    say('Rotate -2 1 0 0')
    say('Translate 0 -1.8 9')
    say('WorldBegin')
    say('  Light "PxrDomeLight" "sky" "float intensity" [0.03] "color lightColor" [0.35 0.5 1]')
    for name, colour in COLOURS.items():
        say(f'  ObjectBegin "{name}"')
        say('    AttributeBegin')
        say('      Scale 0.07 0.07 0.07')
        say(f'      Light "PxrSphereLight" "{name}" "float intensity" [6] "color lightColor" [{colour[0]} {colour[1]} {colour[2]}]')
        say('    AttributeEnd')
        say('  ObjectEnd')
    # one chain from x = -8 to 8, sagging by 1.2, its colours by chance; others are placed, turned and mirrored
    names = list(COLOURS)
    say('  ObjectBegin "chain"')
    for k in range(LAMPS):
        t = (k + 0.5) / LAMPS
        say('    AttributeBegin')
        say(f'      Translate {16 * t - 8:.3f} {-4.8 * t * (1 - t):.3f} {rng.uniform(-0.02, 0.02):.3f}')
        say(f'      ObjectInstance "{rng.choice(names)}"')
        say('    AttributeEnd')
    say('  ObjectEnd')
    for k in range(CHAINS):
        say('  AttributeBegin')
        say(f'    Translate {rng.uniform(-0.5, 0.5):.3f} {rng.uniform(4.3, 4.9):.3f} {-3 + 22 * (k + 0.5) / CHAINS:.3f}')
        say(f'    Rotate {rng.uniform(-9, 9):.2f} 0 1 0')
        if rng.random() < 0.5:
            say('    Scale -1 1 1')
        say('    ObjectInstance "chain"')
        say('  AttributeEnd')
    say('  AttributeBegin')
    say('    Bxdf "PxrSurface" "paving" "color diffuseColor" [0.34 0.33 0.36] "color specularFaceColor" [0.04 0.04 0.04]')
    say('      "color specularEdgeColor" [1 1 1] "float specularRoughness" [0.3]')
    say('    Polygon "P" [-30 0 -12  -30 0 40  30 0 40  30 0 -12]')
    say('  AttributeEnd')
    for side in (-1, 1):  # houses on both sides
        for k in range(7):
            height, depth = rng.uniform(3.8, 6.2), 3.3
            z = -4 + k * 3.6
            x = side * rng.uniform(7.6, 8.2)
            shade = rng.uniform(0.25, 0.5)
            say('  AttributeBegin')
            say(f'    Bxdf "PxrDiffuse" "house" "color diffuseColor" [{shade:.2f} {shade * 0.85:.2f} {shade * 0.7:.2f}]')
            a, b = x, x + side * 6
            say(f'    PointsPolygons [4 4 4 4] [0 1 2 3  1 4 5 2  4 6 7 5  3 2 5 7] "P" [{a:.2f} 0 {z:.2f}  {a:.2f} 0 {z + depth:.2f}  {a:.2f} {height:.2f} {z + depth:.2f}  {a:.2f} {height:.2f} {z:.2f}  {b:.2f} 0 {z + depth:.2f}  {b:.2f} {height:.2f} {z + depth:.2f}  {b:.2f} 0 {z:.2f}  {b:.2f} {height:.2f} {z:.2f}]')
            say('  AttributeEnd')
    for k in range(9):  # people, as pawns
        x, z = rng.uniform(-4.5, 4.5), rng.uniform(-1, 9)
        hue = [rng.uniform(0.1, 0.6) for _ in range(3)]
        say('  AttributeBegin')
        say(f'    Translate {x:.2f} 0 {z:.2f}')
        say(f'    Bxdf "PxrSurface" "coat" "color diffuseColor" [{hue[0]:.2f} {hue[1]:.2f} {hue[2]:.2f}] "color specularFaceColor" [0.04 0.04 0.04] "color specularEdgeColor" [1 1 1] "float specularRoughness" [0.15]')
        say('    AttributeBegin\n      Rotate -90 1 0 0\n      Cone 1.5 0.38 360\n    AttributeEnd')
        say('    Translate 0 1.45 0\n    Sphere 0.24 -0.24 0.24 360')
        say('  AttributeEnd')
    say('  AttributeBegin')
    say('    Translate 0.2 0.9 2.2')
    say('    Bxdf "PxrSurface" "globe" "float diffuseGain" [0] "int specularFresnelMode" [0] "color specularFaceColor" [0.9 0.9 0.9]')
    say('      "color specularEdgeColor" [1 1 1] "float specularRoughness" [0.05]')
    say('    Sphere 0.9 -0.9 0.9 360')
    say('  AttributeEnd')
    say('WorldEnd')
    path = sys.argv[1] if len(sys.argv) > 1 else "scenes/fairy_lights.rib"
    with open(path, "w") as f:
        f.write("\n".join(out) + "\n")


main()
