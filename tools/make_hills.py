#!/usr/bin/env python3
"""Writes a scene of delayed archives: SIDE x SIDE hills of 2 K K triangles each, seen from above their first row.
Usage: make_hills.py SIDE K FOLDER"""
import math
import os
import sys


def hill(number, k):
    points = []
    for y in range(k + 1):
        for x in range(k + 1):
            u, v = x / k - 0.5, y / k - 0.5
            h = 0.6 * math.exp(-12 * (u * u + v * v)) * (1 + 0.3 * math.sin(20 * u + number) * math.sin(17 * v))
            points.append(f"{u:.5f} {h:.5f} {v:.5f}")
    corners = [f"{a} {a + 1} {a + k + 2} {a + k + 1}" for y in range(k) for a in range(y * (k + 1), y * (k + 1) + k)]
    return (f'Bxdf "PxrDiffuse" "b" "color diffuseColor" [{0.2 + 0.1 * (number % 7):g} {0.2 + 0.1 * (number % 5):g} .3]\n'
            f'PointsPolygons [{"4 " * (k * k)}] [{" ".join(corners)}] "P" [{" ".join(points)}]\n')


def main():
    side, k, folder = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
    os.makedirs(folder, exist_ok=True)
    placed = ""
    for n in range(side * side):
        with open(f"{folder}/hill{n}.rib", "w") as f:
            f.write(hill(n, k))
        placed += (f"AttributeBegin\nTranslate {n % side - 0.5 * (side - 1):g} -1 {2 + n // side}\n"
                   f'Procedural "DelayedReadArchive" ["hill{n}.rib"] [-.5 .5 0 .8 -.5 .5]\nAttributeEnd\n')
    with open(f"{folder}/scene.rib", "w") as f:
        f.write(f"""Format 320 240 1
Projection "perspective" "fov" [60]
Display "hills.exr" "openexr" "rgba"
Rotate -35 1 0 0
Translate 0 {-0.35 * side:g} -0.5
Integrator "PxrPathTracer" "i"
WorldBegin
AttributeBegin
Rotate -50 1 .3 0
Light "PxrDistantLight" "sun" "float intensity" [2]
AttributeEnd
Light "PxrDomeLight" "dome" "float intensity" [.3]
{placed}WorldEnd
""")


main()
