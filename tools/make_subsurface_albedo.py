#!/usr/bin/env python3
"""Fits how much of the light that enters a half space comes out again, by what one scattering keeps: the numbers of
include/kinora/subsurface_albedo.h. Needs numpy; minutes.

Light enters by a cosine's law and everything that comes out counts, as the walks below surfaces do (subsurface.h).
The boundary may be that of a dielectric: light then goes in refracted, weighed by what Fresnel's formulas let through,
and what arrives from inside is reflected as they say.
With exponential flights and Henyey-Greenstein scattering the albedo is found by adding and doubling (van de Hulst
1963) on Gauss points, from a layer of 1e-7 mean free paths on. With the power laws of Subsurface::tail it is counted:
the share of walks in a medium of albedo 1 that come out after n scatterings gives it for all albedos.

Van de Hulst's formula for the exponential, A = (1 - 0.139 s)(1 - s) / (1 + 1.17 s), s = sqrt((1 - a) / (1 - a g)), is
solved for s; what is fitted is the difference, by polynomials in s and g, and in s and tail. Prints the coefficients
and the largest errors of s. For a boundary the formula is asked with A / (t + (1 - t) A), t being the mean transmittance
from inside: what would come out of a medium whose light is diffuse everywhere (Saunderson 1942). What that leaves is a
third polynomial, in s, g and the sine of the critical angle's complement; its errors are those of the albedo.
"""
import numpy as np
from numpy.polynomial import legendre


def phase(mu, g):
    same, other = np.zeros((len(mu), len(mu))), np.zeros((len(mu), len(mu)))
    for l in range(400):
        c = (2 * l + 1) * g**l
        if abs(c) < 1e-14:
            break
        p = legendre.legval(mu, [0] * l + [1])
        same += c * np.outer(p, p)
        other += c * np.outer(p, p) * (-1) ** l
    return same, other


def points(cuts, n):
    """Gauss points of each of the intervals that the cuts make of [0, 1]."""
    x, w = legendre.leggauss(n)
    ends = [0.0, *sorted(cuts), 1.0]
    mu = [a + (b - a) * (x + 1) / 2 for a, b in zip(ends, ends[1:])]
    return np.concatenate(mu), np.concatenate([w * (b - a) / 2 for a, b in zip(ends, ends[1:])])


def reflectance_inside(mu, ior):
    sin2 = ior * ior * (1 - mu * mu)
    out = np.sqrt(np.maximum(0, 1 - sin2))
    a, b = (ior * mu - out) / (ior * mu + out), (mu - ior * out) / (mu + ior * out)
    return np.where(sin2 >= 1, 1, (a * a + b * b) / 2)


def half_space(alpha, g, n=48, iors=()):
    """The albedo without a boundary and, with `iors`, a list of it and of those with boundaries of these indices."""
    mu, w = points([np.sqrt(1 - 1 / i**2) for i in iors], n)
    n = len(mu)
    same, other = phase(mu, g)
    for _ in range(50):  # nothing is lost on the points
        f = 1 / np.sqrt(0.5 * ((same + other) @ w))
        same *= np.outer(f, f)
        other *= np.outer(f, f)
    tau, weight = 1e-7, 2 * mu * w
    r = alpha * tau * other / (4 * np.outer(mu, mu)) * weight
    t = alpha * tau * same / (4 * np.outer(mu, mu)) * weight + np.diag(1 - tau / mu)
    one = np.eye(n)
    for _ in range(60):
        m = np.linalg.inv(one - r @ r)
        r, t = r + t @ r @ m @ t, t @ m @ t
        if t.max() < 1e-14:
            break
    plain = float(weight @ (r @ np.ones(n)))
    if not iors:
        return plain
    found = [plain]
    for ior in iors:
        back = reflectance_inside(mu, ior)
        entry = weight * (1 - back)  # of a cosine's law outside, as it is refracted
        # what leaves of light that starts in a direction: at once, or after it was reflected
        leaves = np.linalg.solve(one - r * back, r @ (1 - back))
        found.append(float(entry @ leaves / entry.sum()))
    return found


def orders(tail, walks=600000, most=4000, seed=1):
    """Shares of walks that come out after 1, 2, ... scatterings, nothing being absorbed."""
    random = np.random.default_rng(seed)
    out = np.zeros(most + 1)
    mu, z = np.sqrt(random.random(walks)), np.zeros(walks)
    for n in range(most + 1):
        e = random.exponential(size=len(z))
        power = tail if n == 0 else tail / (1 + tail)
        z = z + mu * (e if tail == 0 else np.expm1(e * power) / tail)
        inside = z > 0
        out[n] = np.count_nonzero(~inside)
        z = z[inside]
        mu = 2 * random.random(len(z)) - 1
        if not len(z):
            break
    return out / walks, len(z) / walks


def invert(albedo):
    b = 1.139 + 1.17 * albedo
    return (b - np.sqrt(b * b - 4 * 0.139 * (1 - albedo))) / 0.278


