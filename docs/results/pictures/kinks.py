#!/usr/bin/env python3
"""Draws kinks.svg beside it: facets kink, the smooth surface through the same nodes does not.

Usage: docs/results/pictures/kinks.py [PROGRAM]. It needs the program `diffuse-contact`; `cargo build --release` makes it.

A cylinder of coarse facets is the master. Slave nodes along an arc over it are evaluated by `diffuse-contact surface`, with the
smooth surface and on the facets: their feet and normals are what is drawn.
"""

import math
import pathlib
import re
import struct
import subprocess
import sys
import tempfile

from drawing import COLOURS, FAINT, INK, dashed, dot, path, text, write

RADIUS, CELL, CELLS, ROWS, WIDTH = 100.0, 24.0, 8, 6, 42.0
# The part that is shown, degrees from the top, and its slave nodes.
SHOWN, STEPS = 42.0, 336
SMOOTH, FACETS = COLOURS["smooth"], COLOURS["facets"]
# Place of the facets' edges, degrees, and length of the normals that are drawn, pixels.
EDGES, NORMAL = (-1.5 * CELL, -0.5 * CELL, 0.5 * CELL, 1.5 * CELL), 36
PLACES = [SHOWN * (2 * k / STEPS - 1) for k in range(STEPS + 1)]


def around(degrees, radius, y):
    """A point of a cylinder along y; 0 degrees is on top."""
    angle = math.radians(degrees)
    return radius * math.sin(angle), y, radius * math.cos(angle)


def mesh():
    """An Abaqus file: the master's coarse cells, and a fine strip of slaves over their middle."""
    lines, count, number = ["*NODE"], 0, 0

    def grid(angles, radius, ys):
        nonlocal count
        first = count
        for y in ys:
            for angle in angles:
                count += 1
                lines.append(f"{count}, " + ", ".join(f"{x:.12g}" for x in around(angle, radius, y)))
        return first

    coarse = [CELL * (k - CELLS / 2 + 0.5) for k in range(CELLS)]
    fine = [SHOWN * (2 * k / STEPS - 1) for k in range(STEPS + 1)]
    master = grid(coarse, RADIUS, [WIDTH * k for k in range(ROWS)])
    middle = WIDTH * (ROWS - 1) / 2
    slave = grid(fine, RADIUS + 3, [middle, middle + 1])
    for name, first, columns, rows in (("MASTER", master, CELLS, ROWS), ("SLAVE", slave, STEPS + 1, 2)):
        lines.append(f"*ELEMENT, TYPE=S4, ELSET={name}")
        for row in range(rows - 1):
            for column in range(columns - 1):
                a = first + row * columns + column + 1
                number += 1
                lines.append(f"{number}, {a}, {a + columns}, {a + columns + 1}, {a + 1}"
                             if name == "SLAVE" else f"{number}, {a}, {a + 1}, {a + columns + 1}, {a + columns}")
    return "\n".join(lines) + "\n"


def arrays(path, names):
    """Arrays of a VTU file with raw appended data: lists of tuples."""
    data = path.read_bytes()
    head, _, rest = data.partition(b'<AppendedData encoding="raw">\n_')
    found = []
    for name, size in names:
        tag = re.search(rf'Name="{name}"[^>]*offset="(\d+)"', head.decode())
        begin = int(tag[1])
        (length,) = struct.unpack_from("<Q", rest, begin)
        numbers = struct.unpack_from(f"<{length // 8}d", rest, begin + 8)
        found.append([numbers[k : k + size] for k in range(0, len(numbers), size)])
    return found


def section(program, element):
    """Foot and angle of the normal of the slaves along the arc, by the element."""
    with tempfile.TemporaryDirectory() as folder:
        source, result = pathlib.Path(folder, "arc.inp"), pathlib.Path(folder, "arc.vtu")
        source.write_text(mesh())
        command = [program, "surface", source, "-o", result, "--element", element]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        feet, normals = arrays(result, [("foot", 3), ("normal", 3)])
    angles = [math.degrees(math.atan2(x, z)) for x, _, z in normals]
    return [(x, z) for x, _, z in feet[: STEPS + 1]], angles[: STEPS + 1]


