"""The pinched pipe and the ring on a block of `examples/` in CalculiX, surface to surface: iterations and forces.

`calculix.py FOLDER` writes inputs to a folder, runs `ccx` on them, and prints a table in Markdown. Meshes, supports and increments
are those of the decks; bodies are compressible neo-Hookean. N, mm.
"""

import itertools
import math
import pathlib
import re
import shutil
import subprocess
import sys

# Faces of C3D8 where a body's grid begins and ends in each of its directions.
FACES = {"i-": 6, "i+": 4, "j-": 3, "j+": 5, "k-": 1, "k+": 2}
CORNERS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
POISSON = 0.3
# Over the mean force, as in the decks. CalculiX' own 5e-3 saved one iteration in eight runs, with other stiffnesses: it waits for small
# corrections as well.
RESIDUAL = 1e-6


def pipe(inner, outer, start, end, length, centre):
    """i goes through the wall, j around from `start` to `end`, degrees, k along."""

    def place(i, j, k):
        radius, angle = inner + i * (outer - inner), math.radians(start + j * (end - start))
        return radius * math.cos(angle), centre + radius * math.sin(angle), k * length

    return place


def box(origin, size):
    """i, j and k go along x, y and z."""
    return lambda *steps: tuple(o + s * step for o, s, step in zip(origin, size, steps, strict=True))


# Bodies: cells, place, Young's modulus. Supports: side, axis. The pair: slave, master. Pressure over overlap, N/mm³: the deck's penalty
# over a slave's area. `along` is the side that carries forces along the axis.
DECKS = {
    "pipe_pinch": {
        "bodies": {
            "pipe": ((2, 16, 2), pipe(90, 100, 0, 90, 20, 0), 200e3),
            "plate": ((12, 2, 2), box((0, 99.999, 0), (150, 20, 20)), 200e3),
        },
        "supports": [("pipe.j-", 2), ("pipe.j+", 1), ("plate.i-", 1), ("pipe.k-", 3), ("plate.k-", 3)],
        "moved": ("plate.j+", -80),
        "pair": ("plate.j-", "pipe.i+"),
        "stiffness": 16e3,
        "increment": (0.03125, 0.03125),
        "along": "pipe.k-",
    },
    "ring_block": {
        "bodies": {
            "ring": ((2, 32, 2), pipe(90, 100, -90, 0, 20, 100), 10e3),
            "block": ((20, 6, 3), box((0, -50, -5), (130, 50, 30)), 300),
        },
        "supports": [("block.j-", axis) for axis in (1, 2, 3)]
        + [("ring.j-", 1), ("block.i-", 1), ("ring.k-", 3), ("block.k-", 3), ("ring.j+", 1)],
        "moved": ("ring.j+", -60),
        "pair": ("ring.i+", "block.j+"),
        "stiffness": 200,
        "increment": (0.025, 0.05),
        "along": "ring.k-",
    },
}


class Mesh:
    """Bodies of hexahedra, with nodes and faces of their sides by name, "body.side"."""

    def __init__(self, bodies):
        self.places, self.cells, self.nodes, self.faces = [], {}, {}, {}
        for body, (counts, place, _) in bodies.items():
            self.add(body, counts, place)

    def add(self, body, counts, place):
        first, first_cell = len(self.places) + 1, sum(map(len, self.cells.values())) + 1
        steps = list(itertools.product(*(range(count + 1) for count in reversed(counts))))
        number = {step[::-1]: first + k for k, step in enumerate(steps)}
        self.places += [place(*(s / n for s, n in zip(step, counts, strict=True))) for step in number]
        cells = list(itertools.product(*map(range, counts)))
        self.cells[body] = {
            first_cell + k: [number[tuple(s + c for s, c in zip(cell, corner, strict=True))] for corner in CORNERS]
            for k, cell in enumerate(cells)
        }
        for side, face in FACES.items():
            axis, upper = "ijk".index(side[0]), side[1] == "+"
            last = counts[axis] * upper
            self.nodes[f"{body}.{side}"] = [n for step, n in number.items() if step[axis] == last]
            at = [first_cell + k for k, cell in enumerate(cells) if cell[axis] == max(last - 1, 0)]
            self.faces[f"{body}.{side}"] = [(cell, f"S{face}") for cell in at]


def identifier(name):
    return name.upper().replace(".", "_").replace("-", "A").replace("+", "Z")


