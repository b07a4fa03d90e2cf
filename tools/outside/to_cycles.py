"""Cycles' side (Python package `bpy`). Spheres are finely faceted with normals; lights are planes that emit on one side."""
import math

import numpy as np

from . import pictures
from .scenes import Boundary, Conductor, Diffuser, Dome, Glass, Lambert, Rectangle, Sphere, Walk


def placed_camera(bpy, scene):
    from mathutils import Matrix, Vector
    c = scene.camera
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle = "AUTO", math.radians(c.fov)
    data.clip_start = 0.01
    if c.lens:
        data.dof.use_dof, data.dof.focus_distance = True, c.focus
        data.dof.aperture_fstop = data.lens * 1e-3 / (2 * c.lens)
    eye, z = Vector(c.eye), (Vector(c.eye) - Vector(c.target)).normalized()
    x = Vector((0, 1, 0)).cross(z).normalized()
    m = Matrix((x, z.cross(x), z)).transposed().to_4x4()
    m.translation = eye
    camera = bpy.data.objects.new("camera", data)
    camera.matrix_world = m
    return camera


def linear(color):
    return (*[float(x) for x in color], 1)


def material(bpy, m, medium):
    out = bpy.data.materials.new("m")
    out.use_nodes = True
    nodes, links = out.node_tree.nodes, out.node_tree.links
    nodes.clear()
    end = nodes.new("ShaderNodeOutputMaterial")
    n = None
    if isinstance(m, Lambert):
        n = nodes.new("ShaderNodeBsdfDiffuse")
        n.inputs["Color"].default_value, n.inputs["Roughness"].default_value = linear(m.color), 0
    elif isinstance(m, Glass):
        n = nodes.new("ShaderNodeBsdfGlass")
        n.distribution = "GGX"
        n.inputs["Color"].default_value, n.inputs["Roughness"].default_value, n.inputs["IOR"].default_value = (1, 1, 1, 1), math.sqrt(m.alpha), m.ior
    elif isinstance(m, Conductor):
        n = nodes.new("ShaderNodeBsdfMetallic")
        n.distribution, n.fresnel_type = "GGX", "PHYSICAL_CONDUCTOR"
        n.inputs["IOR"].default_value, n.inputs["Extinction"].default_value = m.eta, m.k
        n.inputs["Roughness"].default_value = math.sqrt(m.alpha)
        if m.tint != 1:
            mix, black = nodes.new("ShaderNodeMixShader"), nodes.new("ShaderNodeBsdfDiffuse")
            black.inputs["Color"].default_value = (0, 0, 0, 1)
            mix.inputs[0].default_value = m.tint
            links.new(black.outputs[0], mix.inputs[1])
            links.new(n.outputs[0], mix.inputs[2])
            n = mix
    elif isinstance(m, Diffuser):
        n = nodes.new("ShaderNodeBsdfTranslucent")
        n.inputs["Color"].default_value = (1, 1, 1, 1)
    elif isinstance(m, Walk):  # the mean free path is the radius / (4 pi); what one scattering keeps is found by a fit
        n = nodes.new("ShaderNodeSubsurfaceScattering")
        n.falloff = "RANDOM_WALK"
        n.inputs["Color"].default_value, n.inputs["Scale"].default_value = linear(m.color), 1
        n.inputs["Radius"].default_value = (4 * math.pi / np.array(medium.extinction)).tolist()
        medium = None
    elif not isinstance(m, Boundary):
        raise TypeError(m)
    if n is not None:
        links.new(n.outputs[0], end.inputs["Surface"])
    if medium is not None:
        if medium.grid is not None:
            raise TypeError(medium)
        v = nodes.new("ShaderNodeVolumeCoefficients")
        v.phase = "HENYEY_GREENSTEIN"
        extinction, albedo = np.array(medium.extinction), np.array(medium.albedo)
        v.inputs["Absorption Coefficients"].default_value = (extinction * (1 - albedo)).tolist()
        v.inputs["Scatter Coefficients"].default_value = (extinction * albedo).tolist()
        v.inputs["Anisotropy"].default_value = medium.g
        links.new(v.outputs[0], end.inputs["Volume"])
    return out


