#!/usr/bin/env python3
"""Draws sketch-anchor.svg, sketch-pieces.svg, sketch-domains.svg and sketch-forces.svg beside it: what pages of the book explain.

Usage: docs/results/pictures/sketches.py [PROGRAM]. It needs the program `diffuse-contact`; `cargo build --release` makes it.

Smooth surfaces, normals, places and forces are those of `diffuse-contact evaluate`, for masters with domains of influence as interfaces
have them. Faces are cut into pieces here, as `runtime/src/faces/cut.rs` does it for faces in a plane.
"""

import json
import math
import pathlib
import subprocess
import sys
import tempfile

from drawing import COLOURS, FAINT, GREY, INK, arrow, dashed, dot, path, text, write

SMOOTH, FACETS, FACES = COLOURS["smooth"], COLOURS["facets"], COLOURS["faces"]


def below(index):
    """An index of a formula."""
    return f'<tspan dy="4" font-size="12">{index}</tspan><tspan dy="-4"> </tspan>'


def minus(a, b):
    return tuple(x - y for x, y in zip(a, b))


def times(factor, a):
    return tuple(factor * x for x in a)


def plus(a, b):
    return tuple(x + y for x, y in zip(a, b))


def inner(a, b):
    return sum(x * y for x, y in zip(a, b))


def evaluate(program, elements):
    """Answers of the program."""
    with tempfile.TemporaryDirectory() as folder:
        source = pathlib.Path(folder, "in.json")
        source.write_text(json.dumps({"elements": elements}), encoding="utf-8")
        found = subprocess.run([program, "evaluate", source], check=True, capture_output=True)
    return json.loads(found.stdout)["elements"]


# A cylinder along y.
RADIUS, CELL, WIDTH, COLUMNS, ROWS = 100.0, 20.0, 34.0, 10, 8
MIDDLE = WIDTH * (ROWS - 1) / 2
# Domains are longer than the mean edges by this factor.
FACTOR = 2.3


def around(degrees, radius=RADIUS, y=MIDDLE):
    """A point of the cylinder; 0 degrees is on top."""
    angle = math.radians(degrees)
    return radius * math.sin(angle), y, radius * math.cos(angle)


def metric(first, across):
    """C of a node of a regular mesh: of its edges, in the directions `first` and y, and twice as thick as wide along `across`."""
    edge = 2 * RADIUS * math.sin(math.radians(CELL / 2))
    squares = [0.75 * edge**2, 0.75 * WIDTH**2, 4 * 0.75 * min(edge, WIDTH) ** 2]
    return [
        [FACTOR**2 * sum(c * d[i] * d[k] for c, d in zip(squares, (first, (0, 1, 0), across))) for k in range(3)]
        for i in range(3)
    ]


class Cylinder:
    """Its nodes where they began and where a motion has brought them."""

    angles = [CELL * (k - (COLUMNS - 1) / 2) for k in range(COLUMNS)]

    def __init__(self, program, motion=lambda x: x):
        self.program, self.motion = program, motion
        self.first = [around(angle, RADIUS, WIDTH * row) for row in range(ROWS) for angle in self.angles]
        self.masters = [motion(x) for x in self.first]
        self.metrics = [
            metric(around(angle + 90, 1.0, 0.0), around(angle, 1.0, 0.0)) for _ in range(ROWS) for angle in self.angles
        ]

    def evaluate(self, slaves):
        fixed = {"masters": self.masters, "first_positions": self.first, "metrics": self.metrics}
        return evaluate(self.program, [{"slave": x, "outward": minus(x, (0, x[1], 0)), **fixed} for x in slaves])

    def curve(self, start, end):
        """The smooth surface across the cylinder."""
        slaves = [self.motion(around(start + (end - start) * k / 120, RADIUS + 2)) for k in range(121)]
        return [found["foot"] for found in self.evaluate(slaves)]

    def section(self):
        """The nodes of one row."""
        return [self.motion(around(angle)) for angle in self.angles]


def tilted(x):
    """Turned, and flattened by an affine map, which carries each point of the surface with its nodes."""
    angle = math.radians(-17)
    return 1.05 * (x[0] * math.cos(angle) + x[2] * math.sin(angle)), x[1], 0.95 * (
        x[2] * math.cos(angle) - x[0] * math.sin(angle)
    )