def text(deck, element, exchange):
    """CalculiX' input."""
    mesh = Mesh(deck["bodies"])
    lines = ["*NODE", *(f"{k}, {x:.12g}, {y:.12g}, {z:.12g}" for k, (x, y, z) in enumerate(mesh.places, 1))]
    for body, (_, _, young) in deck["bodies"].items():
        name, shear, bulk = identifier(body), young / (2 + 2 * POISSON), young / (3 - 6 * POISSON)
        lines += [f"*ELEMENT, TYPE={element}, ELSET={name}"]
        lines += [f"{cell}, {', '.join(map(str, nodes))}" for cell, nodes in mesh.cells[body].items()]
        lines += [f"*MATERIAL, NAME=OF_{name}", "*HYPERELASTIC, NEO HOOKE", f"{shear / 2:.12g}, {2 / bulk:.12g}"]
        lines += [f"*SOLID SECTION, ELSET={name}, MATERIAL=OF_{name}"]
    for name, nodes in mesh.nodes.items():
        lines += [f"*NSET, NSET={identifier(name)}", *(f"{node}," for node in nodes)]
    slave, master = deck["pair"][::-1] if exchange else deck["pair"]
    for label, side in (("SLAVE", slave), ("MASTER", master)):
        lines += [f"*SURFACE, NAME={label}, TYPE=ELEMENT", *(f"{cell}, {face}" for cell, face in mesh.faces[side])]
    lines += ["*SURFACE INTERACTION, NAME=CONTACT", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"]
    lines += [f"{deck['stiffness']}", "*CONTACT PAIR, INTERACTION=CONTACT, TYPE=SURFACE TO SURFACE", "SLAVE, MASTER"]
    lines += ["*BOUNDARY", *(f"{identifier(side)}, {axis}, {axis}" for side, axis in deck["supports"])]
    first, largest = deck["increment"]
    lines += ["*STEP, NLGEOM, INC=1000", "*CONTROLS, PARAMETERS=FIELD", f"{RESIDUAL}"]
    (moved, by), along = deck["moved"], deck["along"]
    lines += ["*STATIC", f"{first}, 1, 1e-7, {largest}", "*BOUNDARY", f"{identifier(moved)}, 2, 2, {by}"]
    for side in (moved, along):
        lines += [f"*NODE PRINT, NSET={identifier(side)}, TOTALS=ONLY", "RF"]
    return "\n".join([*lines, "*END STEP", ""])


def reactions(output, side):
    """A side's reaction in every increment."""
    number = r"(-?[\d.]+E[+-]\d+)"
    found = re.findall(rf"for set {identifier(side)} and time.*\n\s*{number}\s+{number}\s+{number}", output)
    return [tuple(map(float, force)) for force in found]


def run(folder, name, element, exchange):
    """Increments, failed tries, iterations with those of failed tries, force at the end, largest axial force over its increment's."""
    deck = DECKS[name]
    job = f"{name}-{element}-{int(exchange)}"
    (folder / f"{job}.inp").write_text(text(deck, element, exchange))
    done = subprocess.run(["ccx", job], cwd=folder, capture_output=True, text=True, check=False)
    rows = [line.split() for line in (folder / f"{job}.cvg").read_text().splitlines()[4:]]
    tries = {(row[1], row[2]) for row in rows}
    increments = {increment for increment, _ in tries}
    output = (folder / f"{job}.dat").read_text()
    pressed, along = (reactions(output, side) for side in (deck["moved"][0], deck["along"]))
    if "Job finished" not in done.stdout:
        return [len(increments), len(tries) - len(increments), len(rows), "ends before", "–"]
    shares = [abs(axial[2] / force[1]) for axial, force in zip(along, pressed, strict=True)]
    failed = len(tries) - len(increments)
    return [len(increments), failed, len(rows), f"{abs(pressed[-1][1]):.0f}", f"{100 * max(shares):.2f} %"]


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: calculix.py FOLDER")
    if shutil.which("ccx") is None:
        sys.exit("ccx, CalculiX' solver, is not installed")
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    columns = ["deck", "element", "master", "increments", "cut-backs", "iterations", "force at the end, N"]
    columns += ["axial force over it, largest"]
    print(f"| {' | '.join(columns)} |\n|{' --- |' * 3}{' ---: |' * 5}")
    for name, element, exchange in itertools.product(DECKS, ["C3D8", "C3D8I"], [False, True]):
        master = DECKS[name]["pair"][not exchange].split(".")[0]
        print(f"| {' | '.join(map(str, [name, element, master, *run(folder, name, element, exchange)]))} |", flush=True)


if __name__ == "__main__":
    main()
