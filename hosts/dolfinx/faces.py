"""Contact integrated over the slave's faces, on a distributed mesh: every rank computes the rows that it owns."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from contact import ADD, Nodes, Pattern
from dolfinx import fem
from exchange import Exchange
from petsc4py import PETSc
from surfaces import Facets, boundary, meets

import diffuse_contact as dc

#: How far a rank knows both surfaces around its own nodes beyond the limit of the distance, in facets: averages and
#: pressures of neighbours take two, the fits of either side three, and the fits that those depend on three.
HALO = 8
#: Faces stay cut while nothing has moved by more than this part of the smallest facet. It is half of what
#: ``FaceInterface`` allows, so that no rank decides by itself.
HELD = 5e-6


class FaceContact:
    """Contact over faces with the interface of ``Contact``.

    A pressure is an average over all faces at a node, and forces go to the nodes of faces and facets. So each rank
    makes a ``FaceInterface`` of all faces and facets near its own nodes of either surface, and keeps the rows of these
    nodes: nothing of forces and tangent goes to another rank. What lies at a border is evaluated on both sides.

    Args:
        space: displacements.
        vector: one of them.
        master: whether points x, shape (3, n), are on the master surface.
        slave: the same of the slave surface.
        penalty: force per length³.
        limit: nothing farther away than this from a face is over it, length.
        skin: how far nodes may move until surfaces are gathered anew, length.
        friction: coefficient, or None.

    """

    def __init__(
        self,
        space: fem.FunctionSpace,
        vector: PETSc.Vec,
        master: Callable[[np.ndarray], np.ndarray],
        slave: Callable[[np.ndarray], np.ndarray],
        *,
        penalty: float,
        limit: float,
        skin: float,
        friction: float | None = None,
    ) -> None:
        self.exchange = Exchange(space.mesh.comm)
        self.vector, self.skin, self.limit = vector, skin, limit
        self.law = {"penalty": penalty} if friction is None else {"penalty": penalty, "friction": friction}
        #: Facets of cells of this rank, master and slave.
        self.own = [boundary(space, is_on) for is_on in (master, slave)]
        self.around = [Nodes(blocks, first, vector) for _, blocks, _, first, _ in (own.by_node() for own in self.own)]
        self.kept = [self._owned(own) for own in self.own]
        self.slaves = self.kept[1][0]
        corners = np.concatenate([own.positions for own in self.own])
        sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
        self.smallest = -self.exchange.largest(-sides.min(initial=np.inf))
        self.largest = self.exchange.largest(np.ptp(corners, axis=1).max(initial=0.0))
        self.interface, self.renewals, self.history = None, 0, {}
        self.cut_at = None
        self.held = vector.duplicate()
        self.renew(vector)

    def _owned(self, own: Facets) -> tuple[np.ndarray, Nodes]:
        """The nodes of this rank among the corners, which may all be of other ranks' cells."""
        at = {int(to): own[(own.owners == to).any(axis=1)].arrays for to in np.unique(own.owners)}
        found = [*self.exchange.to("surface", at).values()]
        numbers, blocks, owners, positions, _ = (Facets.together(found) if found else own).by_node()
        mine = owners == self.exchange.comm.rank
        return numbers[mine], Nodes(blocks[mine], positions[mine], self.vector)

    @property
    def masters(self) -> int:
        """Nodes of the master that this rank knows."""
        return len(np.unique(self.facets[0].nodes))

    @property
    def nbytes(self) -> int:
        """Bytes of surface that this rank holds."""
        return sum(array.nbytes for facets in (*self.own, *self.facets) for array in facets.arrays)

    def renew(self, u: PETSc.Vec) -> None:
        """Gathers what is near the own nodes of either surface; histories are those that owners have."""
        exchange = self.exchange
        points = np.concatenate([nodes.positions(u) for _, nodes in self.kept])
        reach = self.limit + self.skin + HALO * self.largest
        boxes = exchange.gather("boxes", dc.boxes_around(points, reach, 8))
        self.facets = []
        for own, nodes in zip(self.own, self.around, strict=True):
            moved = nodes.positions(u)[own.by_node()[4]]
            bounds = np.stack([moved.min(axis=1), moved.max(axis=1)], axis=1)
            messages = {}
            for rank, others in enumerate(boxes):
                near = meets(bounds[:, np.newaxis], others).any(axis=1)
                if near.any():
                    messages[rank] = own[near].arrays
            found = [*exchange.to("windows", messages).values()]
            self.facets.append(Facets.together(found) if found else own[:0])
        self._gather_history()
        both = Facets.together([facets.arrays for facets in self.facets])
        self.names, blocks, self.owners, first, _ = both.by_node()
        self.nodes = Nodes(blocks, first, self.vector)
        self.interface = None
        if all(len(facets.numbers) for facets in self.facets):
            master, slave = (np.searchsorted(self.names, facets.nodes) for facets in self.facets)
            surface = dc.MasterSurface(first, master)
            self.interface = dc.FaceInterface(surface, slave, first, distance_limit=self.limit)
            if self.history:
                self.interface.history = self._own_history()
        self.start, self.cut_at = self.watched(u), None
        self.renewals += 1

    def _gather_history(self) -> None:
        """Histories of the slaves that this rank knows, by their numbers in the input, from the ranks that own them."""
        _, first = np.unique(self.facets[1].nodes, return_index=True)
        numbers, owners = (array.reshape(-1)[first] for array in (self.facets[1].nodes, self.facets[1].owners))
        asked = self.exchange.to("history", {int(rank): (numbers[owners == rank],) for rank in np.unique(owners)})
        answers = {}
        for rank, (wanted,) in asked.items():
            rows = [self.history[number] for number in wanted.tolist() if number in self.history]
            if rows:
                answers[rank] = (wanted, np.array([len(row) for row in rows]), np.concatenate(rows))
        self.history = {}
        for wanted, lengths, numbers in self.exchange.to("history", answers).values():
            rows = np.split(numbers, np.cumsum(lengths)[:-1])
            self.history.update(zip(wanted.tolist(), rows, strict=True))

    def _own_history(self) -> np.ndarray:
        """The history of all slaves here, with nodes as they are numbered here."""
        nothing = np.array([-1.0, -1.0])
        rows = [self.history.get(number, nothing).copy() for number in self.names[self.interface.slaves].tolist()]
        for row in rows:
            _rename(row, self._place)
        return np.concatenate(rows)

    def _place(self, numbers: np.ndarray) -> np.ndarray:
        place = np.searchsorted(self.names, numbers)
        if not np.array_equal(self.names[np.minimum(place, len(self.names) - 1)], numbers):
            raise RuntimeError(f"rank {self.exchange.comm.rank} does not know all nodes that its slaves stuck to")
        return place

    def watched(self, u: PETSc.Vec) -> np.ndarray:
        """Positions of the own nodes of either surface: on all ranks together, of everybody."""
        return np.concatenate([nodes.positions(u) for _, nodes in self.kept])

    def evaluate(self, u: PETSc.Vec, mode: str) -> None:
        """Evaluates at these displacements."""
        self._follow(u)
        if self.interface is not None:
            self.interface.evaluate(**self.law, mode=mode)

    def _follow(self, u: PETSc.Vec) -> None:
        """Takes over positions. Faces are cut anew on all ranks or on none."""
        watched = self.watched(u)

        def moved(since: np.ndarray) -> float:
            return self.exchange.largest(np.sqrt(((watched - since) ** 2).sum(axis=1)).max(initial=0.0))

        way = moved(self.start)
        if np.isnan(way):
            raise ValueError("a displacement is not a number")
        if way > self.skin / 2:
            self.renew(u)
        cuts = self.cut_at is None or moved(self.cut_at) > HELD * self.smallest
        if cuts:
            self.cut_at = watched
        if self.interface is not None:
            positions = self.nodes.positions(u)
            (self.interface.refresh if cuts else self.interface.update)(positions)

    def accept(self, u: PETSc.Vec) -> None:
        """The end of an increment: friction of the next one begins here."""
        if "friction" in self.law:
            self._follow(u)
            self.history = {}
            if self.interface is not None:
                self.interface.accept(**self.law)
                # Two points of each slave.
                parts = dc.split_history(self.interface.history)
                rows = map(np.concatenate, zip(parts[::2], parts[1::2], strict=True))
                self.history = dict(zip(self.names[self.interface.slaves].tolist(), rows, strict=True))
                for row in self.history.values():
                    _rename(row, lambda names: self.names[names])

    def _kept_rows(self) -> np.ndarray:
        return np.repeat(self.owners == self.exchange.comm.rank, 3)

    def add_forces(self, forces: PETSc.Vec) -> None:
        """Adds the contact forces on the nodes of this rank."""
        if self.interface is not None:
            kept = self._kept_rows()
            forces.setValues(self.nodes.equations[kept], self.interface.forces()[kept], addv=ADD)
        forces.assemble()

    def add_tangent(self, matrix: PETSc.Mat, which: str) -> None:
        """Adds the rows of this rank of the contact tangent, ``"exact"`` or ``"gauss-newton"``."""
        free = 1.0 - self.nodes.bring(self.held).reshape(-1)
        if self.interface is not None:
            kept = self._kept_rows()
            tangent, equations = self.interface.tangent(which)[kept], self.nodes.equations
            values = tangent.data * free[tangent.indices] * np.repeat(free[kept], np.diff(tangent.indptr))
            rows = tangent.indptr.astype(PETSc.IntType)
            matrix.setValuesIJV(rows, equations[tangent.indices], values, addv=ADD, rowmap=equations[kept])
        matrix.assemble()

    def union(self, solids: Pattern) -> PETSc.Mat:
        """An empty matrix with room for the solids and for the nodes that carry pressure at the last positions."""
        blocks = []
        if self.interface is not None:
            self.interface.evaluate(**self.law, mode="hessian")
            kept = self._kept_rows()
            tangent = self.interface.tangent("exact").tocoo()
            pairs = np.stack([tangent.row[kept[tangent.row]], tangent.col[kept[tangent.row]]]) // 3
            numbers = self.nodes.equations[::3] // 3
            blocks.append(tuple(numbers[np.unique(pairs, axis=1)]))
        return solids.with_blocks(blocks)

    def gaps(self) -> list:
        """None: the gaps of nodes are averages."""
        return []

    def results(self) -> dict:
        """What the own slaves have: numbers, forces, and average gaps, pressures and friction."""
        found = {"slaves": self.slaves, "slave_forces": np.zeros((len(self.slaves), 3)), "contacts": []}
        if self.interface is None:
            return found
        place = np.searchsorted(self.names, self.slaves)
        found["slave_forces"] = self.interface.forces().reshape(-1, 3)[place]
        contacts, rows = self.interface.contacts, np.searchsorted(self.interface.slaves, place)
        fields = contacts.gap[rows], contacts.pressure[rows], contacts.friction[rows]
        states = [contacts.friction_states[row] for row in rows.tolist()]
        found["contacts"] = list(zip(*fields, states, strict=True))
        return found

    def is_changed(self) -> bool:
        """The tangent couples what carries pressure, at every iteration."""
        return True


def _rename(numbers: np.ndarray, names: Callable[[np.ndarray], np.ndarray]) -> None:
    """Gives the nodes in a history other numbers: see ``FaceInterface.history``."""
    place = 0
    while place < len(numbers):
        if numbers[place] == -1.0:
            place += 1
            continue
        count = int(numbers[place])
        nodes = numbers[place + 2 : place + 2 + 3 * count : 3]
        nodes[:] = names(nodes.astype(np.int64))
        place += 2 + 3 * count
