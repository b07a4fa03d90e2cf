#!/usr/bin/env python3
"""Writes a room with a partition, half a roof and 3, 5, 9 or 13 lights (discs, meshes, a sun, a dome), of which most places
see a part: what choice among lights is measured by.

  tools/make_lit_room.py LIGHTS [BOUNCES] > room.rib
"""
import sys

COUNT = int(sys.argv[1]) if len(sys.argv) > 1 else 13
BOUNCES = int(sys.argv[2]) if len(sys.argv) > 2 else 0
if COUNT not in (3, 5, 9, 13):
    sys.exit(__doc__)
lights = []


def light(place, kind, intensity, more=""):
    lights.append(f'AttributeBegin\n  {place}\n  Light "{kind}" "light{len(lights)}" "float intensity" [{intensity}] {more}\nAttributeEnd')


def disc(x, y, z, size, intensity, color="1 1 1"):  # shines downwards
    light(f"ConcatTransform [{size} 0 0 0  0 0 {size} 0  0 {-size} 0 0  {x} {y} {z} 1]", "PxrDiskLight", intensity,
          f'"color lightColor" [{color}]')


def mesh(x, y, z, intensity):
    light(f"Translate {x} {y} {z}", "PxrMeshLight", intensity,
          '\n  PointsPolygons [3 3 3 3] [0 1 2  0 2 3  0 3 1  1 3 2]'
          ' "vertex point P" [0 0.2 0  -0.15 -0.1 0.1  0.15 -0.1 0.1  0 -0.1 -0.15]')


def sun():
    light("Rotate 60 1 0.5 0", "PxrDistantLight", 30000, '"float angleExtent" [0.5]')


if COUNT == 3:
    disc(-2, 2.5, 2, 0.3, 96)
    disc(2, 2.5, 2, 0.3, 96)
    sun()
else:
    disc(-2.5, 2.6, 1.5, 0.3, 80)
    disc(2.5, 2.6, 1.5, 0.3, 80)
    mesh(-1.2, 1.6, 3, 48)
    sun()
    light("", "PxrDomeLight", 0.6, '"color lightColor" [0.6 0.8 1]')
if COUNT >= 9:
    disc(-1, 2.6, 3.2, 0.25, 64)
    disc(1, 2.6, 3.2, 0.25, 64, "1 0.7 0.4")
    mesh(1.2, 1.2, 2.4, 56)
    mesh(2.6, 0.4, 3.4, 24)
if COUNT >= 13:
    disc(-3.2, 1.2, 3.4, 0.2, 80)
    disc(3.2, 2.2, 0.8, 0.2, 112)
    mesh(-2.6, 0.5, 0.8, 36)
    mesh(0.5, 0.4, 1.2, 20)


def wall(points):
    return f'Polygon "vertex point P" [{points}]'


SPECULAR = '"int specularFresnelMode" [1] "color specularEdgeColor" [1 1 1] "int specularModelType" [1]'
print(f"""Hider "raytrace" "int maxsamples" [64]
Display "lit_room.exr" "openexr" "rgba"
Format 160 120 1
PixelFilter "box" 1 1
Integrator "PxrPathTracer" "paths" "int maxIndirectBounces" [{BOUNCES}]
Projection "perspective" "fov" [65]
Translate 0 -1.4 1.2
WorldBegin
AttributeBegin
Attribute "visibility" "int camera" [0]""")
print("\n".join(lights))
print(f"""AttributeEnd
AttributeBegin
  Bxdf "PxrSurface" "floor" "color diffuseColor" [0.5 0.45 0.4] "color specularIor" [1.5 1.5 1.5] "float specularRoughness" [0.3]
    {SPECULAR}
  {wall("-4 0 0  -4 0 5  4 0 5  4 0 0")}
AttributeEnd
Bxdf "PxrDiffuse" "wall" "color diffuseColor" [0.7 0.7 0.65]
{wall("-4 0 5  4 0 5  4 3 5  -4 3 5")}
{wall("-4 0 0  -4 0 5  -4 3 5  -4 3 0")}
{wall("4 0 0  4 0 5  4 3 5  4 3 0")}
# the partition, the roof
{wall("0 0 1.2  0 0 5  0 2.9 5  0 2.9 1.2")}
{wall("-4 3 0  0 3 0  0 3 5  -4 3 5")}
{wall("0.8 3 0  4 3 0  4 3 1.5  0.8 3 1.5")}
# shelves
{wall("1 1 3.5  2.2 1 3.5  2.2 1 4.2  1 1 4.2")}
{wall("-3.2 1 1  -2 1 1  -2 1 2.2  -3.2 1 2.2")}
AttributeBegin
  Translate -1.8 0.5 2.6
  Sphere 0.5 -0.5 0.5 360
AttributeEnd
AttributeBegin
  Bxdf "PxrSurface" "glossy" "color diffuseColor" [0.3 0.1 0.1] "color specularIor" [1.8 1.8 1.8] "float specularRoughness" [0.15]
    {SPECULAR}
  Translate 2 0.6 2.2
  Sphere 0.6 -0.6 0.6 360
AttributeEnd
WorldEnd""")
