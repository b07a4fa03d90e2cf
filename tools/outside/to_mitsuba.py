"""Mitsuba's side (Python package `mitsuba`), in the variant for LLVM where that library is found."""
import numpy as np

from . import pictures
from .scenes import Boundary, Conductor, Diffuser, Dome, Glass, Lambert, Rectangle, Sphere, Spot


def start():
    import mitsuba as mi
    for variant in ("scalar_rgb",):
        try:
            mi.set_variant(variant)
            if variant == "llvm_ad_rgb":
                import drjit as dr
                dr.eval(dr.arange(mi.Float, 2) + 1)
            return mi
        except Exception:
            continue
    raise SystemExit("mitsuba has no variant that runs here")


def diffuser(mi):
    """A boundary that lets everything through by a cosine's law, from either side."""
    import drjit as dr

    class Through(mi.BSDF):
        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            self.m_flags = mi.BSDFFlags.DiffuseTransmission | mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            self.m_components = [self.m_flags]

        def sample(self, ctx, si, sample1, sample2, active=True):
            cos_i = mi.Frame3f.cos_theta(si.wi)
            wo = mi.warp.square_to_cosine_hemisphere(sample2)
            bs = mi.BSDFSample3f()
            bs.pdf = mi.warp.square_to_cosine_hemisphere_pdf(wo)
            bs.wo = mi.Vector3f(wo.x, wo.y, dr.select(cos_i > 0, -wo.z, wo.z))
            bs.eta = 1.0
            bs.sampled_type = mi.UInt32(+mi.BSDFFlags.DiffuseTransmission)
            bs.sampled_component = mi.UInt32(0)
            return bs, dr.select(active & (cos_i != 0), mi.Spectrum(1), 0)

        def eval(self, ctx, si, wo, active=True):
            across = mi.Frame3f.cos_theta(si.wi) * mi.Frame3f.cos_theta(wo) < 0
            return dr.select(active & across, mi.Spectrum(dr.abs(mi.Frame3f.cos_theta(wo)) / dr.pi), 0)

        def pdf(self, ctx, si, wo, active=True):
            across = mi.Frame3f.cos_theta(si.wi) * mi.Frame3f.cos_theta(wo) < 0
            return dr.select(active & across, dr.abs(mi.Frame3f.cos_theta(wo)) / dr.pi, 0)

        def eval_pdf(self, ctx, si, wo, active=True):
            return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)

        def to_string(self):
            return "Through[]"

    mi.register_bsdf("through", Through)


def rgb(color):
    return {"type": "rgb", "value": [float(x) for x in color]}


def bsdf(m):
    if isinstance(m, Lambert):
        return {"type": "twosided", "inner": {"type": "diffuse", "reflectance": rgb(m.color)}}
    if isinstance(m, Glass):
        if m.alpha:
            return {"type": "roughdielectric", "distribution": "ggx", "alpha": m.alpha, "int_ior": m.ior, "ext_ior": 1.0}
        return {"type": "dielectric", "int_ior": m.ior, "ext_ior": 1.0}
    if isinstance(m, Conductor):
        return {"type": "twosided", "inner": {"type": "roughconductor", "distribution": "ggx", "alpha": m.alpha, "eta": rgb(m.eta), "k": rgb(m.k),
                                              "specular_reflectance": rgb([m.tint] * 3)}}
    if isinstance(m, Boundary):
        return {"type": "null"}
    if isinstance(m, Diffuser):
        return {"type": "through"}
    raise TypeError(m)


def medium(mi, m, shape):
    out = {"phase": {"type": "hg", "g": m.g} if m.g else {"type": "isotropic"},
           "albedo": {"type": "constvolume", "value": rgb(m.albedo)}}
    if m.grid is None:
        return {"type": "homogeneous", "sigma_t": {"type": "constvolume", "value": rgb(m.extinction)}, **out}
    # its values are those of cells' middles; ours lie on the bound, which is half a cell inside
    points = np.array(shape.points, float)
    low, high = points.min(0), points.max(0)
    cells = np.array(m.grid.shape[::-1]) - 1.0
    half = (high - low) / cells / 2
    place = mi.ScalarTransform4f().translate((low - half).tolist()) @ mi.ScalarTransform4f().scale((high - low + 2 * half).tolist())
    assert len(set(m.extinction)) == 1
    return {"type": "heterogeneous", "scale": m.extinction[0],
            "sigma_t": {"type": "gridvolume", "grid": mi.VolumeGrid(np.ascontiguousarray(m.grid[..., None], np.float32)), "to_world": place,
                        "filter_type": "trilinear", "wrap_mode": "clamp", "raw": True}, **out}