def surface(at, cylinder, start, end):
    """The smooth surface and its nodes."""
    seen = [x for x, angle in zip(cylinder.section(), cylinder.angles) if start < angle < end]
    return [path([at(x) for x in cylinder.curve(start, end)], SMOOTH, 3), *(dot(at(x), 4) for x in seen)]


def anchor(program):
    """Anchor and slip between two times."""
    scale = 3.9
    before, after = Cylinder(program), Cylinder(program, tilted)
    left = lambda x: (214 + scale * x[0], 130 + scale * (RADIUS - x[2]))
    right = lambda x: (716 + scale * x[0], 130 + scale * (RADIUS - x[2]))
    # At the accepted step the slave touches: its foot becomes its anchor.
    touching = around(3, RADIUS - 1.0)
    (foot,) = (found["foot"] for found in before.evaluate([touching]))
    drawn = [
        text(16, 26, "When a step is accepted: the foot becomes the anchor"),
        *surface(left, before, -30, 30),
        dot(left(foot), 6, "#fff", INK),
        text(left(foot)[0], left(foot)[1] + 32, "foot = anchor xᵃ", anchor="middle"),
        cross(left(plus(foot, (0, 0, 2.0)))),
        text(left(foot)[0], left(foot)[1] - 24, "slave xᶜ", anchor="middle"),
    ]
    # Later the master has carried the anchor along, and the slave is elsewhere.
    slave = around(13, RADIUS - 11.0)
    (found,) = after.evaluate([slave])
    place, normal = tilted(foot), found["normal"]
    way = minus(slave, place)
    slip = minus(way, times(inner(way, normal), normal))
    corner = plus(place, slip)
    tip = plus(found["foot"], times(16, normal))
    drawn += [
        text(494, 26, "Later: the master has carried the anchor along"),
        dashed([right(x) for x in before.curve(-33, 34)], GREY, 1.5, "5 5"),
        *surface(right, after, -16, 46),
        dashed([right(found["foot"]), right(corner)], INK, 1.2),
        arrow(right(place), right(corner)),
        arrow(right(found["foot"]), right(tip), SMOOTH, 2),
        dot(right(found["foot"]), 4, SMOOTH),
        arrow(right(slave), right(plus(slave, times(-0.5, slip))), "#666", 6, 18),
        dot(right(place), 6, "#fff", INK),
        cross(right(slave)),
    ]
    (a, b), (c, d), (e, f) = right(place), right(slave), right(tip)
    g, h = right(plus(place, times(0.5, slip)))
    drawn += [
        text(a - 12, b - 14, "anchor xᵃ", anchor="end"),
        text(c + 14, d + 6, "slave xᶜ"),
        text(e + 10, f + 8, "ν, at the foot", SMOOTH),
        text(g - 10, h + 26, "slip s", anchor="middle"),
        text(c - 4, d + 52, "traction on the slave, against s", "#666", "middle"),
        text(16, 286, "— smooth surface", SMOOTH),
        text(170, 286, "● nodes of the master"),
        text(494, 286, "– – where the surface was; s is xᶜ − xᵃ without its part along ν", "#666"),
    ]
    write("sketch-anchor.svg", (960, 302), drawn)


def cross(place, size=7):
    """A slave."""
    a, b = place
    return path([(a - size, b - size), (a + size, b + size)], INK, 3) + path([(a - size, b + size), (a + size, b - size)], INK, 3)


