#!/usr/bin/env python3
"""Fits how much of the light that enters a half space comes out again, by what one scattering keeps: the numbers of
include/kinora/subsurface_albedo.h. Needs numpy; minutes.

Light enters by a cosine's law and everything that comes out counts, as the walks below surfaces do (subsurface.h).
With exponential flights and Henyey-Greenstein scattering the albedo is found by adding and doubling (van de Hulst
1963) on Gauss points, from a layer of 1e-7 mean free paths on. With the power laws of Subsurface::tail it is counted:
the share of walks in a medium of albedo 1 that come out after n scatterings gives it for all albedos.

Van de Hulst's formula for the exponential, A = (1 - 0.139 s)(1 - s) / (1 + 1.17 s), s = sqrt((1 - a) / (1 - a g)), is
solved for s; what is fitted is the difference, by polynomials in s and g, and in s and tail. Prints the coefficients
and the largest errors of the albedo that comes out.
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


def half_space(alpha, g, n=48):
    x, w = legendre.leggauss(n)
    mu, w = (x + 1) / 2, w / 2
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
    return float(weight @ (r @ np.ones(n)))


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
    show("kAnisotropyFit", *fit(rows, 6, range(6)))
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
