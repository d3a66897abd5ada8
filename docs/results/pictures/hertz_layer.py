#!/usr/bin/env python3
"""What penetration and averaging take from the pressure of a ball on a block: the table in verification.md, section 2.

hertz_layer.py [CELLS ...]

Rings of constant pressure on a half space, with a layer of compliance 1/eps between the bodies: what a penalty is. Lengths are half widths
of the contact without the layer at the same force, pressures are over E*; R is 1.
"""

import math
import sys

RINGS, OUTER = 150, 1.15
# E over E* of two bodies of it, nu = 0.3.
YOUNG = 2.0 * (1.0 - 0.3**2)
FORCE, PEAK = 4.0 / 3.0, 2.0 / math.pi
INNER, FINER = 0.85, 0.8


def elliptic(m):
    """K and E of the parameter m, by the arithmetic-geometric mean."""
    a, g, c, power = 1.0, math.sqrt(1.0 - m), math.sqrt(m), 0.5
    s = power * m
    while c > 1e-16:
        a, g, c, power = (a + g) / 2, math.sqrt(a * g), (a - g) / 2, 2 * power
        s += power * c * c
    k = math.pi / (2 * a)
    return k, k * (1 - s)


def disc(r, b):
    """Displacement at r by a pressure of 1 within b."""
    if r < b:
        return 4 / math.pi * b * elliptic((r / b) ** 2)[1]
    k, e = elliptic((b / r) ** 2)
    return 4 / math.pi * r * (e - (1 - (b / r) ** 2) * k)


def solved(matrix, right):
    rows = [row + [x] for row, x in zip(matrix, right)]
    count = len(rows)
    for i in range(count):
        for k in range(i + 1, count):
            factor = rows[k][i] / rows[i][i]
            rows[k] = rows[k][: i + 1] + [x - factor * y for x, y in zip(rows[k][i + 1 :], rows[i][i + 1 :])]
    x = [0.0] * count
    for i in reversed(range(count)):
        x[i] = (rows[i][count] - sum(rows[i][j] * x[j] for j in range(i + 1, count))) / rows[i][i]
    return x


ENDS = [OUTER * k / RINGS for k in range(RINGS + 1)]
MIDDLES = [(a + b) / 2 for a, b in zip(ENDS, ENDS[1:])]
AREAS = [math.pi * (b * b - a * a) for a, b in zip(ENDS, ENDS[1:])]
DISCS = [[disc(r, b) if b > 0.0 else 0.0 for b in ENDS] for r in MIDDLES]
RING = [[b - a for a, b in zip(row, row[1:])] for row in DISCS]


def pressed(approach, eps):
    """Pressures of the rings."""
    active = [i for i, r in enumerate(MIDDLES) if r * r / 2 < approach]
    while True:
        matrix = [[RING[i][k] + (1 / eps if i == k else 0.0) for k in active] for i in active]
        found = solved(matrix, [approach - MIDDLES[i] ** 2 / 2 for i in active])
        kept = [i for i, p in zip(active, found) if p > 0.0]
        if len(kept) == len(active):
            pressures = [0.0] * RINGS
            for i, p in zip(active, found):
                pressures[i] = p
            return pressures
        active = kept


def contact(eps):
    """Pressures at the force that without a layer has the half width 1."""
    force = lambda p: sum(x * a for x, a in zip(p, AREAS))
    before, now = 1.0, 1.1
    missing = force(pressed(before, eps)) - FORCE
    for _ in range(12):
        pressures = pressed(now, eps)
        error = force(pressures) - FORCE
        if abs(error) < 1e-7:
            break
        before, now, missing = now, now - error * (now - before) / (error - missing), error
    return pressures


def at(pressures, r):
    t = r / OUTER * RINGS - 0.5
    k = max(int(t), 0)
    return 0.0 if k >= RINGS - 1 else pressures[k] + max(t - k, 0.0) * (pressures[k + 1] - pressures[k])


def averaged(pressures, x, y, h):
    """Over the bilinear faces around a node, by its shape function."""
    weights = ((-1, 1 / 6), (0, 4 / 6), (1, 1 / 6))
    return sum(v * w * at(pressures, math.hypot(x + i * h, y + j * h)) for i, v in weights for j, w in weights)


def errors(value, h):
    """At the middle, and rms of the nodes of a grid."""
    count = int(INNER / h) + 1
    nodes = [(i * h, j * h) for i in range(count) for j in range(count) if math.hypot(i * h, j * h) <= INNER]
    found = [value(x, y) / PEAK - math.sqrt(1 - x * x - y * y) for x, y in nodes]
    return found[0], math.sqrt(sum(e * e for e in found) / len(found))


def main():
    print("| cells within a, body | slave | penetration: peak | rms | averaging: peak | rms | both: peak | rms |")
    print("| ---: | --- | ---: | ---: | ---: | ---: | ---: | ---: |")
    exact = contact(1e9)
    for cells in [int(x) for x in sys.argv[1:]] or [4, 6, 9, 13]:
        soft = contact(5 * YOUNG * cells)
        for slave, h in (("block", FINER / cells), ("ball", 1 / cells)):
            columns = [
                errors(lambda x, y: at(soft, math.hypot(x, y)), h),
                errors(lambda x, y: averaged(exact, x, y, h), h),
                errors(lambda x, y: averaged(soft, x, y, h), h),
            ]
            print(f"| {cells} | {slave} | " + " | ".join(f"{100 * peak:+.2f} % | {100 * rms:.2f} %" for peak, rms in columns) + " |")


if __name__ == "__main__":
    main()
