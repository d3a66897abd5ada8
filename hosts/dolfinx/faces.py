"""Contact integrated over the slave's faces, on a distributed mesh: every rank computes the rows that it owns."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from contact import ADD, Nodes, Pattern
from dolfinx import fem
from exchange import Exchange
from petsc4py import PETSc
from surfaces import Facets, Part, boundary, meets

import diffuse_contact as dc

#: Faces stay cut while nothing has moved by more than this part of the smallest facet. It is half of what
#: ``FaceInterface`` allows, so that no rank decides by itself.
HELD = 5e-6


class FaceContact:
    """Contact over faces with the interface of ``Contact``.

    A pressure is an average over all faces at a node, and forces go to the nodes of faces and facets. So each rank has
    windows of both surfaces around its own nodes of either, and keeps the rows of these nodes: nothing of forces and
    tangent goes to another rank. What lies at a border is evaluated on both sides.

    Args:
        space: displacements.
        vector: one of them.
        master: whether points x, shape (3, n), are on the master surface.
        slave: the same of the slave surface.
        penalty: force per length³.
        limit: nothing farther away than this from a face is over it, length.
        skin: how far nodes may move until windows are made anew, length.
        friction: coefficient, or None.

    """

    #: Gaps are averages, which do not replace an unknown each: what preconditions the operator is assembled.
    preconditioned_by_matrix = True
    #: What the exact tangent is made of is held by the evaluation.
    mode_of_tangent = "hessian"

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
        #: Facets of cells of this rank, master and slave, and those around them.
        self.own = [boundary(space, is_on) for is_on in (master, slave)]
        self.parts = [Part(self.exchange, own) for own in self.own]
        self.around = [Nodes(part.blocks, part.positions, vector, self.exchange) for part in self.parts]
        self.kept = [self._owned(own) for own in self.own]
        self.slaves = self.kept[1][0]
        corners = np.concatenate([own.positions for own in self.own])
        sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
        self.smallest = -self.exchange.largest(-sides.min(initial=np.inf))
        #: No facet is wider along an axis, in the first configuration.
        self.largest = self.exchange.largest(np.ptp(corners, axis=1).max(initial=0.0))
        self.interface, self.nodes, self.renewals, self.history = None, None, 0, {}
        #: Whether friction has begun: an interface that is made later has a history of nodes that stick nowhere.
        self.slides = False
        self.cut_at = None
        self.held = vector.duplicate()
        #: Displacements at the end of the last increment: what slaves stuck to is there.
        self.accepted = vector.copy()
        self.renew(vector)

    def _owned(self, own: Facets) -> tuple[np.ndarray, Nodes]:
        """The nodes of this rank among the corners, which may all be of other ranks' cells."""
        at = {int(to): own[(own.owners == to).any(axis=1)].arrays for to in np.unique(own.owners)}
        found = [*self.exchange.to("slaves", at).values()]
        numbers, blocks, owners, positions, _ = (Facets.together(found) if found else own).by_node()
        mine = owners == self.exchange.comm.rank
        return numbers[mine], Nodes(blocks[mine], positions[mine], self.vector, self.exchange)

    @property
    def masters(self) -> int:
        """Nodes of the master that this rank knows."""
        return 0 if self.windows[0] is None else len(self.windows[0].nodes)

    @property
    def nbytes(self) -> int:
        """Bytes of surface that this rank holds: its parts and its windows."""
        windows = [array.nbytes for window in self.windows if window is not None for array in window.numbers]
        return sum(part.nbytes for part in self.parts) + sum(windows)

    @property
    def vector_bytes(self) -> int:
        """Bytes of a vector that come from other ranks in an evaluation: at nodes of the windows."""
        return self.nodes.nbytes + sum(nodes.nbytes for _, nodes in self.kept)

    def renew(self, u: PETSc.Vec) -> None:
        """Makes the windows anew, and the interface in them; histories are those that owners have."""
        # Rows of the own nodes take the pressures at all corners of the faces beside them, which take all faces there.
        wide = self._widest(u) + self.skin
        near = dc.boxes_around(self.watched(u), self.limit + self.skin + 2 * wide, 8)
        facets = self._faces_near(u, near)
        _, blocks, _, first, _ = facets.by_node()
        corners = Nodes(blocks, first, self.vector, self.exchange)
        boxes = dc.boxes_around(first, self.largest, 8)
        slave = self.parts[1].window(self.parts[1].positions, boxes, 0.0)
        # Also where slaves have stuck.
        points = np.concatenate([corners.positions(u), corners.positions(self.accepted)])
        corners.destroy()
        boxes = dc.boxes_around(points, 1.001 * self.limit + self.skin + wide, 8)
        master = self.parts[0].window(self.around[0].positions(u), boxes, self.skin)
        self.windows = [master[0], slave[0]]
        blocks, self.owners = (np.concatenate(both) for both in zip(master[1:], slave[1:], strict=True))
        nowhere = np.empty((0, 3))
        first = [nowhere if window is None else window.first_positions for window in self.windows]
        if self.nodes is not None:
            self.nodes.destroy()
        self.nodes = Nodes(blocks, np.concatenate(first), self.vector, self.exchange)
        self.first_slave = len(first[0])
        self.interface = None
        # Ranks without windows take part, too: others may need nodes of theirs.
        positions = self.nodes.positions(u)
        if all(window is not None for window in self.windows):
            self.interface = dc.FaceInterface.in_window(*self.windows, positions, distance_limit=self.limit)
            at = positions[self.interface.slaves]
            self.needed = meets(np.stack([at, at], axis=1)[:, np.newaxis], near).any(axis=1)
        self._gather_history()
        self.start, self.cut_at = self.watched(u), None
        self.renewals += 1

    def _widest(self, u: PETSc.Vec) -> float:
        """No facet is wider along an axis at these displacements: facets turn and stretch."""
        widest = 0.0
        for around, part, own in zip(self.around, self.parts, self.own, strict=True):
            corners = around.positions(u)[np.searchsorted(part.nodes, own.nodes)]
            widest = max(widest, np.ptp(corners, axis=1).max(initial=0.0))
        return self.exchange.largest(float(widest))

    def _faces_near(self, u: PETSc.Vec, boxes: np.ndarray) -> Facets:
        """The faces of the slave in these boxes at these displacements, from the ranks with their cells."""
        own = self.own[1]
        part, moved = self.parts[1], self.around[1].positions(u)
        corners = moved[np.searchsorted(part.nodes, own.nodes)]
        bounds = np.stack([corners.min(axis=1), corners.max(axis=1)], axis=1)
        messages = {}
        for rank, others in enumerate(self.exchange.gather("boxes", boxes)):
            near = meets(bounds[:, np.newaxis], others).any(axis=1)
            if near.any():
                messages[rank] = own[near].arrays
        found = [*self.exchange.to("windows", messages).values()]
        return Facets.together(found) if found else own[:0]

    def _gather_history(self) -> None:
        """Takes over the histories of the nodes here from the ranks that own them."""
        nodes = np.empty(0, dtype=np.int64) if self.interface is None else self.interface.slaves
        numbers = self._numbers(nodes)
        owners = self.owners[nodes]
        by_owner = {int(rank): (np.unique(numbers[owners == rank]),) for rank in np.unique(owners)}
        asked = self.exchange.to("history", by_owner)
        answers = {}
        for rank, (wanted,) in asked.items():
            known = [number for number in wanted.tolist() if number in self.history]
            if known:
                pairs = [(number, row) for number in known for row in self.history[number]]
                lengths = np.array([len(row) for _, row in pairs])
                of_rows = np.array([number for number, _ in pairs])
                answers[rank] = (of_rows, lengths, np.concatenate([row for _, row in pairs]))
        found = {}
        for of_rows, lengths, values in self.exchange.to("history", answers).values():
            rows = np.split(values, np.cumsum(lengths)[:-1])
            self._by_number(of_rows, rows, found)
        if self.slides and self.interface is not None:
            nothing = np.array([-1.0, -1.0])
            rest = {number: iter(rows) for number, rows in found.items()}
            own = [next(rest.get(number, iter(())), nothing) for number in numbers.tolist()]
            self.interface.history = np.concatenate(own)

    @staticmethod
    def _by_number(numbers: np.ndarray, rows: Iterable[np.ndarray], found: dict[int, list[np.ndarray]]) -> None:
        """A node on a sharp edge has a row for each sheet, in the same order wherever all faces at it are known."""
        for number, row in zip(numbers.tolist(), rows, strict=True):
            found.setdefault(number, []).append(row)

    def _numbers(self, nodes: np.ndarray) -> np.ndarray:
        """Of nodes of the slave in the input."""
        return nodes if self.interface is None else self.windows[1].nodes[nodes - self.first_slave]

    def watched(self, u: PETSc.Vec) -> np.ndarray:
        """Positions of the own nodes of either surface: on all ranks together, of everybody."""
        return np.concatenate([nodes.positions(u) for _, nodes in self.kept])

    def evaluate(self, u: PETSc.Vec, mode: str) -> None:
        """Evaluates at these displacements. Raises on all ranks if a node that counts cannot know its result."""
        self._follow(u)
        beyond = 0
        if self.interface is not None:
            outcomes = self.interface.evaluate(**self.law, mode=mode).outcomes
            beyond = sum(outcomes[k] == "beyond-window" for k in np.flatnonzero(self.needed).tolist())
        beyond = self.exchange.largest(float(beyond))
        if beyond > 0:
            raise RuntimeError(f"{beyond:.0f} nodes of one rank reach beyond their windows")

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
        positions = self.nodes.positions(u)
        if self.interface is not None:
            (self.interface.refresh if cuts else self.interface.update)(positions)

    def accept(self, u: PETSc.Vec) -> None:
        """The end of an increment: friction of the next one begins here."""
        u.copy(self.accepted)
        if "friction" in self.law:
            self._follow(u)
            self.history, self.slides = {}, True
            if self.interface is not None:
                self.interface.accept(**self.law)
                # Two points of each node.
                parts = dc.split_history(self.interface.history)
                rows = map(np.concatenate, zip(parts[::2], parts[1::2], strict=True))
                self._by_number(self._numbers(self.interface.slaves), rows, self.history)

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

    def linearise(self, u: PETSc.Vec, which: str) -> None:
        """Makes the tangent at these displacements an operator, for ``add_product``."""
        self.evaluate(u, "hessian")
        self.free, self.which = 1.0 - self.nodes.bring(self.held).reshape(-1), which

    def add_product(self, v: PETSc.Vec, out: PETSc.Vec) -> None:
        """Adds the tangent times a vector: its values come from neighbours, and each rank has the rows of its nodes."""
        v = self.free * self.nodes.bring(v).reshape(-1)
        if self.interface is not None:
            kept = self._kept_rows()
            product = (self.interface.product(v, self.which) * self.free)[kept]
            out.setValues(self.nodes.equations[kept], product, addv=ADD)
        out.assemble()

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
        """What the own slaves have: numbers, forces, and average gaps, pressures and friction.

        On a sharp edge they are those of the sheet that presses most.
        """
        found = {"slaves": self.slaves, "slave_forces": np.zeros((len(self.slaves), 3)), "contacts": []}
        if self.interface is None:
            return found
        place = self.first_slave + np.searchsorted(self.windows[1].nodes, self.slaves)
        found["slave_forces"] = self.interface.forces().reshape(-1, 3)[place]
        contacts = self.interface.contacts
        first, last = (np.searchsorted(self.interface.slaves, place, side) for side in ("left", "right"))
        sheets = zip(first.tolist(), last.tolist(), strict=True)
        rows = np.array([a + int(contacts.pressure[a:b].argmax()) for a, b in sheets], dtype=int)
        fields = contacts.gap[rows], contacts.pressure[rows], contacts.friction[rows]
        states = [contacts.friction_states[row] for row in rows.tolist()]
        found["contacts"] = list(zip(*fields, states, strict=True))
        return found

    def is_changed(self) -> bool:
        """The tangent couples what carries pressure, at every iteration."""
        return True