def forces(program):
    """The force on a slave, and the reactions on its masters."""
    cylinder, scale = Cylinder(program), 4.0
    slave = around(1.5, RADIUS - 7.0, MIDDLE + 0.3 * WIDTH)
    (found,) = cylinder.evaluate([slave])
    rows = [found["force"][3 * k : 3 * k + 3] for k in range(len(cylinder.masters) + 1)]
    own, others = rows[0], rows[1:]
    total = math.sqrt(inner(own, own))
    long = 150 / total
    at = lambda x: (240 + scale * x[0], 204 + scale * (RADIUS - x[2]))
    drawn = [text(16, 26, "Across the cylinder: reactions of each line of masters, summed")]
    drawn += surface(at, cylinder, -35, 35)
    pushed = lambda start, force: arrow(start, (start[0] + long * force[0], start[1] - long * force[2]), INK, 3)
    for column, x in enumerate(cylinder.section()):
        force = [sum(others[row * COLUMNS + column][axis] for row in range(ROWS)) for axis in range(3)]
        if math.sqrt(inner(force, force)) > 0.005 * total:
            drawn.append(pushed(at(x), force))
    drawn.append(pushed(at(slave), own))
    drawn.append(cross(at(slave)))
    tip = (at(slave)[0] + long * own[0], at(slave)[1] - long * own[2])
    drawn += [
        text(tip[0] + 12, tip[1] + 14, "force on the slave, f ∂g/∂xᶜ"),
        text(at(slave)[0], at(slave)[1] + 26, "slave, g &lt; 0", anchor="middle"),
        text(240, 350, "reactions on the masters, f ∂g/∂xₖ", anchor="middle"),
    ]
    # From above, each master by itself.
    flat = lambda x: (740 + 1.6 * RADIUS * math.atan2(x[0], x[2]), 188 - 1.6 * (x[1] - MIDDLE))
    size = lambda force: 40 * math.sqrt(abs(force) / total)
    drawn.append(text(560, 26, "From above: each master's part along ν"))
    for row in range(1, ROWS - 1):
        drawn.append(path([flat(around(angle, RADIUS, WIDTH * row)) for angle in cylinder.angles[2:-2]], FAINT, 1))
    for angle in cylinder.angles[2:-2]:
        drawn.append(path([flat(around(angle, RADIUS, WIDTH * row)) for row in range(1, ROWS - 1)], FAINT, 1))
    count = 0
    for x, force in zip(cylinder.first, others):
        along = inner(force, found["normal"])
        if any(force):
            count += 1
            drawn.append(dot(flat(x), max(size(along), 2.0), SMOOTH if along < 0 else "#fff", SMOOTH))
    drawn.append(cross(flat(slave)))
    drawn += [
        dot((574, 346), 7, SMOOTH, SMOOTH),
        text(588, 351, "pushed in"),
        dot((680, 346), 7, "#fff", SMOOTH),
        text(694, 351, "pulled out"),
        text(788, 351, f"area: size, {count} masters"),
    ]
    balance = max(abs(sum(row[axis] for row in rows)) for axis in range(3))
    assert balance < 1e-9 * total, balance
    write("sketch-forces.svg", (960, 366), drawn)


