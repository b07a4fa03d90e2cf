"""LuxCoreRender's side (Python package `pyluxcore`). It knows no spheres: finely faceted ones with normals stand for them."""
import contextlib
import math
import os
import time

import numpy as np

from . import pictures
from .scenes import Boundary, Dome, Glass, Lambert, Rectangle, Sphere


def text(values):
    return " ".join(f"{x:.9g}" for x in np.ravel(values))


@contextlib.contextmanager
def quiet():
    """It prints from C++, to both streams."""
    keep = [os.dup(1), os.dup(2)]
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1), os.dup2(nowhere, 2)
    try:
        yield
    finally:
        os.dup2(keep[0], 1), os.dup2(keep[1], 2)


def define(scene, name, shape):
    if isinstance(shape, Sphere):
        points, faces, normals = pictures.sphere_mesh(shape.center, shape.radius)
        normals = [tuple(map(float, n)) for n in normals]
    else:
        points, normals = shape.points, None
        faces = [(f[0], f[i], f[i + 1]) for f in shape.faces for i in range(1, len(f) - 1)]
    scene.DefineMesh(name, [tuple(map(float, p)) for p in points], [tuple(map(int, f)) for f in faces], normals, None, None, None)


def material(name, m, medium):
    p = {}
    base = f"scene.materials.{name}."
    if isinstance(m, Lambert):
        p[base + "type"], p[base + "kd"] = "matte", text(m.color)
    elif isinstance(m, Glass) and not m.alpha:
        p[base + "type"], p[base + "kr"], p[base + "kt"] = "glass", "1 1 1", "1 1 1"
        p[base + "interiorior"], p[base + "exteriorior"] = str(m.ior), "1"
    elif isinstance(m, Boundary):
        p[base + "type"] = "null"
    else:
        raise TypeError(m)
    if medium is not None:
        # its phase function is Schlick's: comparable where scattering is even
        if medium.g or medium.grid is not None:
            raise TypeError(medium)
        extinction, albedo = np.array(medium.extinction), np.array(medium.albedo)
        v = f"scene.volumes.inside_{name}."
        p[v + "type"], p[v + "scattering"], p[v + "absorption"] = "homogeneous", text(extinction * albedo), text(extinction * (1 - albedo))
        p[v + "asymmetry"], p[v + "multiscattering"] = "0 0 0", "1"
        p[base + "volume.interior"] = f"inside_{name}"
    return p


def render(scene, side, resolution, seeds, folder):
    import pyluxcore
    c = scene.camera
    # its pictures stand a pixel low: rays of row y are those of h - 1 - y, y not rounded. So a margin is rendered and cut off.
    margin = resolution + 2
    fov = math.degrees(2 * math.atan(math.tan(math.radians(c.fov) / 2) * margin / resolution))
    with quiet():
        pyluxcore.Init()
    for seed in seeds:
        with quiet():
            s = pyluxcore.Scene()
            props = {"scene.camera.type": "perspective", "scene.camera.lookat.orig": text(c.eye), "scene.camera.lookat.target": text(c.target),
                     "scene.camera.up": "0 1 0", "scene.camera.fieldofview": f"{fov:.9g}", "scene.camera.autofocus.enable": "0",
                     "scene.camera.lensradius": "0"}
            volumes = {}
            for i, l in enumerate(scene.lights):
                if not isinstance(l, Rectangle):
                    raise TypeError(l)
                a, b, o = np.array(l.a, float), np.array(l.b, float), np.array(l.center, float)
                s.DefineMesh(f"light{i}", [tuple(map(float, o + x * a + y * b)) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))],
                             [(0, 1, 2), (0, 2, 3)], None, None, None, None)
                base = f"scene.materials.light{i}."
                props.update({base + "type": "matte", base + "kd": "0 0 0", base + "emission": text(l.radiance), base + "emission.gain": "1 1 1",
                              base + "emission.power": "0", base + "emission.efficency": "0",
                              f"scene.objects.light{i}.shape": f"light{i}", f"scene.objects.light{i}.material": f"light{i}"})
            for i, o in enumerate(scene.objects):
                name = f"object{i}"
                define(s, name, o.shape)
                made = material(name, o.material, o.medium)
                volumes.update({k: v for k, v in made.items() if k.startswith("scene.volumes")})
                props.update({k: v for k, v in made.items() if not k.startswith("scene.volumes")})
                props.update({f"scene.objects.{name}.shape": name, f"scene.objects.{name}.material": name})
            def properties(d):
                out = pyluxcore.Properties()
                for k, v in d.items():
                    out.Set(pyluxcore.Property(k, v.split(" ") if " " in v else v))
                return out
            if volumes:
                s.Parse(properties(volumes))
            s.Parse(properties(props))
            depth = str(scene.bounces + 1)
            config = {"renderengine.type": side.method, "renderengine.seed": str(seed + 1), "sampler.type": "RANDOM", "native.threads.count": "1",
                      "film.width": str(margin), "film.height": str(margin), "film.filter.type": "BOX", "film.filter.width": "0.5", "sampler.random.adaptive.strength": "0", "film.noiseestimation.warmup": "0",
                      "batch.haltspp": str(side.samples), "batch.halttime": "0", "batch.haltthreshold": "0",
                      "path.pathdepth.total": depth, "path.pathdepth.diffuse": depth, "path.pathdepth.glossy": depth, "path.pathdepth.specular": depth,
                      "path.russianroulette.depth": "1000", "path.clamping.variance.maxvalue": "0", "path.hybridbackforward.enable": "0",
                      "path.maxdepth": depth, "light.maxdepth": depth, "bidirvm.startradius.scale": "0.002",
                      "film.outputs.0.type": "RGB", "film.outputs.0.filename": "rgb.exr", "film.imagepipelines.0.0.type": "NOP"}
            session = pyluxcore.RenderSession(pyluxcore.RenderConfig(properties(config), s))
            session.Start()
            while not session.HasDone():
                time.sleep(0.05)
                session.UpdateStats()
            session.Stop()
            out = np.zeros(margin * margin * 3, np.float32)
            session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, out, 0)
        yield out.reshape(margin, margin, 3)[::-1][2:, 1:-1].astype(np.float64)