def signed(degrees):
    """A tick."""
    return f"{degrees}".replace("-", "−")


def shape(x, y, curve, colour):
    """The section of a surface with its normals; x, y is where the cylinder's highest point is drawn."""
    feet, angles = curve
    scale = 2.9
    at = lambda a, b: (x + scale * a, y + scale * (RADIUS - b))
    tip = lambda place, angle, length: (
        place[0] + length * math.sin(math.radians(angle)),
        place[1] - length * math.cos(math.radians(angle)),
    )
    place = [at(a, b) for a, b in feet]
    drawn = []
    nodes = [at(*around(edge, RADIUS, 0.0)[::2]) for edge in EDGES]
    for edge, node in zip(EDGES, nodes):
        # What the normal leaves out: from the one before the edge to the one behind it.
        before, behind = (angles[round((edge + SHOWN + side) * STEPS / (2 * SHOWN))] for side in (-1.0, 1.0))
        if behind - before > CELL / 2:
            arc = [tip(node, before + (behind - before) * k / 12, NORMAL) for k in range(13)]
            drawn.append(path([node, *arc, node], "none", 0, colour, ' fill-opacity="0.16"'))
            drawn += [path([node, tip(node, angle, NORMAL)], colour, 1.3) for angle in (before, behind)]
    drawn += [path([place[k], tip(place[k], angles[k], NORMAL)], colour, 1.3) for k in range(0, STEPS + 1, 16)]
    drawn.append(path(place, colour, 3))
    drawn += map(dot, nodes)
    return drawn


def unbroken(points):
    """The parts of a curve between its jumps."""
    parts = [[points[0]]]
    for before, point in zip(points, points[1:]):
        if abs(point[1] - before[1]) > CELL / 4:
            parts.append([])
        parts[-1].append(point)
    return parts


def chart(left, right, top, bottom, curves):
    """Directions of normals over the place, by name and colour."""
    across = lambda degrees: left + (right - left) * (degrees + SHOWN) / (2 * SHOWN)
    up = lambda degrees: (top + bottom) / 2 - (bottom - top) * degrees / (2 * 54)
    drawn = []
    for value in (-40, -20, 0, 20, 40):
        drawn.append(path([(left, up(value)), (right, up(value))], FAINT, 1))
        drawn.append(text(left - 8, up(value) + 5, signed(value), anchor="end"))
        drawn.append(path([(across(value), bottom), (across(value), bottom + 5)], INK, 1))
        drawn.append(text(across(value), bottom + 21, signed(value), anchor="middle"))
    for edge in EDGES:
        drawn.append(dashed([(across(edge), top), (across(edge), bottom)], "#999"))
    drawn.append(path([(left, top), (left, bottom), (right, bottom)], INK, 1))
    for angles, colour in curves:
        for part in unbroken(list(zip(PLACES, angles))):
            drawn.append(path([(across(a), up(b)) for a, b in part], colour, 3))
    middle = (top + bottom) / 2
    drawn += [
        text((left + right) / 2, bottom + 44, "place on the cylinder, degrees from the top", anchor="middle"),
        text(left - 48, middle, "direction of the normal, degrees", anchor="middle",
             more=f' transform="rotate(-90 {left - 48} {middle})"'),
        text(across(-34), up(33), "facets: it jumps at each edge", FACETS),
        text(across(0), up(-37), "smooth surface: it turns", SMOOTH),
    ]
    return drawn


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else "target/release/diffuse-contact"
    facets, smooth = section(program, "node-to-facet"), section(program, "diffuse")
    parts = [
        text(16, 26, f"Facets of {CELL:.0f}° and their normals", FACETS),
        text(16, 222, "The smooth surface from the same nodes and its normals", SMOOTH),
        *shape(232, 88, facets, FACETS),
        text(352, 54, f"a jump of {CELL:.0f}°", FACETS),
        *shape(232, 284, smooth, SMOOTH),
        *chart(586, 936, 22, 338, [(facets[1], FACETS), (smooth[1], SMOOTH)]),
    ]
    write("kinks.svg", (960, 400), parts)


if __name__ == "__main__":
    main()
