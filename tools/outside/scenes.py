"""The scenes: simple things of exactly known meaning, from which each side writes its own.

Space is right-handed, y is up, the camera looks from eye to target; the picture is square and fov is that of its sides.
Lengths are the scene's, colours are linear Rec. 709, roughness is an alpha of GGX. Media are given by extinction, the share of
it that is scattered, and the mean cosine of Henyey and Greenstein. No light stands between another and what is seen: to Kinora's
other lights its area lights are not there (they cast no shadows), elsewhere their backs are black plates. Each scene says beside which renderers and methods it is
compared, and with how many samples a pixel for each of the seeds.
"""
import math
from dataclasses import dataclass, field
from typing import Callable, Optional

import numpy as np


@dataclass
class Camera:
    eye: tuple
    target: tuple
    fov: float
    lens: float = 0  # radius; 0 is a pinhole
    focus: float = 1


@dataclass
class Medium:
    extinction: tuple
    albedo: tuple
    g: float = 0
    grid: Optional[np.ndarray] = None  # [z, y, x] factors on the extinction at points that divide the object's bound evenly


@dataclass
class Lambert:
    color: tuple


@dataclass
class Glass:
    ior: float
    alpha: float = 0


@dataclass
class Conductor:
    eta: tuple
    k: tuple
    alpha: float
    tint: float = 1


@dataclass
class Boundary:
    """Bounds a medium and does nothing else."""


@dataclass
class Diffuser:
    """Lets all light through, by a cosine's law whatever its direction was: the boundary of Kinora's walks."""


@dataclass
class Walk:
    """Subsurface scattering by a random walk: other words for a Diffuser round the medium, by albedo and reach of a half space."""
    color: tuple
    reach: tuple


@dataclass
class Sphere:
    center: tuple
    radius: float


@dataclass
class Mesh:
    points: list
    faces: list  # of 3 or 4 points each, counterclockwise seen from outside


@dataclass
class Object:
    shape: object
    material: object
    medium: Optional[Medium] = None


@dataclass
class Rectangle:
    """Emits to the side of a x b only; a and b are halves of the sides."""
    center: tuple
    a: tuple
    b: tuple
    radiance: tuple


@dataclass
class Dome:
    radiance: Callable  # of directions [..., 3], to where they look


@dataclass
class Spot:
    """A point with an even cone of light, which ends at `angle` degrees off its axis."""
    position: tuple
    direction: tuple
    angle: float
    intensity: tuple


@dataclass
class Side:
    renderer: str  # kinora, mitsuba, luxcore, cycles
    method: str
    samples: int
    sets: dict = field(default_factory=dict)
    # Compared by the mean of the whole picture only: what light paths of LuxCore 2.11 bring stands one row away from what camera
    # paths bring, and its merging loses the samples of the last, unfinished batch.
    whole: bool = False


@dataclass
class Scene:
    about: str
    camera: Camera
    objects: list
    lights: list
    bounces: int  # segments of a path but the first and the last
    sides: list
    walks: list = field(default_factory=list)  # instead of the objects with a Diffuser, for sides that walk

    def walking(self):
        return [o for o in self.objects if not isinstance(o.material, Diffuser)] + self.walks


def sun_over_sea(d):
    """A smooth sky with a bright lobe, so that how maps are interpolated does not matter."""
    def lobe(axis, sharp):
        axis = np.array(axis) / np.linalg.norm(axis)
        return np.exp(sharp * (d @ axis - 1))[..., None]
    return (0.15 + 0.1 * d[..., 1:2]) * np.array([0.6, 0.8, 1.0]) + 5 * lobe((0.8, 0.7, 0.4), 20) * np.array([1, 0.8, 0.5]) + \
        1.5 * lobe((-0.9, 0.2, 0.3), 8) * np.array([0.3, 0.4, 1])


def quad(a, b, c, d):
    return Mesh([a, b, c, d], [[0, 1, 2, 3]])


def floor(y=0, half=4):
    return quad((-half, y, half), (half, y, half), (half, y, -half), (-half, y, -half))


def box(low, high):
    (x, y, z), (u, v, w) = low, high
    return Mesh([(x, y, z), (u, y, z), (u, v, z), (x, v, z), (x, y, w), (u, y, w), (u, v, w), (x, v, w)],
                [[3, 2, 1, 0], [4, 5, 6, 7], [0, 1, 5, 4], [2, 3, 7, 6], [1, 2, 6, 5], [3, 0, 4, 7]])