def fit(rows, powers, others):
    """s - s0 = s0 (1 - s0) sum c_ij s0^i other^j, by least squares weighed for the albedo's error."""
    a, b = [], []
    for s, s0, other in rows:
        f = s0 * (1 - s0)
        a.append([f * s0**i * other**j for i in range(powers) for j in others])
        b.append(s - s0)
    c = np.linalg.lstsq(np.array(a), np.array(b), rcond=None)[0]
    return c.reshape(powers, len(others)), np.max(np.abs(np.array(a) @ c - np.array(b)))


def similarity(albedo, g, c):
    s = invert(albedo)
    return s + s * (1 - s) * sum(c[i, j] * s**i * g**j for i in range(len(c)) for j in range(len(c[0])))


def boundary(c, shape=(6, 6, 3)):
    """The third polynomial, over the first one's c, and a line on its errors."""
    sines = (0.15, 0.3, 0.45, 0.6, 0.7, 0.8, 0.87)
    iors = [1 / np.sqrt(1 - y * y) for y in sines]
    means = []
    for ior in iors:
        mu, w = points([np.sqrt(1 - 1 / ior**2)], 40)
        means.append(float(np.sum(2 * mu * w * (1 - reflectance_inside(mu, ior)))))
    rows, terms, misses, weights = [], [], [], []
    for g in 0.95 * np.cos(np.pi * (np.arange(9) + 0.5) / 9):
        s = 0.5 - 0.49 * np.cos(np.pi * (np.arange(14) + 0.5) / 14)
        step = np.minimum(0.005, (1 - s) / 4)
        albedos, others = (np.array([half_space((1 - x * x) / (1 - g * x * x), g, 12, iors) for x in at])[:, 1:]
                           for at in (s, s + step))
        for k, (y, ior, t) in enumerate(zip(sines, iors, means)):
            slope = np.log(albedos[:, k] / others[:, k]) / step  # of the albedo's logarithm
            for x, a, d in zip(s, albedos[:, k], slope):
                s0 = similarity(a / (t + (1 - t) * a), g, c)
                # dark surfaces, extreme means of the cosine and high indices need not be as good
                weight = d * min(1, a / 0.02 * d) * (0.5 if abs(g) > 0.8 else 1) * (0.6 if ior > 1.7 else 1)
                f = weight * s0 * (1 - s0)
                terms.append(
                    [f * s0**i * g**j * y**m for i in range(shape[0]) for j in range(shape[1]) for m in range(1, shape[2] + 1)])
                misses.append(weight * (x - s0))
                weights.append(weight)
                rows.append((g, ior, a, d))
    terms, misses = np.array(terms), np.array(misses)
    found = np.linalg.lstsq(terms, misses, rcond=None)[0]
    off = (terms @ found - misses) / np.array(weights)
    errors = [(abs(o) * d, g, ior, a) for o, (g, ior, a, d) in zip(off, rows) if a > 0.02]
    inner = max(e for e in errors if abs(e[1]) < 0.8 and e[2] < 1.7)
    middle = max(e for e in errors if abs(e[1]) < 0.8)
    print("// largest relative error of albedos above 0.02, with the mean cosine, index and albedo where it is: "
          + "; ".join(f"{e[0]:.2g} ({e[1]:.2f}, {e[2]:.2f}, {e[3]:.2f})" for e in (inner, middle, max(errors))))
    return found.reshape(shape)


def show(name, c, error):
    print(f"// largest error of s: {error:.2g}")
    print(f"inline constexpr double {name}[{c.shape[0]}][{c.shape[1]}] = {{")
    for row in c:
        print("    {" + ", ".join(f"{x:.6g}" for x in row) + "},")
    print("};")


def main():
    rows = []
    for g in np.linspace(-0.95, 0.95, 20):
        for s in np.linspace(0.03, 0.985, 24):
            alpha = (1 - s * s) / (1 - g * s * s)
            rows.append((s, invert(half_space(alpha, g)), g))
    anisotropy, error = fit(rows, 6, range(6))
    show("kAnisotropyFit", anisotropy, error)
    bound = boundary(anisotropy)
    print(f"inline constexpr double kBoundaryFit[{bound.shape[2]}][{bound.shape[0]}][{bound.shape[1]}] = {{")
    for m in range(bound.shape[2]):
        print("    {")
        for row in bound[:, :, m]:
            print("        {" + ", ".join(f"{x:.9g}" for x in row) + "},")
        print("    },")
    print("};")
    rows = []
    for tail in (0.05, 0.15, 0.25, 0.35, 0.45, 0.55, 0.65, 0.75):
        p, left = orders(tail)
        plain, _ = orders(0)
        n = np.arange(len(p))
        for s in np.linspace(0.06, 0.98, 20):
            alpha = 1 - s * s
            # the walks of exponential flights are counted as well: what chance does to both cancels
            exact = half_space(alpha, 0)
            a = float(np.sum(p * alpha**n)) + exact - float(np.sum(plain * alpha**n))
            rows.append((s, invert(a), tail))
    show("kTailFit", *fit(rows, 4, range(1, 4)))


if __name__ == "__main__":
    main()
