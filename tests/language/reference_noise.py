#!/usr/bin/env python3
"""The language's hashes and noises in plain Python, in double, from their published description: the numbers that
tests/language/programs/noise expects come from here. `reference_noise.py perlin 1.5 2.25` prints a value and its three
components. It shares nothing with src/language."""
import math
import struct
import sys

M = 0xFFFFFFFF


def rot(x, k):
    return ((x << k) | (x >> (32 - k))) & M


def bits(x):
    return struct.unpack('<I', struct.pack('<f', x))[0]


def f32(x):
    return struct.unpack('<f', struct.pack('<f', x))[0]


def fin(a, b, c):
    v = [a, b, c]
    for x, y, k in ((2, 1, 14), (0, 2, 11), (1, 0, 25), (2, 1, 16), (0, 2, 4), (1, 0, 14), (2, 1, 24)):
        v[x] = ((v[x] ^ v[y]) - rot(v[y], k)) & M
    return v[2]


def H(*words):
    """Jenkins' lookup3 of 32-bit words."""
    w = [x & M for x in words]
    v = [(0xdeadbeef + 4 * len(w) + 13) & M] * 3
    while len(w) > 3:
        v = [(v[i] + w[i]) & M for i in range(3)]
        w = w[3:]
        for i, k in enumerate((4, 6, 8, 16, 19, 4)):
            x, y, z = i % 3, (i + 1) % 3, (i + 2) % 3
            v[x] = (v[x] - v[z]) & M
            v[x] ^= rot(v[z], k)
            v[z] = (v[z] + v[y]) & M
    for i, x in enumerate(w):
        v[i] = (v[i] + x) & M
    return fin(*v)


def signed(h):
    return h - (1 << 32) if h >> 31 else h


def to01(h):
    return f32(f32(float(h)) * 2.0**-32)


def fl(x):
    return math.floor(x)


def fade(t):
    return t * t * t * (t * (6 * t - 15) + 10)


def gradient(k, d):
    n = len(d)
    if n == 1:
        g = 1 + (k & 7)
        return (-g if k & 8 else g) * d[0]
    if n == 2:
        k &= 7
        u, v = (d[0], d[1]) if k < 4 else (d[1], d[0])
        return (-u if k & 1 else u) + (-2 * v if k & 2 else 2 * v)
    if n == 3:
        k &= 15
        u = d[0] if k < 8 else d[1]
        v = d[1] if k < 4 else d[0] if k in (12, 14) else d[2]
        return (-u if k & 1 else u) + (-v if k & 2 else v)
    k &= 31
    u = d[0] if k < 24 else d[1]
    v = d[1] if k < 16 else d[2]
    s = d[2] if k < 8 else d[3]
    return (-u if k & 1 else u) + (-v if k & 2 else v) + (-s if k & 4 else s)


PERLIN_SCALE = (0.2500, 0.6616, 0.9820, 0.8344)


def perlin(x, component=0, period=None):
    n = len(x)
    cell = [fl(a) for a in x]
    f = [a - c for a, c in zip(x, cell)]
    total = 0.0
    for corner in range(1 << n):
        o = [corner >> k & 1 for k in range(n)]
        at = [c + k for c, k in zip(cell, o)]
        if period:
            at = [c % max(1, fl(p)) for c, p in zip(at, period)]
        h = H(*at)
        if component is not None:
            h = h >> (8 * component) & 255 if component else h
        w = 1.0
        for k in range(n):
            w *= fade(f[k]) if o[k] else 1 - fade(f[k])
        total += w * gradient(h, [f[k] - o[k] for k in range(n)])
    return PERLIN_SCALE[n - 1] * total


def S(a, b, c):
    return fin(a & M, b & M, (c & M) ^ 0xdeadbeef)


G2 = ((-1, -1), (1, 0), (-1, 0), (1, 1), (-1, 1), (0, -1), (0, 1), (1, -1))
G3 = ((1, 0, 1), (0, 1, 1), (-1, 0, 1), (0, -1, 1), (1, 0, -1), (0, 1, -1), (-1, 0, -1), (0, -1, -1), (1, -1, 0), (1, 1, 0),
      (-1, 1, 0), (-1, -1, 0), (1, 0, 1), (-1, 0, 1), (0, 1, -1), (0, -1, -1))


def g4(h):
    k = h & 31
    signs = [-1 if k & b else 1 for b in (4, 2, 1)]
    signs.insert(k >> 3, 0)
    return signs