WHITE, RED, GREEN = Lambert((0.7, 0.7, 0.7)), Lambert((0.6, 0.12, 0.1)), Lambert((0.15, 0.5, 0.12))
GREY = Lambert((0.5, 0.5, 0.5))


def room():
    """A box that is open towards the camera; the light closes a hole in its ceiling, so that nobody sees its back."""
    h = 0.35
    ceiling = [quad((-1, 2, -1), (1, 2, -1), (1, 2, -h), (-1, 2, -h)), quad((-1, 2, h), (1, 2, h), (1, 2, 1), (-1, 2, 1)),
               quad((-1, 2, -h), (-h, 2, -h), (-h, 2, h), (-1, 2, h)), quad((h, 2, -h), (1, 2, -h), (1, 2, h), (h, 2, h))]
    walls = [floor(0, 1), quad((-1, 0, -1), (1, 0, -1), (1, 2, -1), (-1, 2, -1))]
    return [Object(s, WHITE) for s in ceiling + walls] + [
        Object(quad((-1, 0, 1), (-1, 0, -1), (-1, 2, -1), (-1, 2, 1)), RED),
        Object(quad((1, 0, -1), (1, 0, 1), (1, 2, 1), (1, 2, -1)), GREEN)], \
        Rectangle((0, 2, 0), (h, 0, 0), (0, 0, h), (12, 10, 8))


def scene_room():
    objects, light = room()
    return Scene("diffuse room with a light in its ceiling", Camera((0, 1, 4.2), (0, 1, 0), 36), objects + [
        Object(Sphere((-0.4, 0.4, -0.2), 0.4), GREY), Object(box((0.15, 0, -0.1), (0.7, 0.8, 0.4)), WHITE)], [light], 40, [
            Side("kinora", "PxrPathTracer", 256), Side("kinora", "PxrVCM", 96, {"mergePaths": 0}),
            Side("mitsuba", "path", 256), Side("mitsuba", "ptracer", 512),
            Side("luxcore", "PATHCPU", 128), Side("luxcore", "BIDIRCPU", 96, whole=True), Side("cycles", "path", 256)])


GOLD = ((0.18, 0.42, 1.37), (3.42, 2.35, 1.77))


def scene_metals():
    return Scene("metals of three roughnesses under a sky", Camera((0, 1.6, 5), (0, 0.6, 0), 40), [
        Object(floor(0, 5), GREY), Object(Sphere((-1.25, 0.6, 0), 0.6), Conductor(*GOLD, 0.0025)),
        Object(Sphere((0, 0.6, 0), 0.6), Conductor(*GOLD, 0.01)), Object(Sphere((1.25, 0.6, 0), 0.6), Conductor(*GOLD, 0.02))],
        [Dome(sun_over_sea)], 20, [
            Side("kinora", "PxrPathTracer", 256), Side("kinora", "PxrVCM", 128, {"mergePaths": 0}),
            Side("mitsuba", "path", 256), Side("cycles", "path", 256)])


def scene_rough():
    """The Fresnel factor is 1 in 500 of gold's, so that light which facets reflect twice is next to nothing, on all sides."""
    return Scene("very rough facets that hardly reflect twice", Camera((0, 0, 6), (0, 0, 0), 38), [
        Object(Sphere((-1, 0, 0), 1), Conductor(*GOLD, 0.25, 0.002)), Object(Sphere((1, 0, 0), 1), Conductor(*GOLD, 0.6, 0.002))],
        [Dome(sun_over_sea)], 20, [
            Side("kinora", "PxrPathTracer", 256), Side("mitsuba", "path", 256), Side("cycles", "path", 256)])


def scene_caustic():
    """The ball is out of sight, so that light paths can find all that is seen."""
    return Scene("what a ball of glass gathers on the floor", Camera((0, 1.5, 3), (-0.45, 0, -0.25), 22), [
        Object(floor(0, 4), GREY), Object(Sphere((0, 1.3, 0), 0.5), Glass(1.5))],
        [Rectangle((1, 3.5, 0.6), (0.2, 0, 0), (0, 0, 0.2), (90, 80, 70))], 40, [
            Side("kinora", "PxrPathTracer", 1024), Side("kinora", "PxrVCM", 192, {"mergePaths": 0}), Side("kinora", "PxrVCM", 128),
            Side("mitsuba", "path", 1024), Side("mitsuba", "ptracer", 512),
            Side("luxcore", "BIDIRCPU", 128, whole=True), Side("luxcore", "BIDIRVMCPU", 256, whole=True)])


