"""What the scripts beside it draw with: colours by meaning, and parts of an SVG picture."""

import json
import math
import pathlib

HERE = pathlib.Path(__file__).resolve().parent
# By meaning, the same in all pictures of the book.
COLOURS = json.loads((HERE / "colours.json").read_text(encoding="utf-8"))
INK, GREY, FAINT = "#222", "#888", "#ddd"


def path(points, colour, width=2.0, fill="none", more=""):
    """A curve."""
    steps = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return f'<polyline points="{steps}" fill="{fill}" stroke="{colour}" stroke-width="{width}"{more}/>'


def dashed(points, colour, width=1.0, dashes="2 4"):
    """A broken curve."""
    return path(points, colour, width, more=f' stroke-dasharray="{dashes}"')


def arrow(start, end, colour=INK, width=2.5, head=11.0):
    """An arrow."""
    (a, b), (c, d) = start, end
    length = math.hypot(c - a, d - b)
    if length < 1e-9:
        return ""
    head = min(head, 0.6 * length)
    u, v = (c - a) / length, (d - b) / length
    left, right = ((c - head * u - side * 0.4 * head * v, d - head * v + side * 0.4 * head * u) for side in (-1, 1))
    return path([start, (c - 0.8 * head * u, d - 0.8 * head * v)], colour, width) + path(
        [end, left, right], "none", 0, colour
    )


def dot(place, radius=4.5, fill=INK, stroke="none"):
    """A point."""
    return f'<circle cx="{place[0]:.1f}" cy="{place[1]:.1f}" r="{radius:.1f}" fill="{fill}" stroke="{stroke}" stroke-width="1.5"/>'


def text(x, y, words, colour=INK, anchor="start", more=""):
    """A line of text, on white where it lies over lines."""
    halo = 'stroke="#fff" stroke-width="4" stroke-linejoin="round" paint-order="stroke"'
    return f'<text x="{x:.1f}" y="{y:.1f}" fill="{colour}" text-anchor="{anchor}" {halo}{more}>{words}</text>'


def write(name, size, parts):
    """The picture, on white."""
    width, height = size
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
        'font-family="sans-serif" font-size="16">',
        '<rect width="100%" height="100%" fill="#fff"/>',
        *parts,
        "</svg>",
    ]
    (HERE / name).write_text("\n".join(lines) + "\n", encoding="utf-8")
