"""Pictures as arrays [row, column, channel]: EXR by the package OpenEXR, PNG by the standard library."""
import struct
import zlib

import numpy as np


def read_exr(path):
    import OpenEXR
    with OpenEXR.File(str(path), separate_channels=True) as f:
        channels = f.channels()
        return np.stack([np.asarray(channels[c].pixels, np.float64) for c in "RGB"], -1)


def write_exr(path, picture):
    import OpenEXR
    with OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage},
                      {"RGB": np.ascontiguousarray(picture, np.float32)}) as f:
        f.write(str(path))


def write_png(path, picture, larger=4):
    """sRGB-encoded, each pixel `larger` pixels wide."""
    x = np.clip(picture, 0, 1)
    x = np.where(x < 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    x = np.repeat(np.repeat((x * 255 + 0.5).astype(np.uint8), larger, 0), larger, 1)
    raw = b"".join(b"\0" + row.tobytes() for row in x)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    with open(path, "wb") as f:
        f.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", x.shape[1], x.shape[0], 8, 2, 0, 0, 0)) +
                chunk(b"IDAT", zlib.compress(raw)) + chunk(b"IEND", b""))


def sky(radiance, directions, path):
    """Writes the map of a dome whose texels look to `directions` [height, width, 3]."""
    write_exr(path, radiance(directions))


def sphere_mesh(center, radius, rows=160):
    """Points, triangles and normals of a finely faceted sphere, for renderers that know no other."""
    polar, turn = np.meshgrid(np.pi * np.arange(rows + 1) / rows, np.pi * np.arange(2 * rows) / rows, indexing="ij")
    normals = np.stack([np.sin(polar) * np.cos(turn), np.cos(polar), -np.sin(polar) * np.sin(turn)], -1).reshape(-1, 3)
    faces = triangles(rows, 2 * rows)
    # a hair larger, so that the body has the sphere's volume
    grow = (4 * np.pi / 3 / volume(normals, faces)) ** (1 / 3)
    return np.array(center) + radius * grow * normals, faces, normals


def triangles(rows, columns):
    faces = []
    for i in range(rows):
        for j in range(columns):
            a, b = i * columns + j, i * columns + (j + 1) % columns
            if i > 0:
                faces.append((a, a + columns, b))
            if i < rows - 1:
                faces.append((b, a + columns, b + columns))
    return faces


def volume(points, faces):
    p = points[np.array(faces)]
    return float(np.einsum("ij,ij->i", p[:, 0], np.cross(p[:, 1], p[:, 2])).sum() / 6)