def scene_glass():
    return Scene("a ball of clear glass before a wall, in the light of a window", Camera((0, 1.1, 4.5), (0, 0.8, 0), 36), [
        Object(floor(0, 4), GREY), Object(quad((-4, 0, -2), (4, 0, -2), (4, 4, -2), (-4, 4, -2)), GREEN),
        Object(Sphere((-0.5, 0.7, 0), 0.7), Glass(1.5)), Object(Sphere((0.8, 0.5, -0.5), 0.5), RED)],
        [Rectangle((1, 3.5, 1.5), (1, 0, 0), (0, 0, 1), (8, 7, 6))], 40, [
            Side("kinora", "PxrPathTracer", 512), Side("kinora", "PxrVCM", 128, {"mergePaths": 0}), Side("mitsuba", "path", 512),
            Side("luxcore", "PATHCPU", 256), Side("cycles", "path", 512)])


def scene_rough_glass():
    return Scene("rough glass, ball and plate, under a sky", Camera((0, 1.6, 5), (0, 0.7, 0), 38), [
        Object(floor(0, 5), GREY), Object(Sphere((-0.8, 0.7, 0), 0.7), Glass(1.5, 0.01)),
        Object(box((0.2, 0.01, -0.1), (1.5, 1.4, 0.15)), Glass(1.5, 0.02))],
        [Dome(sun_over_sea)], 40, [
            Side("kinora", "PxrPathTracer", 512), Side("kinora", "PxrVCM", 192, {"mergePaths": 0}),
            Side("mitsuba", "path", 512), Side("cycles", "path", 512)])


def scene_lens():
    row = [Object(Sphere((x, 0.35, z), 0.35), m) for x, z, m in
           ((-1.1, 1.6, RED), (-0.3, 0.4, WHITE), (0.6, -0.8, GREEN), (1.6, -2.2, RED))]
    return Scene("a wide lens and a spot light with a cone", Camera((0, 1.2, 4.5), (0, 0.4, 0), 36, 0.15, 4.2),
                 [Object(floor(0, 5), GREY)] + row, [
        Spot((2, 3.5, 2), (-2, -3.5, -2), 24, (30, 28, 22)), Rectangle((-2, 3, 1), (0.5, 0, 0), (0, 0, 0.5), (1, 2, 4))], 20, [
            Side("kinora", "PxrPathTracer", 256), Side("kinora", "PxrVCM", 96, {"mergePaths": 0}), Side("mitsuba", "path", 256)])


def scene_fog(g=0.6, more=()):
    return Scene("coloured fog that scatters forwards, over a floor", Camera((0, 1.2, 5), (0, 0.9, 0), 36), [
        Object(floor(0, 4), GREY), Object(Sphere((-0.5, 0.4, 0.2), 0.4), RED),
        Object(box((-1.2, 0.01, -1.2), (1.2, 1.8, 1.2)), Boundary(), Medium((0.5, 0.8, 1.2), (0.95, 0.8, 0.6), g))],
        [Rectangle((1.5, 3, -0.5), (0.4, 0, 0), (0, 0, 0.4), (30, 28, 26))], 60, [
            Side("kinora", "PxrPathTracer", 512), Side("kinora", "PxrVCM", 128, {"mergePaths": 0}),
            Side("mitsuba", "volpathmis", 512), Side("cycles", "path", 512), *more])


def scene_fog_even():
    s = scene_fog(0, (Side("luxcore", "PATHCPU", 256),))
    s.about = "the same fog, that scatters evenly"
    return s


def blobs():
    z, y, x = np.meshgrid(*[np.linspace(-1, 1, n) for n in (14, 12, 16)], indexing="ij")
    d = np.exp(-6 * ((x + 0.3) ** 2 + (y + 0.2) ** 2 + z ** 2)) + 0.7 * np.exp(-12 * ((x - 0.4) ** 2 + (y - 0.3) ** 2 + (z - 0.2) ** 2))
    return np.maximum(d + 0.15 * np.sin(7 * x) * np.sin(9 * y) * np.sin(8 * z) - 0.05, 0)


