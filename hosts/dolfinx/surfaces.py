"""Surfaces of a distributed mesh by the numbers of its input, and the parts that ranks hold of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from compat import nodes_of_cells, owners
from dolfinx import fem, mesh
from exchange import Exchange
from scene import CORNERS

import diffuse_contact as dc


@dataclass
class Facets:
    """Facets of a surface. All arrays but ``numbers`` have shape (f, 4, …), by corner.

    A facet's number is six times that of its cell in the input, plus its own in the cell, and corners begin with the
    same one everywhere: so numbers and orders do not depend on the number of ranks.
    """

    numbers: np.ndarray
    #: Numbers of nodes in the input.
    nodes: np.ndarray
    #: Global numbers of their blocks of unknowns, and the ranks that own these.
    blocks: np.ndarray
    owners: np.ndarray
    #: First positions, length.
    positions: np.ndarray

    def __getitem__(self, which: np.ndarray) -> Facets:
        return Facets(*(array[which] for array in self.arrays))

    @property
    def arrays(self) -> tuple[np.ndarray, ...]:
        """To be sent."""
        return self.numbers, self.nodes, self.blocks, self.owners, self.positions

    @staticmethod
    def together(parts: list[tuple[np.ndarray, ...]]) -> Facets:
        """Those of several ranks, by ascending number, each once."""
        joined = [np.concatenate(arrays) for arrays in zip(*parts, strict=True)]
        _, order = np.unique(joined[0], return_index=True)
        return Facets(*(array[order] for array in joined))

    def by_node(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Each node once, by ascending number: numbers, blocks, owners, positions; and the corners by place."""
        numbers, first, places = np.unique(self.nodes, return_index=True, return_inverse=True)
        flat = (array.reshape(-1, *array.shape[2:])[first] for array in (self.blocks, self.owners, self.positions))
        return (numbers, *flat, places.reshape(-1, 4))


def boundary(space: fem.FunctionSpace, is_on: object) -> Facets:
    """The facets of the boundary, of cells of this rank, whose vertices all satisfy ``is_on(x)``, x of shape (3, n)."""
    domain, index_map = space.mesh, space.dofmap.index_map
    topology = domain.topology
    topology.create_connectivity(2, 3)
    topology.create_connectivity(3, 2)
    own = topology.index_map(3).size_local
    found = mesh.locate_entities_boundary(domain, 2, is_on)
    pairs = [(topology.connectivity(2, 3).links(facet)[0], facet) for facet in found]
    pairs = [(cell, facet) for cell, facet in pairs if cell < own]
    cells = np.array([cell for cell, _ in pairs], dtype=np.int64)
    local = [np.flatnonzero(topology.connectivity(3, 2).links(cell) == facet)[0] for cell, facet in pairs]
    local = np.array(local, dtype=np.int64)
    nodes, blocks, positions = nodes_of_cells(domain, space, own)
    rows, columns = cells[:, np.newaxis], CORNERS[local].reshape(-1, 4)
    blocks = blocks[rows, columns]
    numbers = 6 * np.asarray(topology.original_cell_index, dtype=np.int64)[cells] + local
    everywhere = index_map.local_to_global(np.arange(index_map.size_local + index_map.num_ghosts, dtype=np.int32))
    positions = positions[rows, columns]
    facets = Facets(numbers, nodes[rows, columns], everywhere[blocks], owners(space)[blocks], positions)
    return facets[np.argsort(numbers)]


def input_numbers(space: fem.FunctionSpace) -> np.ndarray:
    """Numbers in the input of the nodes that this rank owns, by block of unknowns."""
    cells = space.mesh.topology.index_map(3)
    nodes, blocks, _ = nodes_of_cells(space.mesh, space, cells.size_local + cells.num_ghosts)
    index_map = space.dofmap.index_map
    numbers = np.empty(index_map.size_local + index_map.num_ghosts, dtype=np.int64)
    numbers[blocks] = nodes
    return numbers[: index_map.size_local]


