"""Writes snap_hook.inp: the hook of snap_fit.toml, a beam with a nose of hexahedra that ends in a ramp.

    python3 examples/snap_hook.py > examples/snap_hook.inp

Another mesh than that of the deck has its cells' size in the plane as an argument.
"""

import sys
from itertools import pairwise

SIZE, LAYERS, WIDTH = 0.5, 3, 5.0
# Places along x: the beam's root, the undercut, the edge between the hook's flat top and its ramp, the tip.
ROOT, UNDERCUT, EDGE, TIP = 0.0, 25.0, 26.4, 30.0
# Heights: of the beam, of the hook's flat top, of the ramp's end at the tip.
BEAM, TOP, END = 2.0, 3.5, 2.4


def cells(length: float, size: float) -> int:
    """How many of about this size."""
    return max(1, round(length / size))


def columns(size: float) -> list[float]:
    """Places along x; the undercut and the edge are among them."""
    places = [ROOT]
    for start, end in pairwise((ROOT, UNDERCUT, EDGE, TIP)):
        count = cells(end - start, size)
        places += [start + (end - start) * k / count for k in range(1, count + 1)]
    return places


def main() -> None:
    """Prints the mesh."""
    size = float(sys.argv[1]) if len(sys.argv) > 1 else SIZE
    places = columns(size)
    undercut = places.index(UNDERCUT)
    up, more = cells(BEAM, size), cells(TOP - BEAM, size)
    numbers: dict[tuple[int, int, int], int] = {}

    def rows(i: int) -> int:
        """Rows of nodes above the lowest at a column."""
        return up + more if i >= undercut else up

    def height(i: int, j: int) -> float:
        if j <= up:
            return BEAM * j / up
        top = TOP + (END - TOP) * max(0.0, places[i] - EDGE) / (TIP - EDGE)
        return BEAM + (top - BEAM) * (j - up) / more

    print("*NODE")
    for k in range(LAYERS + 1):
        for i in range(len(places)):
            for j in range(rows(i) + 1):
                numbers[i, j, k] = len(numbers) + 1
                print(f"{numbers[i, j, k]}, {places[i]:.9g}, {height(i, j):.9g}, {WIDTH * k / LAYERS:.9g}")
    print("*ELEMENT, TYPE=C3D8, ELSET=hook")
    # Face 5 of a hexahedron is above, 4 on the side of larger x, 6 on that of smaller x.
    faces: list[tuple[int, str]] = []
    element = 0
    for k in range(LAYERS):
        for i in range(len(places) - 1):
            highest = min(rows(i), rows(i + 1))
            for j in range(highest):
                element += 1
                face = [(0, 0), (1, 0), (1, 1), (0, 1)]
                corners = [numbers[i + a, j + b, k + c] for c in range(2) for a, b in face]
                print(", ".join(map(str, [element, *corners])))
                if j == highest - 1:
                    faces.append((element, "S5"))
                if j >= up and i == undercut:
                    faces.append((element, "S6"))
                if j >= up and i == len(places) - 2:
                    faces.append((element, "S4"))
    print("*SURFACE, NAME=face")
    for element, face_name in faces:
        print(f"{element}, {face_name}")
    print("*NSET, NSET=root")
    for (i, _, _), number in numbers.items():
        if i == 0:
            print(number)


if __name__ == "__main__":
    main()