def scene_cloud():
    return Scene("an uneven cloud: a grid of densities", Camera((0, 1.4, 5), (0, 1, 0), 34), [
        Object(floor(0, 4), GREY),
        Object(box((-1, 0.2, -1), (1, 1.8, 1)), Boundary(), Medium((8, 8, 8), (0.98, 0.95, 0.9), 0.5, blobs()))],
        [Rectangle((1.5, 3.2, 0.8), (0.4, 0, 0), (0, 0, 0.4), (30, 28, 26)), Rectangle((-3, 2, 1), (0, 0, 0.5), (0, 0.5, 0), (6, 8, 12))], 200, [
            Side("kinora", "PxrPathTracer", 512), Side("kinora", "PxrVCM", 128, {"mergePaths": 0}), Side("mitsuba", "volpathmis", 512)])


def scene_milk():
    return Scene("balls of glass full of coloured media", Camera((0, 1.5, 5), (0, 0.6, 0), 36), [
        Object(floor(0, 4), GREY),
        Object(Sphere((-0.75, 0.7, 0), 0.7), Glass(1.33), Medium((4, 5, 6), (0.99, 0.97, 0.9), 0.4)),
        Object(Sphere((0.75, 0.7, 0), 0.7), Glass(1.5), Medium((1, 2, 3), (0.5, 0.9, 0.98), -0.3))],
        [Dome(sun_over_sea)], 200, [
            Side("kinora", "PxrPathTracer", 512), Side("kinora", "PxrVCM", 128, {"mergePaths": 0}),
            Side("mitsuba", "volpathmis", 512), Side("cycles", "path", 512)])


def h_function(albedo, count=400):
    """Chandrasekhar's H of isotropic scattering at Gauss points of (0, 1), by iteration of his equation."""
    x, w = np.polynomial.legendre.leggauss(count)
    mu, w = (x + 1) / 2, w / 2
    h, kernel, root = np.ones(count), 1 / (mu[:, None] + mu[None, :]), math.sqrt(1 - albedo)
    for _ in range(2000):
        new = 1 / (root + albedo / 2 * (kernel * mu[None, :] * h[None, :]) @ w)
        if np.max(np.abs(new - h)) < 1e-12:
            break
        h = new
    return mu, w, h


def half_space(extinction, albedo):
    """Albedo of a half space that light enters by a cosine's law, and the length over which light in its depth decays by a
    factor of e after Grosjean: what Kinora wants to be told of a medium."""
    mu, w, h = h_function(albedo)
    reflected = 1 - math.sqrt(1 - albedo) * h
    return 2 * float((reflected * mu) @ w), 1 / (extinction * math.sqrt(3 * (1 - albedo) / (2 - albedo)))


def scene_wax():
    extinction, albedo = (8, 12, 20), (0.98, 0.95, 0.85)
    color, reach = zip(*(half_space(e, a) for e, a in zip(extinction, albedo)))
    shapes = [Sphere((-0.7, 0.6, 0), 0.6), box((0.2, 0.01, -0.3), (1.1, 0.9, 0.3))]
    scene = Scene("subsurface walks beside a medium in a diffusing boundary", Camera((0, 1.4, 4.6), (0, 0.5, 0), 36),
                  [Object(floor(0, 4), GREY)], [Rectangle((1.5, 3, 1), (0.5, 0, 0), (0, 0, 0.5), (12, 11, 9)), Rectangle((-3, 2, 1), (0, 0, 1), (0, 1, 0), (3, 4, 6))],
                  600, [Side("kinora", "PxrPathTracer", 256), Side("kinora", "PxrVCM", 128, {"mergePaths": 0}), Side("mitsuba", "volpathmis", 256), Side("cycles", "path", 256), Side("cycles", "random_walk", 256)])
    scene.walks = [Object(s, Walk(color, reach), Medium(extinction, albedo)) for s in shapes]
    scene.objects += [Object(s, Diffuser(), Medium(extinction, albedo)) for s in shapes]
    return scene


SCENES = {name[6:]: make for name, make in list(globals().items()) if name.startswith("scene_")}
