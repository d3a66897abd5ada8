"""A block on an arch: the mesh, as any program that makes meshes would hand it over, and partitions of its cells."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from compat import destinations, hexahedra
from dolfinx import mesh
from mpi4py import MPI
from surfaces import CORNERS

RADIUS = 8.0


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


class Scene:
    """The mesh by the numbers of its input; ``fine`` cells take the place of each, along x and along y."""

    def __init__(self, fine: int = 1) -> None:
        cells = (np.array([fine, fine, 1]) * [[9, 5, 3], [10, 4, 4]]).tolist()
        (a, b, c), (d, e, f) = cells
        arch, arch_cells = brick(np.linspace(-4, 4, a + 1), np.linspace(-1, 3, b + 1), np.linspace(-2, 0, c + 1))
        arch[:, 2] += arch_height(arch[:, 0]) * (arch[:, 2] + 2) / 2
        block, block_cells = brick(np.linspace(-2, 2, d + 1), np.linspace(0, 2, e + 1), np.linspace(0, 2, f + 1))
        self.nodes = np.vstack([arch, block])
        self.cells = np.vstack([arch_cells, block_cells + len(arch)]).astype(np.int64)
        # The upper facets of the arch's last layer, the lower ones of the block's first.
        self.master_facets = arch_cells[-a * b :][:, CORNERS[5]]
        self.slave_facets = block_cells[: d * e][:, CORNERS[0]] + len(arch)

    def parts(self, partitioner: str, ranks: int) -> np.ndarray:
        """The rank of each cell: in ``"strips"`` across x, in ``"blocks"`` of x and y, or at ``"random"``."""
        middle = self.nodes[self.cells].mean(axis=1)
        if partitioner == "random":
            return np.random.default_rng(1).permutation(np.arange(len(middle)) % ranks)
        rows = 2 if partitioner == "blocks" and ranks % 2 == 0 else 1
        across = np.clip((middle[:, 0] + 2.5) / 5 * (ranks // rows), 0, ranks // rows - 1).astype(int)
        along = np.clip(middle[:, 1] / 2 * rows, 0, rows - 1).astype(int)
        return rows * across + along

    def partitioner(self, name: str, comm: MPI.Comm) -> Callable[..., object] | None:
        """None for dolfinx's own."""
        if name == "dolfinx":
            return None

        def partition(*_: object) -> object:
            # The rank that owns the cell, then those it is a ghost of: they own a cell with a node in common.
            if comm.rank != 0:
                return destinations([])
            owners = self.parts(name, comm.size)
            ranks = [[owner] for owner in owners]
            for rank in range(comm.size):
                beside = np.isin(self.cells, self.cells[owners == rank]).any(axis=1)
                for cell in np.flatnonzero(beside & (owners != rank)):
                    ranks[cell].append(rank)
            return destinations(ranks)

        return partition

    def mesh(self, comm: MPI.Comm, partitioner: str) -> mesh.Mesh:
        """The mesh, put in by rank 0 and distributed."""
        here = slice(None) if comm.rank == 0 else slice(0, 0)
        return hexahedra(comm, self.cells[here], self.nodes[here], self.partitioner(partitioner, comm))
