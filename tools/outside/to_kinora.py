"""Kinora's side: the scene as RIB."""
import math
import pathlib
import subprocess

import numpy as np

from . import pictures
from .scenes import Boundary, Conductor, Dome, Glass, Lambert, Rectangle, Sphere, Spot, Walk


def numbers(values):
    return "[" + " ".join(f"{x:.9g}" for x in np.ravel(values)) + "]"


def frame_along(z):
    """Rows x, y, z of a right-handed frame."""
    z = np.array(z, float) / np.linalg.norm(z)
    x = np.cross((0, 1, 0) if abs(z[1]) < 0.9 else (1, 0, 0), z)
    x /= np.linalg.norm(x)
    return np.array([x, np.cross(z, x), z])


def placed(rows, origin):
    m = np.eye(4)
    m[:3, :3], m[3, :3] = rows, origin
    return f"ConcatTransform {numbers(m)}"


def inside(medium):
    return f'"color extinction" {numbers(medium.extinction)} "color ssAlbedo" {numbers(medium.albedo)} "float g" [{medium.g}] "int multiScatter" [1]'


def material(m, medium):
    if isinstance(m, Lambert):
        return f'Bxdf "PxrDiffuse" "m" "color diffuseColor" {numbers(m.color)}'
    if isinstance(m, Glass):
        return (f'Bxdf "PxrSurface" "m" "float diffuseGain" [0] "float refractionGain" [1] "float reflectionGain" [1] '
                f'"float glassRoughness" [{math.sqrt(m.alpha):.9g}] "float glassIor" [{m.ior}] ' + (inside(medium) if medium else ""))
    if isinstance(m, Conductor):
        return (f'Bxdf "PxrSurface" "m" "float diffuseGain" [0] "int specularFresnelMode" [1] "int specularModelType" [1] '
                f'"color specularEdgeColor" {numbers([m.tint] * 3)} "color specularIor" {numbers(m.eta)} '
                f'"color specularExtinctionCoeff" {numbers(m.k)} "float specularRoughness" [{math.sqrt(m.alpha):.9g}]')
    if isinstance(m, Boundary):
        return (f'Bxdf "PxrVolume" "m" "color densityColor" {numbers(medium.extinction)} "color diffuseColor" {numbers(medium.albedo)} '
                f'"float anisotropy" [{medium.g}] "int multiScatter" [1]' +
                (' "string densityFloatPrimVar" ["density"]' if medium.grid is not None else ""))
    if isinstance(m, Walk):
        return (f'Bxdf "PxrSurface" "m" "float diffuseGain" [0] "int subsurfaceType" [4] "float subsurfaceGain" [1] "float unitLength" [1] '
                f'"float subsurfaceDiffuseSwitch" [0] "color subsurfaceColor" {numbers(m.color)} "float subsurfaceDmfp" [1] '
                f'"color subsurfaceDmfpColor" {numbers(m.reach)}')
    raise TypeError(m)


def shape(o):
    if isinstance(o.shape, Sphere):
        r = f"{o.shape.radius:.9g}"
        # finer than two pixels, so that outlines are those of round bodies
        return f"Attribute \"dice\" \"float micropolygonlength\" [0.1] Translate {' '.join(map(str, o.shape.center))} Sphere {r} -{r} {r} 360"
    points = np.array(o.shape.points, float)
    if o.medium is not None and o.medium.grid is not None:
        bound = np.ravel(np.stack([points.min(0), points.max(0)], 1))
        grid = o.medium.grid
        return f'Volume "box" {numbers(bound)} [{grid.shape[2]} {grid.shape[1]} {grid.shape[0]}] "varying float density" {numbers(grid)}'
    return (f"PointsPolygons {numbers([len(f) for f in o.shape.faces])} {numbers(sum(o.shape.faces, []))} "
            f'"vertex point P" {numbers(points)}')


def light(l, folder):
    if isinstance(l, Rectangle):
        a, b = np.array(l.a, float), np.array(l.b, float)
        n = np.cross(a, b)
        # the unit square's sides are one
        return placed([2 * a, 2 * b, n / np.linalg.norm(n)], l.center) + f' Light "PxrRectLight" "l" "float intensity" [1] "color lightColor" {numbers(l.radiance)}'
    if isinstance(l, Spot):
        return placed(frame_along(l.direction), l.position) + (
            f' Light "PointLight" "l" "float intensity" [1] "float coneAngle" [{l.angle}] "color lightColor" {numbers(l.intensity)}')
    if isinstance(l, Dome):
        w, h = 1024, 512
        u, v = np.meshgrid((np.arange(w) + 0.5) / w, (np.arange(h) + 0.5) / h)
        turn, polar = -2 * np.pi * u, np.pi * v
        pictures.sky(l.radiance, np.stack([np.cos(turn) * np.sin(polar), np.sin(turn) * np.sin(polar), np.cos(polar)], -1), folder / "sky.exr")
        return f'Light "PxrDomeLight" "l" "float intensity" [1] "string lightColorMap" ["{folder / "sky.exr"}"]'
    raise TypeError(l)


def rib(scene, folder, integrator, sets, resolution):
    c = scene.camera
    eye, forward = np.array(c.eye, float), np.array(c.target, float) - np.array(c.eye, float)
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, (0, 1, 0))
    right /= np.linalg.norm(right)
    camera = np.eye(4)  # to a left-handed space that looks along z: the mirror is in the matrix
    camera[:3, :3] = np.array([right, np.cross(right, forward), forward]).T
    camera[3, :3] = -eye @ camera[:3, :3]
    parameters = {"clampLuminance": 1e30, **({"allowCaustics": 1} if integrator == "PxrPathTracer" else {}), **sets}
    lens = (f'Projection "PxrCamera" "float fov" [{c.fov}] "float fStop" [1] "float focalLength" [{2 * c.lens}] "float focalDistance" [{c.focus}]'
            if c.lens else f'Projection "perspective" "float fov" [{c.fov}]')
    lines = [f"# {scene.about}", f"Format {resolution} {resolution} 1", 'PixelFilter "box" 1 1',
             'Display "picture.exr" "openexr" "rgba" "string exrpixeltype" ["float"]', 'Hider "raytrace" "int maxsamples" [16] "int minsamples" [16]',
             f'Integrator "{integrator}" "i" "int maxIndirectBounces" [{scene.bounces}] ' +
             " ".join(f'"{"float" if isinstance(v, float) else "int"} {k}" [{v}]' for k, v in parameters.items()),
             lens, f"ConcatTransform {numbers(camera)}", "WorldBegin"]
    lines += [f"AttributeBegin {light(l, folder)} AttributeEnd" for l in scene.lights]
    for i, o in enumerate(scene.walking()):
        lines.append(f'AttributeBegin Attribute "identifier" "string name" ["object {i}"] {material(o.material, o.medium)} {shape(o)} AttributeEnd')
    return "\n".join(lines + ["WorldEnd", ""])


def render(scene, side, resolution, seeds, folder, kinora):
    folder = pathlib.Path(folder)
    file = folder / f"{side.method}.rib"
    file.write_text(rib(scene, folder, side.method, side.sets, resolution))
    for seed in seeds:
        out = folder / f"kinora-{seed}.exr"
        run = subprocess.run([kinora, "render", file, "-o", out, "--spp", str(side.samples), "--seed", str(seed), "-t", "2", "--progress", "none"],
                             cwd=folder, capture_output=True, text=True)
        if run.returncode or "warning" in run.stderr:
            print(run.stderr, end="")
        if run.returncode:
            raise SystemExit(f"kinora ended with code {run.returncode}; the scene is {file}")
        yield pictures.read_exr(out)