def description(mi, scene, side, resolution, folder):
    c = scene.camera
    T = mi.ScalarTransform4f
    lens = {"type": "thinlens", "aperture_radius": c.lens, "focus_distance": c.focus} if c.lens else {"type": "perspective"}
    d = {"type": "scene",
         "integrator": {"type": side.method, "max_depth": scene.bounces + 2, "rr_depth": 100000},
         "sensor": {**lens, "fov": c.fov, "near_clip": 0.01, "to_world": T().look_at(origin=list(c.eye), target=list(c.target), up=[0, 1, 0]),
                    "film": {"type": "hdrfilm", "width": resolution, "height": resolution, "pixel_format": "rgb", "component_format": "float32",
                             "rfilter": {"type": "box"}},
                    "sampler": {"type": "independent", "sample_count": side.samples}}}
    for i, l in enumerate(scene.lights):
        if isinstance(l, Rectangle):
            a, b = np.array(l.a, float), np.array(l.b, float)
            n = np.cross(a, b)
            m = np.eye(4)
            m[:3, 0], m[:3, 1], m[:3, 2], m[:3, 3] = a, b, n / np.linalg.norm(n), l.center
            d[f"light{i}"] = {"type": "rectangle", "to_world": T(m), "bsdf": {"type": "diffuse", "reflectance": rgb((0, 0, 0))},
                              "emitter": {"type": "area", "radiance": rgb(l.radiance)}}
        elif isinstance(l, Spot):
            p = np.array(l.position, float)
            d[f"light{i}"] = {"type": "spot", "to_world": T().look_at(origin=p.tolist(), target=(p + l.direction).tolist(), up=[0, 0, 1]),
                              "intensity": rgb(l.intensity), "cutoff_angle": l.angle, "beam_width": l.angle - 1e-3}
        elif isinstance(l, Dome):
            # its rows run from pole to pole, its columns are half a texel aside
            w, h = 1024, 513
            u, v = np.meshgrid((np.arange(w) + 0.5) / w, np.arange(h) / (h - 1))
            turn, polar = 2 * np.pi * u, np.pi * v
            map = l.radiance(np.stack([np.sin(turn) * np.sin(polar), np.cos(polar), -np.cos(turn) * np.sin(polar)], -1))
            d[f"light{i}"] = {"type": "envmap", "bitmap": mi.Bitmap(np.ascontiguousarray(map, np.float32))}
    for i, o in enumerate(scene.objects):
        more = {"bsdf": bsdf(o.material)}
        if o.medium is not None:
            more["interior"] = medium(mi, o.medium, o.shape)
        if isinstance(o.shape, Sphere):
            d[f"object{i}"] = {"type": "sphere", "center": list(o.shape.center), "radius": o.shape.radius, **more}
            continue
        file = folder / f"object{i}.ply"
        triangles = [(f[0], f[k], f[k + 1]) for f in o.shape.faces for k in range(1, len(f) - 1)]
        with open(file, "w") as f:
            f.write(f"ply\nformat ascii 1.0\nelement vertex {len(o.shape.points)}\nproperty float x\nproperty float y\nproperty float z\n"
                    f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n")
            f.writelines("%.9g %.9g %.9g\n" % tuple(p) for p in o.shape.points)
            f.writelines("3 %d %d %d\n" % t for t in triangles)
        d[f"object{i}"] = {"type": "ply", "filename": str(file), "face_normals": True, **more}
    return d


def render(scene, side, resolution, seeds, folder):
    mi = start()
    mi.set_log_level(mi.LogLevel.Error)
    if any(isinstance(o.material, Diffuser) for o in scene.objects):
        diffuser(mi)
    loaded = mi.load_dict(description(mi, scene, side, resolution, folder))
    for seed in seeds:
        yield np.array(mi.render(loaded, spp=side.samples, seed=seed), np.float64)