def domains(program):
    """A slave, its place in the first configuration, and the masters within reach."""
    widths = [0.8, 0.8, 0.9, 1.0, 1.2, 1.4, 1.7, 2.0]
    xs = [sum(widths[:k]) for k in range(len(widths) + 1)]
    rows = 8
    shake = lambda i, k, more: 0.09 * math.sin(5 * i + 7.3 * k + more)
    first = [[(x + shake(i, k, 0), k + shake(i, k, 2), 0.0) for i, x in enumerate(xs)] for k in range(rows)]

    def now(x):
        angle, radius = 0.13 * (x[0] - 4.5), 7.5 + 0.86 * (x[1] - 3.5)
        return 4.5 + radius * math.sin(angle) * 1.08, radius * math.cos(angle) - 4.0, 0.0

    flat = [x for row in first for x in row]

    def of(k, i):
        """C of a node."""
        near = [(a, b) for a in (k - 1, k, k + 1) for b in (i - 1, i, i + 1) if 0 <= a < rows and 0 <= b < len(xs)]
        edges = [minus(first[a][b], first[k][i]) for a, b in near if (a, b) != (k, i)]
        c = [[FACTOR**2 * sum(e[p] * e[q] for e in edges) / len(edges) for q in range(3)] for p in range(3)]
        half = (c[0][0] + c[1][1]) / 2
        c[2][2] = 4 * (half - math.sqrt((c[0][0] - c[1][1]) ** 2 / 4 + c[0][1] ** 2))
        return c

    metrics = [of(k, i) for k in range(rows) for i in range(len(xs))]
    slave = plus(now((4.35, 3.4, 0.0)), (0, 0, 0.3))
    element = {"slave": slave, "masters": [now(x) for x in flat], "first_positions": flat, "metrics": metrics,
               "outward": [0, 0, 1]}
    (found,) = evaluate(program, [element])
    place = found["place"]

    def ratio(x, c):
        a, b = x[0] - place[0], x[1] - place[1]
        return math.sqrt((c[1][1] * a * a - 2 * c[0][1] * a * b + c[0][0] * b * b) / (c[0][0] * c[1][1] - c[0][1] ** 2))

    def ellipse(x, c):
        """The border of a domain: x + L u with L Lᵀ = C and u around the unit circle."""
        l = math.sqrt(c[0][0])
        m = c[0][1] / l
        n = math.sqrt(c[1][1] - m * m)
        turn = [math.tau * k / 72 for k in range(73)]
        return [(x[0] + l * math.cos(t), x[1] + m * math.cos(t) + n * math.sin(t)) for t in turn]

    left = lambda x: (14 + 35 * (x[0] + 1.7), 310 - 35 * (x[1] + 0.5))
    right = lambda x: (518 + 42 * x[0], 334 - 40 * (x[1] + 0.2))
    drawn = [
        text(16, 26, "Now: the slave over the deformed master"),
        text(508, 26, "First configuration: its place Ξ, and domains"),
    ]
    for at, where in ((left, now), (right, lambda x: x)):
        for line in [*first, *zip(*first)]:
            drawn.append(path([at(where(x)) for x in line], FAINT, 1.5))
    marked = {(4, 6): SMOOTH, (3, 3): GREY}
    for (k, i), colour in marked.items():
        number = k * len(xs) + i
        border = [right(x) for x in ellipse(first[k][i], metrics[number])]
        drawn.append(path(border, colour, 2, colour, ' fill-opacity="0.1"'))
    count = 0
    for x, c in zip(flat, metrics):
        r = ratio(x, c)
        count += r < 1
        size = 3 + 6 * math.sqrt((1 - r) ** 2 * (1 + 2 * r)) if r < 1 else 3
        for at, at_now in ((left, now(x)), (right, x)):
            drawn.append(dot(at(at_now), size if r < 1 else 3, SMOOTH if r < 1 else "#fff", SMOOTH if r < 1 else GREY))
    drawn += [cross(left(slave)), cross(right(place))]
    a, b = left(slave)
    c, d = right(place)
    start, bend, end = (a + 10, b - 12), ((a + c) / 2, min(b, d) - 120), (c - 8, d - 13)
    parabola = [
        tuple((1 - t) ** 2 * p + 2 * t * (1 - t) * q + t * t * r for p, q, r in zip(start, bend, end))
        for t in (k / 40 for k in range(41))
    ]
    drawn += [path(parabola[:-2], INK, 1.5), arrow(parabola[-3], parabola[-1], INK, 1.5)]
    drawn += [
        text(a - 12, b + 6, "slave", anchor="end"),
        text(c - 22, d + 8, "Ξ"),
        text(right(first[4][6])[0], right(first[4][6])[1] - 87, "domain of a master", SMOOTH, "middle"),
        text(right(first[3][3])[0], right(first[3][3])[1] + 102, "domain of another node", "#666", "middle"),
        dot((24, 364), 7, SMOOTH),
        text(38, 369, f"the slave's {count} masters: Ξ is in their domains; the larger, the more weight"),
        dot((622, 364), 3, "#fff", GREY),
        text(634, 369, "other nodes"),
    ]
    write("sketch-domains.svg", (960, 384), drawn)


