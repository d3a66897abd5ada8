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

HERE = pathlib.Path(__file__).resolve().parent
RADIUS, CELL, CELLS, ROWS, WIDTH = 100.0, 24.0, 8, 6, 42.0
# The part that is shown, degrees from the top, and its slave nodes.
SHOWN, STEPS = 42.0, 336
SMOOTH, FACETS, INK = "#b2182b", "#2166ac", "#333"


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


def path(points, colour, width=2.0):
    """A curve."""
    steps = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return f'<polyline points="{steps}" fill="none" stroke="{colour}" stroke-width="{width}"/>'


def text(x, y, words, colour=INK, anchor="start"):
    """A line of text."""
    return f'<text x="{x}" y="{y}" fill="{colour}" text-anchor="{anchor}">{words}</text>'


def shape(x, y, curve, colour):
    """The section of a surface with its normals; x, y is where its highest point is drawn."""
    feet, angles = curve
    scale = 2.9
    place = [(x + scale * a, y + scale * (RADIUS - b)) for a, b in feet]
    drawn = [path(place, colour, 2.5)]
    for k in range(8, STEPS, 16):
        (a, b), angle = place[k], math.radians(angles[k])
        tip = (a + 34 * math.sin(angle), b - 34 * math.cos(angle))
        drawn.append(path([(a, b), tip], colour, 1.2))
    return drawn


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else "target/release/diffuse-contact"
    facets, smooth = section(program, "node-to-facet"), section(program, "diffuse")
    lines = [
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 960 380" width="960" height="380" '
        'font-family="sans-serif" font-size="15">',
        '<rect width="100%" height="100%" fill="#fff"/>',
        text(20, 26, f"normals along facets of {CELL:.0f}°", FACETS),
        text(20, 206, "normals along the smooth surface from the same nodes", SMOOTH),
    ]
    lines += shape(225, 88, facets, FACETS) + shape(225, 268, smooth, SMOOTH)

    # Direction of the normal against the place on the arc.
    left, right, top, bottom = 560, 930, 50, 330
    across = lambda degrees: left + (right - left) * (degrees + SHOWN) / (2 * SHOWN)
    up = lambda degrees: (top + bottom) / 2 - (bottom - top) * degrees / (2 * 52)
    for value in (-40, -20, 0, 20, 40):
        lines.append(path([(left, up(value)), (right, up(value))], "#ddd", 1))
        lines.append(text(left - 8, up(value) + 5, f"{value}°", anchor="end"))
        lines.append(text(across(value), bottom + 20, f"{value}°", anchor="middle"))
    places = [SHOWN * (2 * k / STEPS - 1) for k in range(STEPS + 1)]
    for (_, angles), colour in ((facets, FACETS), (smooth, SMOOTH)):
        lines.append(path([(across(a), up(b)) for a, b in zip(places, angles)], colour, 2.5))
    lines += [
        text(left, 26, "direction of the normal over the place on the cylinder"),
        text(across(-36), up(32), "facets jump at every edge", FACETS),
        text(across(2), up(-24), "the smooth surface turns", SMOOTH),
        "</svg>",
    ]
    (HERE / "kinks.svg").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
