#!/usr/bin/python3
"""Writes a cloud whose voxels all differ to an OpenVDB file, and a scene with it to the standard output: for work on grids
that do not fit in memory (docs/media.md). Wants Debian's python3-openvdb and python3-numpy.

    tools/make_cloud_grid.py VOXELS FILE.vdb > scene.rib

VOXELS: of a side of the box; half of them, a ball, hold something. 1280 give a file of 3.8 GB and 4.5 GB of bricks.
"""
import os
import sys

SCENE = """Display "cloud.exr" "openexr" "Ci,a"
Format 320 240 1
PixelFilter "box" 1 1
Projection "perspective" "fov" [40]
Integrator "PxrPathTracer" "paths" "int maxIndirectBounces" [8]
Translate 0 0 4
WorldBegin
  Light "PxrDomeLight" "sky" "float intensity" [0.5]
  Light "PxrDistantLight" "sun" "float intensity" [2]
  Bxdf "PxrVolume" "cloud" "float densityFloat" [6] "color diffuseColor" [.9 .9 .9]
    "string densityFloatPrimVar" ["density"] "float maxDensity" [7]
  Volume "blobbydso:impl_openvdb" [-1 1 -1 1 -1 1] [0 0 0]
    "constant string[2] blobbydso:stringargs" ["{}" "density"] "varying float density" []
WorldEnd
"""


def main():
    if len(sys.argv) != 3 or not sys.argv[1].isdigit() or int(sys.argv[1]) < 8:
        sys.exit(__doc__)
    try:
        import numpy
        import pyopenvdb
    except ImportError as error:
        sys.exit(f"make_cloud_grid.py: {error}: Debian's python3-openvdb and python3-numpy have them")
    n, path = int(sys.argv[1]), sys.argv[2]
    grid = pyopenvdb.FloatGrid()
    grid.name = "density"
    random = numpy.random.default_rng(1)
    along = numpy.linspace(-1, 1, n, dtype=numpy.float32)
    for first in range(0, n, 32):
        x, y, z = numpy.meshgrid(along, along, along[first : first + 32], indexing="ij")
        density = 0.6 + 0.4 * numpy.sin(9 * x + 2 * y) * numpy.sin(7 * y + z) * numpy.sin(8 * z - x)
        density = (density * (0.9 + 0.2 * random.random(x.shape, dtype=numpy.float32))).astype(numpy.float32)
        density[x * x + y * y + z * z > 1] = 0
        grid.copyFromArray(density, ijk=(0, 0, first))
    grid.transform = pyopenvdb.createLinearTransform(voxelSize=2 / n)
    grid.transform.translate((-1, -1, -1))
    pyopenvdb.write(path, grids=[grid])
    print(SCENE.format(os.path.abspath(path)), end="")


if __name__ == "__main__":
    main()