def meets(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Which boxes of (…, 2, 3) meet one another."""
    return ((one[..., 0, :] <= other[..., 1, :]) & (other[..., 0, :] <= one[..., 1, :])).all(axis=-1)


class Part:
    """The master facets that this rank owns and those around them. Windows are cut out of it."""

    def __init__(self, exchange: Exchange, own: Facets) -> None:
        self.exchange, self.own, self.part = exchange, own, None
        _, _, _, positions, corners = own.by_node()
        extents = dc.Extents.of(positions, corners)
        rows = exchange.gather("boxes", np.array([*extents.low, *extents.high, extents.facet]))
        rows = np.array(rows)
        self.boxes = rows[:, :6].reshape(-1, 2, 3)
        extents = dc.Extents(tuple(rows[:, :3].min(axis=0)), tuple(rows[:, 3:6].max(axis=0)), rows[:, 6].max())
        width = 8 * extents.facet
        while not self._settle(width, extents):
            width *= 1.5

    def _settle(self, width: float, extents: dc.Extents) -> bool:
        """Takes in what lies around the own facets; whether that was wide enough on all ranks."""
        exchange = self.exchange
        known = self.boxes + width * np.array([[-1.0], [1.0]])
        low, high = self.own.positions.min(axis=1), self.own.positions.max(axis=1)
        bounds = np.stack([low, high], axis=1)
        messages = {}
        for rank in np.flatnonzero(meets(known[exchange.comm.rank], known)):
            near = meets(bounds, known[rank])
            if near.any():
                messages[int(rank)] = self.own[near].arrays
        parts = [*exchange.to("surface", messages).values()]
        self.facets = Facets.together(parts) if parts else self.own
        self.nodes, self.blocks, self.owners, self.positions, corners = self.facets.by_node()
        #: Which nodes are corners of own facets.
        self.corners = np.isin(self.nodes, self.own.nodes)
        self.part, is_wide = None, True
        if len(self.own.numbers):
            try:
                self.part = dc.SurfacePart(
                    self.positions,
                    corners,
                    node_numbers=self.nodes,
                    facet_numbers=self.facets.numbers,
                    owned=np.isin(self.facets.numbers, self.own.numbers),
                    known=known[exchange.comm.rank],
                    extents=extents,
                )
            except dc.InterfaceError as error:
                if error.code != "part-too-narrow":
                    raise
                is_wide = False
        if exchange.largest(float(not is_wide)) > 0:
            return False
        beside = np.flatnonzero(meets(known[exchange.comm.rank], known))
        # Rounds are the same on all ranks; those without facets have nothing to say in them.
        is_settled = False
        while not is_settled:
            demands, is_settled = (), True
            if self.part is not None:
                own = self.part.demands
                demands = (own.nodes, own.factors, own.crowded, own.facets, own.bases)
            found = exchange.to("demands", {int(rank): demands for rank in beside} if demands else {})
            try:
                if self.part is not None:
                    is_settled = self.part.settle([dc.PartDemands(*arrays) for arrays in found.values()])
            except dc.InterfaceError as error:
                if error.code != "part-too-narrow":
                    raise
                is_wide = False
            if exchange.largest(float(not is_wide)) > 0:
                return False
            is_settled = exchange.largest(float(not is_settled)) == 0
        return True

    @property
    def nbytes(self) -> int:
        """Bytes of the facets that this rank knows."""
        return sum(array.nbytes for array in self.facets.arrays)

    def window(
        self, moved: np.ndarray, boxes: np.ndarray, skin: float
    ) -> tuple[dc.Window | None, np.ndarray, np.ndarray]:
        """The window for the slaves of this rank, with blocks and owners of its nodes; None if no facet is near.

        Args:
            moved: present positions of ``nodes``; those of the corners of own facets are looked at.
            boxes: around the slaves of this rank.
            skin: of the window.

        """
        exchange = self.exchange
        everywhere = exchange.gather("boxes", boxes)
        messages = {}
        if self.part is not None:
            own = moved[self.corners]
            bounds = np.array([own.min(axis=0) - skin, own.max(axis=0) + skin])
            for rank, others in enumerate(everywhere):
                if meets(bounds, others).any():
                    window = self.part.window(moved, others, skin)
                    place = np.searchsorted(self.nodes, window.nodes)
                    if len(window.facets):
                        messages[rank] = (*window.numbers, self.blocks[place], self.owners[place])
        found = [*exchange.to("windows", messages).values()]
        windows = [dc.Window(integers, reals) for integers, reals, *_ in found]
        if not windows:
            return None, np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
        joined = dc.Window.joined(windows)
        blocks, ranks = np.empty(len(joined.nodes), dtype=np.int64), np.empty(len(joined.nodes), dtype=np.int64)
        for window, (*_, own, of) in zip(windows, found, strict=True):
            place = np.searchsorted(joined.nodes, window.nodes)
            blocks[place], ranks[place] = own, of
        return joined, blocks, ranks