def clipped(polygon, facet):
    """The part of a polygon within a convex facet, both counter-clockwise."""
    for a, b in zip(facet, facet[1:] + facet[:1]):
        side = lambda p: (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
        kept = []
        for p, q in zip(polygon, polygon[1:] + polygon[:1]):
            s, t = side(p), side(q)
            if s >= 0:
                kept.append(p)
            if s * t < 0:
                kept.append(plus(p, times(s / (s - t), minus(q, p))))
        polygon = kept
    return polygon


def area(polygon):
    return sum(p[0] * q[1] - p[1] * q[0] for p, q in zip(polygon, polygon[1:] + polygon[:1])) / 2


def pieces_of(polygon):
    """A polygon as triangles of its smallest corners and a rest of four corners at most."""
    found = []
    while len(polygon) > 4:
        corner = lambda k: abs(area([polygon[k - 1], polygon[k], polygon[(k + 1) % len(polygon)]]))
        k = min(range(len(polygon)), key=corner)
        found.append([polygon[k - 1], polygon[k], polygon[(k + 1) % len(polygon)]])
        polygon = polygon[:k] + polygon[k + 1 :]
    return [*found, polygon]


def bilinear(corners, u, v):
    """A point of a quadrilateral."""
    shapes = [(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v]
    return tuple(sum(n * x[axis] for n, x in zip(shapes, corners)) for axis in range(2))


def points_of(polygon):
    """Points of the second degree with their areas."""
    if len(polygon) == 3:
        weight = area(polygon) / 3
        parts = [[2 / 3 if i == k else 1 / 6 for i in range(3)] for k in range(3)]
        return [(tuple(sum(n * x[axis] for n, x in zip(row, polygon)) for axis in range(2)), weight) for row in parts]
    found = []
    for u in (0.5 - math.sqrt(1 / 12), 0.5 + math.sqrt(1 / 12)):
        for v in (0.5 - math.sqrt(1 / 12), 0.5 + math.sqrt(1 / 12)):
            step = 1e-6
            along = times(1 / step, minus(bilinear(polygon, u + step, v), bilinear(polygon, u, v)))
            up = times(1 / step, minus(bilinear(polygon, u, v + step), bilinear(polygon, u, v)))
            found.append((bilinear(polygon, u, v), abs(along[0] * up[1] - along[1] * up[0]) / 4))
    return found


def natural(corners, point):
    """Natural coordinates of a point of a quadrilateral, by Newton's method."""
    u = v = 0.5
    for _ in range(20):
        x, step = bilinear(corners, u, v), 1e-6
        a = times(1 / step, minus(bilinear(corners, u + step, v), x))
        b = times(1 / step, minus(bilinear(corners, u, v + step), x))
        r = minus(point, x)
        det = a[0] * b[1] - a[1] * b[0]
        u, v = u + (r[0] * b[1] - r[1] * b[0]) / det, v + (a[0] * r[1] - a[1] * r[0]) / det
    return u, v


def pieces():
    """A face of the slave, cut along the facets over it."""
    face = [(1.02, 0.42), (3.30, 0.98), (2.92, 2.98), (0.68, 2.40)]
    shake = lambda i, k, more: 0.06 * math.sin(3 * i + 5.1 * k + more)
    node = lambda i, k: (1.32 * i + shake(i, k, 0), 1.16 * k + 0.05 + shake(i, k, 2))
    grid = [[node(i, k) for i in range(4)] for k in range(4)]
    left = lambda x: (20 + 86 * x[0], 352 - 86 * x[1])
    right = lambda x: (530 + 86 * x[0], 352 - 86 * x[1])
    drawn = [
        text(16, 26, "A face of the slave, cut along the facets over it"),
        text(494, 26, f"What node A has of each point: N{below('A')}times its area"),
    ]
    tints = ["0.10", "0.24"]
    all_points = []
    cuts = []
    for k in range(3):
        for i in range(3):
            facet = [grid[k][i], grid[k][i + 1], grid[k + 1][i + 1], grid[k + 1][i]]
            polygon = clipped(face, facet)
            if len(polygon) < 3:
                continue
            for part in pieces_of(polygon):
                all_points += points_of(part)
                cuts.append(part)
            for at in (left, right):
                tint = f' fill-opacity="{tints[(i + k) % 2]}"'
                drawn.append(path([at(x) for x in [*polygon, polygon[0]]], "none", 0, FACES, tint))
    for at in (left, right):
        for part in cuts:
            drawn.append(dashed([at(x) for x in [*part, part[0]]], FACES, 1, "3 3"))
    for line in [*grid, *zip(*grid)]:
        drawn.append(path([left(x) for x in line], FACETS, 1.5))
    for at in (left, right):
        drawn.append(path([at(x) for x in [*face, face[0]]], FACES, 3.5))
    for x, weight in all_points:
        drawn.append(dot(left(x), 17 * math.sqrt(weight), INK))
        u, v = natural(face, x)
        drawn.append(dot(right(x), 17 * math.sqrt(weight * (1 - u) * (1 - v)), INK))
    assert abs(sum(weight for _, weight in all_points) - area(face)) < 1e-5
    a, b = right(face[0])
    drawn += [
        dot(right(face[0]), 7, FACES),
        text(a - 12, b + 24, "A", more=' font-weight="bold"'),
        path([(16, 382), (44, 382)], FACETS, 1.5),
        text(50, 387, "facets of the master", FACETS),
        path([(216, 382), (244, 382)], FACES, 3.5),
        text(250, 387, "face of the slave", FACES),
        dashed([(392, 382), (420, 382)], FACES, 1, "3 3"),
        text(426, 387, "pieces", FACES),
        dot((500, 382), 5),
        text(512, 387, f"integration points, {len(all_points)} here; the larger, the more area"),
    ]
    write("sketch-pieces.svg", (960, 402), drawn)


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else "target/release/diffuse-contact"
    pieces()
    anchor(program)
    forces(program)
    domains(program)


if __name__ == "__main__":
    main()
