"""Meshes from files: each rank reads its part, and a partitioner says where the cells go."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from compat import destinations, hexahedra
from dolfinx import mesh
from dolfinx.io import XDMFFile
from exchange import Exchange
from mpi4py import MPI


class MeshFile:
    """What this rank reads of an XDMF file: its share of the cells and its share of the nodes, one after another.

    Numbers of the input are places in the file.
    """

    def __init__(self, comm: MPI.Comm, path: Path) -> None:
        self.comm = comm
        with XDMFFile(comm, str(path), "r") as file:
            self.cells = np.asarray(file.read_topology_data("mesh", "/Xdmf/Domain"), dtype=np.int64)
            self.nodes = np.asarray(file.read_geometry_data("mesh", "/Xdmf/Domain"), dtype=np.float64)

    @property
    def nbytes(self) -> int:
        """Bytes that this rank has read."""
        return self.cells.nbytes + self.nodes.nbytes

    def mesh(self, partition: str) -> mesh.Mesh:
        """The mesh by ``"dolfinx"``'s own partitioner, in ``"strips"``, ``"blocks"`` or at ``"random"``."""
        partitioner = None if partition == "dolfinx" else self._partitioner(partition)
        return hexahedra(self.comm, self.cells, self.nodes, partitioner)

    def _partitioner(self, partition: str) -> Callable[..., object]:
        # What takes messages is done now: dolfinx asks from within a call of its own.
        exchange = Exchange(self.comm)
        nodes, corners = np.unique(self.cells, return_inverse=True)
        corners = corners.reshape(self.cells.shape)
        shares = Shares(exchange, len(self.nodes))
        positions = shares.ask(nodes, lambda places: self.nodes[places])
        before = self.comm.exscan(len(self.cells)) or 0
        numbers = before + np.arange(len(self.cells))
        parts = parts_of(partition, numbers, positions[corners].mean(axis=1), self.comm.size)
        # A cell is also a ghost of the ranks that own a cell with a node in common.
        pairs = np.unique(np.stack([np.repeat(parts, 8), self.cells.reshape(-1)], axis=1), axis=0)
        ranks_at = shares.collect(pairs[:, 1], pairs[:, 0], nodes)
        rows = []
        for part, own in zip(parts.tolist(), corners.tolist(), strict=True):
            others = set().union(*(ranks_at[node] for node in own))
            rows.append([part, *sorted(others - {part})])
        return lambda *_: destinations(rows)


class Shares:
    """Rows that ranks hold one after another, asked for by number."""

    def __init__(self, exchange: Exchange, count: int) -> None:
        self.exchange = exchange
        self.ends = np.cumsum(exchange.comm.allgather(count))
        self.first = int(self.ends[exchange.comm.rank]) - count

    def _by_owner(self, numbers: np.ndarray, *others: np.ndarray) -> dict[int, tuple[np.ndarray, ...]]:
        owners = np.searchsorted(self.ends, numbers, side="right")
        return {int(rank): tuple(array[owners == rank] for array in (numbers, *others)) for rank in np.unique(owners)}

    def ask(self, numbers: np.ndarray, rows: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """The rows of these numbers, which ascend."""
        asked = self.exchange.to("mesh", self._by_owner(numbers))
        answers = {rank: (rows(wanted - self.first),) for rank, (wanted,) in asked.items()}
        # By ascending rank, as numbers are.
        return np.concatenate([rows(numbers[:0]), *(row for (row,) in self.exchange.to("mesh", answers).values())])

    def collect(self, numbers: np.ndarray, values: np.ndarray, wanted: np.ndarray) -> list[set[int]]:
        """What all ranks say of the rows ``wanted``, each of which this rank has said something of."""
        said = self.exchange.to("mesh", self._by_owner(numbers, values))
        everything = np.concatenate([np.empty((2, 0), dtype=np.int64), *(np.stack(of) for of in said.values())], axis=1)
        answers = {}
        for rank, (asked, _) in said.items():
            answers[rank] = tuple(everything[:, np.isin(everything[0], asked)])
        found: list[set[int]] = [set() for _ in wanted]
        for names, said_of in self.exchange.to("mesh", answers).values():
            for place, value in zip(np.searchsorted(wanted, names).tolist(), said_of.tolist(), strict=True):
                found[place].add(value)
        return found


def parts_of(partition: str, numbers: np.ndarray, middles: np.ndarray, ranks: int) -> np.ndarray:
    """The rank of each cell: in strips across x, in blocks of x and y, or anywhere."""
    if partition == "random":
        # Knuth's multiplicative hash.
        return numbers * 2654435761 % 2**32 * ranks // 2**32
    rows = 2 if partition == "blocks" and ranks % 2 == 0 else 1
    across = np.clip((middles[:, 0] + 2.5) / 5 * (ranks // rows), 0, ranks // rows - 1).astype(np.int64)
    along = np.clip(middles[:, 1] / 2 * rows, 0, rows - 1).astype(np.int64)
    return rows * across + along
