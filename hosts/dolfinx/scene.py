#!/usr/bin/env python3
"""A block on an arch: writes the mesh to a file, as a program that makes meshes would hand it over.

``scene.py mesh.xdmf`` writes XDMF with HDF5 by one process, with ``--arrays`` also what is in the file as numpy arrays.
Ranks of ``press.py`` each read a part of it: see ``source``.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

RADIUS = 8.0
# Corners of the facets of a hexahedron in dolfinx's order, counter-clockwise seen from outside.
CORNERS = np.array([[0, 2, 3, 1], [0, 1, 5, 4], [0, 4, 6, 2], [1, 3, 7, 5], [2, 6, 7, 3], [4, 5, 7, 6]])


def brick(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nodes, x running fastest, and hexahedra in dolfinx's order: x fastest, then y, then z."""
    nodes = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).transpose(2, 1, 0, 3).reshape(-1, 3)
    i, j, k = (np.arange(len(axis) - 1) for axis in (x, y, z))
    rows, planes = len(x), len(x) * len(y)
    first = (i + rows * j[:, np.newaxis] + planes * k[:, np.newaxis, np.newaxis]).reshape(-1, 1)
    corner = np.array([a + rows * b + planes * c for c in (0, 1) for b in (0, 1) for a in (0, 1)])
    return nodes, first + corner


def arch_height(x: np.ndarray) -> np.ndarray:
    """The upper side of the arch; inside of its radius."""
    return np.sqrt(np.maximum(RADIUS**2 - x**2, 0.0)) - RADIUS


def on_master(x: np.ndarray) -> np.ndarray:
    """Whether points x, shape (3, n), are on the upper side of the arch."""
    return np.abs(x[2] - arch_height(x[0])) < 1e-9


def on_slave(x: np.ndarray) -> np.ndarray:
    """Whether points are on the underside of the block."""
    return (np.abs(x[2]) < 1e-9) & (np.abs(x[0]) < 2 + 1e-9) & (x[1] > -1e-9) & (x[1] < 2 + 1e-9)


def block_on_arch(fine: int = 1, deep: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and cells; ``fine`` cells take the place of each along x and along y, ``deep`` along z."""
    cells = (np.array([fine, fine, deep]) * [[9, 5, 3], [10, 4, 4]]).tolist()
    (a, b, c), (d, e, f) = cells
    arch, arch_cells = brick(np.linspace(-4, 4, a + 1), np.linspace(-1, 3, b + 1), np.linspace(-2, 0, c + 1))
    arch[:, 2] += arch_height(arch[:, 0]) * (arch[:, 2] + 2) / 2
    block, block_cells = brick(np.linspace(-2, 2, d + 1), np.linspace(0, 2, e + 1), np.linspace(0, 2, f + 1))
    return np.vstack([arch, block]), np.vstack([arch_cells, block_cells + len(arch)]).astype(np.int64)


def facets_on(nodes: np.ndarray, cells: np.ndarray, is_on: object) -> np.ndarray:
    """The facets, shape (f, 4), whose corners all satisfy ``is_on(x)``: cell by cell, in the order of ``CORNERS``."""
    facets = cells[:, CORNERS].reshape(-1, 4)
    return facets[is_on(nodes.T)[facets].all(axis=1)]


def main() -> None:
    """Writes the file."""
    from compat import hexahedra
    from dolfinx.io import XDMFFile
    from mpi4py import MPI
    from source import MeshFile

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path, help="mesh.xdmf; mesh.h5 comes beside it")
    parser.add_argument("--fine", type=int, default=1, help="cells in place of each, along x and y")
    parser.add_argument("--deep", type=int, default=1, help="the same along z")
    parser.add_argument("--arrays", type=Path, help="nodes and cells of the file as .npz")
    arguments = parser.parse_args()
    nodes, cells = block_on_arch(arguments.fine, arguments.deep)
    with XDMFFile(MPI.COMM_SELF, str(arguments.file), "w") as file:
        file.write_mesh(hexahedra(MPI.COMM_SELF, cells, nodes, None))
    if arguments.arrays is not None:
        mesh = MeshFile(MPI.COMM_SELF, arguments.file)
        np.savez(arguments.arrays, nodes=mesh.nodes, cells=mesh.cells)


if __name__ == "__main__":
    main()
