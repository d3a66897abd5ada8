"""Writes ironing_die.inp: the die of shallow_ironing.toml, one layer of hexahedra whose lower side is an arc.

    python3 examples/ironing_die.py > examples/ironing_die.inp

Other meshes than that of the deck have arguments: cells across, cells up, and the thickness.
"""

import math
import sys

ACROSS, UP, THICKNESS = 12, 6, 0.2
LEFT, WIDTH, APEX, TOP = 0.2, 1.2, 4.2, 5.4
RADIUS = 0.75


def node(i: int, j: int, k: int, across: int, up: int, thickness: float) -> tuple[float, float, float]:
    """Columns lead from even angles of the arc to even places of the flat top."""
    angle = math.asin(0.5 * WIDTH / RADIUS) * (2.0 * i / across - 1.0)
    below = LEFT + 0.5 * WIDTH + RADIUS * math.sin(angle), APEX + RADIUS * (1.0 - math.cos(angle))
    above = LEFT + WIDTH * i / across, TOP
    x, z = (low + (high - low) * k / up for low, high in zip(below, above, strict=True))
    return x, thickness * j, z


def main() -> None:
    across, up = (int(text) for text in sys.argv[1:3]) if len(sys.argv) > 2 else (ACROSS, UP)
    thickness = float(sys.argv[3]) if len(sys.argv) > 3 else THICKNESS

    def number(i: int, j: int, k: int) -> int:
        return 1 + i + (across + 1) * (j + 2 * k)

    print("*NODE")
    for k in range(up + 1):
        for j in range(2):
            for i in range(across + 1):
                x, y, z = node(i, j, k, across, up, thickness)
                print(f"{number(i, j, k)}, {x:.9g}, {y:.9g}, {z:.9g}")
    print("*ELEMENT, TYPE=C3D8, ELSET=die")
    for k in range(up):
        for i in range(across):
            face = [(0, 0), (1, 0), (1, 1), (0, 1)]
            corners = [number(i + a, b, k + c) for c in range(2) for a, b in face]
            print(", ".join(map(str, [1 + i + across * k, *corners])))
    # Face 1 of a hexahedron is below, 4 on the side of larger x, 6 on that of smaller x.
    print("*SURFACE, NAME=contact")
    for i in range(across):
        print(f"{1 + i}, S1")
    for k in range(up):
        print(f"{across * (k + 1)}, S4")
        print(f"{1 + across * k}, S6")
    for name, chosen in {"front": ("j", 0), "back": ("j", 1), "top": ("k", up)}.items():
        print(f"*NSET, NSET={name}")
        for k in range(up + 1):
            for j in range(2):
                for i in range(across + 1):
                    if {"j": j, "k": k}[chosen[0]] == chosen[1]:
                        print(number(i, j, k))


if __name__ == "__main__":
    main()