def emitting(bpy, radiance):
    out = bpy.data.materials.new("light")
    out.use_nodes = True
    nodes, links = out.node_tree.nodes, out.node_tree.links
    nodes.clear()
    end, emission, side, front = (nodes.new("ShaderNode" + x) for x in ("OutputMaterial", "Emission", "NewGeometry", "Math"))
    strength = max(radiance)
    front.operation = "MULTIPLY_ADD"  # strength * (1 - backfacing)
    front.inputs[1].default_value, front.inputs[2].default_value = -strength, strength
    links.new(side.outputs["Backfacing"], front.inputs[0])
    emission.inputs["Color"].default_value = linear(np.array(radiance) / strength)
    links.new(front.outputs[0], emission.inputs["Strength"])
    links.new(emission.outputs[0], end.inputs["Surface"])
    out.cycles.emission_sampling = "FRONT"
    return out


def add_mesh(bpy, points, faces, made, smooth):
    mesh = bpy.data.meshes.new("mesh")
    mesh.from_pydata([tuple(map(float, p)) for p in points], [], [tuple(map(int, f)) for f in faces])
    mesh.materials.append(made)
    for p in mesh.polygons:
        p.use_smooth = smooth
    o = bpy.data.objects.new("object", mesh)
    o.cycles.shadow_terminator_offset = o.cycles.shadow_terminator_geometry_offset = 0
    bpy.context.scene.collection.objects.link(o)


def sky(bpy, l, folder):
    w, h = 1024, 512
    u, v = np.meshgrid((np.arange(w) + 0.5) / w, (np.arange(h) + 0.5) / h)
    turn, up = -2 * np.pi * (u - 0.5), np.pi * (0.5 - v)
    pictures.sky(l.radiance, np.stack([np.cos(turn) * np.cos(up), np.sin(turn) * np.cos(up), np.sin(up)], -1), folder / "sky_cycles.exr")
    world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    end, background, image = (nodes.new("ShaderNode" + x) for x in ("OutputWorld", "Background", "TexEnvironment"))
    image.image = bpy.data.images.load(str(folder / "sky_cycles.exr"))
    image.image.colorspace_settings.name = "Linear Rec.709"
    links.new(image.outputs[0], background.inputs[0])
    links.new(background.outputs[0], end.inputs[0])
    world.cycles.sampling_method, world.cycles.sample_map_resolution = "MANUAL", 1024
    return world


def render(scene, side, resolution, seeds, folder):
    import bpy
    bpy.ops.wm.read_factory_settings(use_empty=True)
    s = bpy.context.scene
    s.render.engine = "CYCLES"
    s.render.resolution_x = s.render.resolution_y = resolution
    s.render.resolution_percentage = 100
    s.render.threads_mode, s.render.threads = "FIXED", 2
    s.render.image_settings.file_format, s.render.image_settings.color_depth = "OPEN_EXR", "32"
    s.render.film_transparent = False
    c = s.cycles
    c.device, c.samples, c.use_adaptive_sampling, c.use_denoising = "CPU", side.samples, False, False
    c.pixel_filter_type, c.sample_clamp_direct, c.sample_clamp_indirect = "BOX", 0, 0
    c.caustics_reflective = c.caustics_refractive = True
    c.blur_glossy = c.light_sampling_threshold = 0
    c.max_bounces = c.diffuse_bounces = c.glossy_bounces = c.transmission_bounces = c.volume_bounces = scene.bounces
    c.transparent_max_bounces = 1000
    c.min_light_bounces = c.min_transparent_bounces = 0
    c.use_guiding = False
    s.camera = placed_camera(bpy, scene)
    s.collection.objects.link(s.camera)
    s.world = bpy.data.worlds.new("black")
    s.world.use_nodes = True
    for n in s.world.node_tree.nodes:
        if n.type == "BACKGROUND":
            n.inputs[0].default_value = (0, 0, 0, 1)
    for l in scene.lights:
        if isinstance(l, Dome):
            s.world = sky(bpy, l, folder)
        elif isinstance(l, Rectangle):
            a, b, o = np.array(l.a, float), np.array(l.b, float), np.array(l.center, float)
            add_mesh(bpy, [o - a - b, o + a - b, o + a + b, o - a + b], [(0, 1, 2, 3)], emitting(bpy, l.radiance), False)
        else:
            raise TypeError(l)
    for o in scene.walking() if side.method == "random_walk" else scene.objects:
        if isinstance(o.shape, Sphere):
            points, faces, _ = pictures.sphere_mesh(o.shape.center, o.shape.radius)
        else:
            points, faces = o.shape.points, o.shape.faces
        add_mesh(bpy, points, faces, material(bpy, o.material, o.medium), isinstance(o.shape, Sphere))
    for seed in seeds:
        c.seed = seed
        s.render.filepath = str(folder / f"cycles-{seed}.exr")
        bpy.ops.render.render(write_still=True)
        yield pictures.read_exr(s.render.filepath)