def simplex(x, seed=0):
    n = len(x)
    if n == 1:
        i = fl(x[0])
        total = 0.0
        for o in (0, 1):
            e = x[0] - i - o
            h = S(i + o, seed, 0)
            g = 1 + (h & 7)
            total += (1 - e * e)**4 * (-g if h & 8 else g) * e
        return 0.36 * total
    F = (0.366025403, 1.0 / 3, 0.309016994)[n - 2]
    G = (0.211324865, 1.0 / 6, 0.138196601)[n - 2]
    q = sum(x) * F
    cell = [fl(a + q) for a in x]
    t = sum(cell) * G
    d = [a - (c - t) for a, c in zip(x, cell)]
    later = n != 3  # of two equal ones, the later axis counts as larger in 2 and 4 dimensions
    order = sorted(range(n), key=lambda k: (-d[k], -k if later else k))
    total = 0.0
    for m in range(n + 1):
        o = [1 if k in order[:m] else 0 for k in range(n)]
        e = [d[k] - o[k] + m * G for k in range(n)]
        w = 0.5 - sum(a * a for a in e)
        if w < 0:
            continue
        at = [c + k for c, k in zip(cell, o)]
        if n == 2:
            g = G2[S(at[0], at[1], seed) & 7]
        elif n == 3:
            g = G3[S(at[0], at[1], S(at[2], seed, 0)) & 15]
        else:
            g = g4(S(at[0], at[1], S(at[2], at[3], seed)))
        total += w**4 * sum(a * b for a, b in zip(g, e))
    return (64, 68, 54)[n - 2] * total


def wrapped(x, period):
    if not period:
        return x
    return [f32(a - max(1, fl(p)) * math.floor(a / max(1, fl(p)))) for a, p in zip(x, period)]


def cell(x, component=None, period=None):
    words = [fl(a) for a in wrapped(x, period)]
    return to01(H(*words, *([] if component is None else [component])))


def hashnoise(x, component=None, period=None):
    words = [bits(a) for a in wrapped(x, period)]
    return to01(H(*words, *([] if component is None else [component])))


def gabor(x, seed=0, period=None, anisotropic=0, direction=(1, 0, 0), bandwidth=1.0, impulses=16.0):
    """Without the filter."""
    bw = min(max(bandwidth, 0.01), 100)
    impulses = min(max(impulses, 1), 32)
    x = (list(x) + [0, 0, 0])[:3]
    period = (list(period) + [1, 1, 1])[:3] if period else None
    a = 2 * ((2**bw - 1) / (2**bw + 1)) * 2.128934
    R = math.sqrt(-math.log(0.02) / math.pi) / a
    lam = impulses / (1.33333 * math.pi * R**3)
    g = [c / R for c in x]
    base = [fl(c) for c in g]
    f = [c - b for c, b in zip(g, base)]
    limit = math.exp(-lam * R**3)
    total = 0.0
    for k in (-1, 0, 1):
        for j in (-1, 0, 1):
            for i in (-1, 0, 1):
                o = (i, j, k)
                q = [b + c for b, c in zip(base, o)]
                e = [b - c for b, c in zip(f, o)]
                if period:
                    q = [c % max(1, fl(p)) for c, p in zip(q, period)]
                s = H(q[0], q[1], q[2], seed) or 1

                def draw():
                    nonlocal s
                    s = s * 3039177861 & M
                    return f32(float(s)) / 4294967296.0

                count, t = 0, draw()
                while t > limit:
                    count += 1
                    t *= draw()
                for _ in range(count):
                    pz, py, px = draw(), draw(), draw()
                    d = [R * (e[0] - px), R * (e[1] - py), R * (e[2] - pz)]
                    if anisotropic == 0:
                        th = 2 * math.pi * draw()
                        c = 2 * draw() - 1
                        r = math.sqrt(max(0, 1 - c * c))
                        omega = (math.cos(th) * r, math.sin(th) * r, c)
                    elif anisotropic == 1:
                        omega = direction
                    else:
                        th = 2 * math.pi * draw()
                        l = math.sqrt(sum(c * c for c in direction))
                        omega = (l * math.cos(th), l * math.sin(th), 0)
                    phi = 2 * math.pi * draw()
                    dd = sum(c * c for c in d)
                    if dd < R * R:
                        total += math.exp(-math.pi * a * a * dd) * math.cos(2 * math.pi * sum(p * c for p, c in zip(omega, d)) + phi)
    V = 1 / (4 * math.sqrt(2) * a**3)
    return total / math.sqrt(lam) * 0.5 / (3 * math.sqrt(V))


def value(name, x, period=None, **options):
    """The float value and the three components of a triple one."""
    signed_of = {'perlin': 'perlin', 'snoise': 'perlin', 'psnoise': 'perlin', 'uperlin': 'perlin', 'noise': 'perlin', 'pnoise': 'perlin'}
    x = [f32(a) for a in x]
    if name in signed_of:
        v = [perlin(x, c, period) for c in (None, 0, 1, 2)]
        if name in ('uperlin', 'noise', 'pnoise'):
            v = [0.5 * (a + 1) for a in v]
    elif name in ('simplex', 'usimplex'):
        v = [simplex(x, c) for c in (0, 0, 1, 2)]
        if name == 'usimplex':
            v = [0.5 * (a + 1) for a in v]
    elif name in ('cell', 'cellnoise'):
        v = [cell(x, c, period) for c in (None, 0, 1, 2)]
    elif name in ('hash', 'hashnoise'):
        v = [hashnoise(x, c, period) for c in (None, 0, 1, 2)]
    elif name == 'gabor':
        v = [gabor(x, c, period, **options) for c in (0, 0, 1, 2)]
    elif name in ('null', 'unull'):
        v = [0.5 if name == 'unull' else 0.0] * 4
    else:
        raise ValueError(name)
    return v[0], v[1:]


if __name__ == '__main__':
    print(*value(sys.argv[1], [float(a) for a in sys.argv[2:]]))
