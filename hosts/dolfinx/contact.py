"""Contact on a distributed mesh: no rank holds the whole surface."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np
import scipy.sparse
from dolfinx import fem
from exchange import Exchange
from petsc4py import PETSc
from surfaces import Facets, Part, boundary

import diffuse_contact as dc

ADD = PETSc.InsertMode.ADD_VALUES
INSERT = PETSc.InsertMode.INSERT_VALUES
FORWARD = PETSc.ScatterMode.FORWARD
REVERSE = PETSc.ScatterMode.REVERSE
#: How far from the edge between stick and slip a contact counts as beside it, over μ p.
EDGE = 1e-9


class Nodes:
    """Nodes wherever they are owned, and a scatter that brings their displacements here from their neighbours."""

    def __init__(self, blocks: np.ndarray, positions: np.ndarray, vector: PETSc.Vec, exchange: Exchange) -> None:
        self.first, self.exchange = positions, exchange
        self.equations = (3 * blocks[:, np.newaxis] + np.arange(3)).reshape(-1).astype(PETSc.IntType)
        self.values = PETSc.Vec().createSeq(len(self.equations))
        source = PETSc.IS().createGeneral(self.equations, comm=PETSc.COMM_SELF)
        self.scatter = PETSc.Scatter().create(vector, source, self.values, None)
        source.destroy()
        first, last = vector.getOwnershipRange()
        self.nbytes = self.values.array_r.itemsize * int(((self.equations < first) | (self.equations >= last)).sum())

    def destroy(self) -> None:
        """Gives the scatter back, on all ranks: what Python alone forgets, PETSc keeps."""
        self.scatter.destroy()
        self.values.destroy()

    def bring(self, vector: PETSc.Vec) -> np.ndarray:
        """What the vector has for these nodes, shape (n, 3)."""
        self.scatter.scatter(vector, self.values, addv=INSERT, mode=FORWARD)
        self.exchange.received["vectors"] += self.nbytes
        return self.values.array_r.reshape(-1, 3).copy()

    def positions(self, vector: PETSc.Vec) -> np.ndarray:
        """Present positions."""
        return self.first + self.bring(vector)

    def add(self, values: np.ndarray, vector: PETSc.Vec) -> None:
        """Adds numbers for these nodes, shape (3n,), where they are owned."""
        self.values.array_w[:] = values
        self.scatter.scatter(self.values, vector, addv=ADD, mode=REVERSE)


class Pattern(NamedTuple):
    """The entries of the solids' matrix: rows of this rank, global columns."""

    indptr: np.ndarray
    columns: np.ndarray
    first: int
    size: int
    maps: tuple[PETSc.LGMap, PETSc.LGMap]
    comm: PETSc.Comm

    @staticmethod
    def of(matrix: PETSc.Mat) -> Pattern:
        """Of an assembled matrix."""
        indptr, columns, _ = matrix.getValuesCSR()
        first, size = matrix.getOwnershipRange()[0], matrix.getSize()[0]
        return Pattern(indptr, columns, first, size, matrix.getLGMap(), matrix.comm)

    def with_blocks(self, blocks: Iterable[tuple[np.ndarray, np.ndarray]]) -> PETSc.Mat:
        """An empty matrix that has room for these blocks of 3 × 3, too: rows of this rank, and columns."""
        count = len(self.indptr) - 1
        rows, columns = [np.repeat(np.arange(count), np.diff(self.indptr))], [self.columns]
        axes = np.arange(3)
        for row, column in blocks:
            rows.append((3 * row[:, np.newaxis, np.newaxis] + axes[:, np.newaxis] + 0 * axes).reshape(-1) - self.first)
            columns.append((3 * column[:, np.newaxis, np.newaxis] + axes + 0 * axes[:, np.newaxis]).reshape(-1))
        rows, columns = np.concatenate(rows), np.concatenate(columns)
        shape = (count, self.size)
        pattern = scipy.sparse.csr_matrix((np.ones(len(rows), dtype=np.int8), (rows, columns)), shape=shape)
        pattern.sum_duplicates()
        indptr, indices = (array.astype(PETSc.IntType) for array in (pattern.indptr, pattern.indices))
        csr, sizes = (indptr, indices, np.zeros(len(indices))), (count, self.size)
        made = PETSc.Mat().createAIJ((sizes, sizes), bsize=3, csr=csr, comm=self.comm)
        made.setLGMap(*self.maps)
        # An entry that has no room is an error, and not left out.
        made.setOption(PETSc.Mat.Option.NEW_NONZERO_LOCATION_ERR, True)
        return made


class Gap(NamedTuple):
    """The gap of a slave that carries force: its change is ``(gradient * v[equations]).sum()``."""

    #: The rank that owns the slave.
    owner: int
    #: The axis that the slave's normal is closest to.
    axis: int
    #: Of the slave and its masters, shape (1 + m, 3).
    equations: np.ndarray
    #: N, 0 in equations with given displacements.
    gradient: np.ndarray
    #: ε times the area, force per length.
    stiffness: float


def carriers_of(row: np.ndarray) -> np.ndarray:
    """The numbers of the nodes that a slave sticks to, from its part of a history: of its origin and its anchor."""
    origin = row[:0]
    if row[0] == -2.0:
        origin, row = np.split(row[2:], [3 * int(row[1])])
    return np.concatenate([origin, row[2:]])[::3].astype(np.int64)


@contextmanager
def beside_the_edge(contact: Contact) -> Iterator[None]:
    """Takes the coefficient of friction a little less than it is, for the first tangent of an increment.

    Slaves that slid in the last one are on the edge between stick and slip then, and rounding would say which. So they
    slide on any number of ranks.
    """
    law = contact.law
    if "friction" in law:
        contact.law = {**law, "friction": law["friction"] * (1.0 - EDGE)}
    try:
        yield
    finally:
        contact.law = law


class Contact:
    """Some slaves, which need not be nodes of this rank, and the window of the master that they can need.

    Slaves are dealt out evenly. Windows are made anew when a node of either surface has moved by half the skin.

    Args:
        space: displacements.
        vector: one of them.
        master: whether points x, shape (3, n), are on the master surface.
        slave: the same of the slave surface.
        penalty: force per length³.
        limit: slaves farther away than this from the master have no contact, length.
        skin: how far nodes may move beyond what windows hold, length.
        friction: coefficient, or None.

    """

    #: In gaps the penalty is a diagonal: what preconditions the operator needs no matrix of contact.
    preconditioned_by_matrix = False
    #: What is evaluated before a tangent is assembled: M is evaluated where it is added, and not held.
    mode_of_tangent = "gradient"

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
        self.part = Part(self.exchange, boundary(space, master))
        self.around = Nodes(self.part.blocks, self.part.positions, vector, self.exchange)
        self._take_slaves(boundary(space, slave))
        self.interface, self.nodes, self.renewals = None, None, 0
        #: 1 in the equations with given displacements, in which contact has no rows and columns.
        self.held = vector.duplicate()
        #: Displacements at the end of the last increment.
        self.accepted = vector.copy()
        #: What slaves stuck to then, as numbers; of slaves that stick nowhere until friction has begun.
        self.history = np.empty(0)
        self.renew(vector)

    def _take_slaves(self, own: Facets) -> None:
        """Gives every rank its share of the slaves, with all facets at them."""
        exchange, rank = self.exchange, self.exchange.comm.rank
        # First to the owner of each corner, which then knows all facets at its nodes.
        at = {int(to): own[(own.owners == to).any(axis=1)].arrays for to in np.unique(own.owners)}
        found = [*exchange.to("slaves", at).values()]
        facets = Facets.together(found) if found else own
        numbers, _, owners, positions, _ = facets.by_node()
        mine, positions = numbers[owners == rank], positions[owners == rank]
        # Neighbours stay together: along the longest side.
        axis = np.argmax(np.ptp(positions, axis=0)) if len(mine) else 0
        mine = mine[np.lexsort((mine, positions[:, axis]))]
        counts = np.concatenate(exchange.gather("boxes", np.array([len(mine)])))
        share = (counts[:rank].sum() + np.arange(len(mine))) * exchange.comm.size // max(counts.sum(), 1)
        shares = {int(to): mine[share == to] for to in np.unique(share)}
        shares = {to: (names, *facets[np.isin(facets.nodes, names).any(axis=1)].arrays) for to, names in shares.items()}
        found = [*exchange.to("slaves", shares).values()]
        self.facets = Facets.together([arrays[1:] for arrays in found]) if found else own[:0]
        names = np.concatenate([arrays[0] for arrays in found]) if found else mine[:0]
        numbers, blocks, owners, positions, corners = self.facets.by_node()
        # Slaves first, then the other corners of their facets, which areas need.
        order = np.argsort(~np.isin(numbers, names), kind="stable")
        place = np.argsort(order)
        self.slaves, self.corners = numbers[order][: len(names)], place[corners]
        self.slave_blocks, self.slave_owners = blocks[order], owners[order]
        self.slave_nodes = Nodes(blocks[order], positions[order], self.vector, exchange)

    @property
    def masters(self) -> int:
        """Nodes of the window."""
        return len(self.names)

    @property
    def nbytes(self) -> int:
        """Bytes of surface that this rank holds: its part and its window."""
        window = 0 if self.window is None else sum(array.nbytes for array in self.window.numbers)
        return self.part.nbytes + sum(array.nbytes for array in self.facets.arrays) + window

    @property
    def vector_bytes(self) -> int:
        """Bytes of a vector that come from other ranks in an evaluation: of the window, the part and the slaves."""
        return self.nodes.nbytes + self.slave_nodes.nbytes + self.around.nbytes

    def renew(self, u: PETSc.Vec) -> None:
        """Makes the window anew, and the interface in it; histories go with their slaves."""
        moved = self.around.positions(u)
        slaves, accepted = (self.slave_nodes.positions(at)[: len(self.slaves)] for at in (u, self.accepted))
        points = np.vstack([slaves, accepted, self._anchors(u)])
        boxes = dc.boxes_around(points, 1.001 * self.limit + self.skin, 8)
        self.window, blocks, owners = self.part.window(moved, boxes, self.skin)
        self.interface = None
        if self.window is None:
            # No facet is near: nothing to evaluate, and nothing to add.
            first, self.names = np.empty((0, 3)), np.empty(0, dtype=np.int64)
        else:
            first, self.names = self.window.first_positions, self.window.nodes
        blocks, first_of_all = np.concatenate([blocks, self.slave_blocks]), np.vstack([first, self.slave_nodes.first])
        if self.nodes is not None:
            self.nodes.destroy()
        self.nodes = Nodes(blocks, first_of_all, self.vector, self.exchange)
        self.owners = np.concatenate([owners, self.slave_owners])
        self.start, self._free = self.watched(u), None
        # Ranks without a window take part, too: others may need nodes of theirs.
        positions, before = self.nodes.positions(u), self.nodes.positions(self.accepted)
        if self.window is not None:
            # Slaves where they were in the beginning: areas are those of the first configuration.
            made = np.vstack([positions[: len(first)], self.slave_nodes.first])
            self.interface = dc.ContactInterface.in_window(
                self.window,
                len(first) + np.arange(len(self.slaves)),
                made,
                slave_facets=len(first) + self.corners,
                distance_limit=self.limit,
            )
            if len(self.history):
                self.interface.history = self.history
            # A slave stays on the side that it had at the end of the last increment.
            self.interface.refresh_pairing(before)
            self.interface.follow(positions)
        self.renewals += 1
        self.changed = True

    def _anchors(self, u: PETSc.Vec) -> np.ndarray:
        """Where the nodes are now that slaves stuck to at the end of the last increment, shape (n, 3)."""
        if self.nodes is None:
            return np.empty((0, 3))
        positions = self.nodes.positions(u)
        if self.interface is None or not len(self.history):
            return np.empty((0, 3))
        numbers = np.concatenate([carriers_of(row) for row in dc.split_history(self.history)])
        return positions[np.flatnonzero(np.isin(self.names, numbers))]

    def evaluate(self, u: PETSc.Vec, mode: str) -> None:
        """Evaluates at these displacements. Raises on all ranks if a slave cannot know its result."""
        positions = self.nodes.positions(u)
        moved = np.sqrt(((self.watched(u) - self.start) ** 2).sum(axis=1)).max(initial=0.0)
        moved = self.exchange.largest(moved)
        if np.isnan(moved):
            raise ValueError("a displacement is not a number")
        if moved > self.skin / 2:
            self.renew(u)
        elif self.interface is not None:
            self.changed |= self.interface.follow(positions)
        beyond = self.exchange.largest(float(self.evaluate_here(mode)))
        if beyond > 0:
            raise RuntimeError(f"{beyond:.0f} slaves of one rank reach beyond their window")

    def watched(self, u: PETSc.Vec) -> np.ndarray:
        """Positions of the slaves and of the corners of own facets: on all ranks together, of everybody."""
        return np.vstack([self.slave_nodes.positions(u), self.around.positions(u)[self.part.corners]])

    def evaluate_here(self, mode: str) -> int:
        """Evaluates; how many slaves cannot know."""
        return 0 if self.interface is None else self.interface.evaluate(mode).outcomes.count("beyond-window")

    def accept(self, u: PETSc.Vec) -> None:
        """The end of an increment: friction of the next one begins here."""
        u.copy(self.accepted)
        if "friction" in self.law:
            self.history = np.full(len(self.slaves), -1.0)
            if self.interface is not None:
                self.interface.accept(**self.law)
                self.history = self.interface.history
                # Anchors couple their nodes, too.
                self.changed = True

    def add_forces(self, forces: PETSc.Vec) -> None:
        """Adds the contact forces on the nodes; PETSc carries those of other ranks."""
        if self.interface is not None:
            forces.setValues(self.nodes.equations, self.interface.forces(**self.law), addv=ADD)
        forces.assemble()

    def add_tangent(self, matrix: PETSc.Mat, which: str) -> None:
        """Adds the contact tangent, ``"exact"`` or ``"gauss-newton"``."""
        free = self._free_equations()
        if self.interface is not None:
            tangent, equations = self.interface.tangent(**self.law, tangent=which), self.nodes.equations
            rows = tangent.indptr.astype(PETSc.IntType)
            values = tangent.data * free[tangent.indices] * np.repeat(free, np.diff(tangent.indptr))
            matrix.setValuesIJV(rows, equations[tangent.indices], values, addv=ADD, rowmap=equations)
        matrix.assemble()

    def _free_equations(self) -> np.ndarray:
        """Of the nodes' equations 0 where displacements are given, else 1. Brought once for each window."""
        if self._free is None:
            self._free = 1.0 - self.nodes.bring(self.held).reshape(-1)
        return self._free

    def linearise(self, u: PETSc.Vec, which: str) -> None:
        """Makes the tangent at these displacements an operator, for ``add_product``."""
        self.evaluate(u, "gradient")
        self.free = self._free_equations()
        self.operator = None if self.interface is None else self.interface.operator(**self.law, tangent=which)

    def add_product(self, v: PETSc.Vec, out: PETSc.Vec) -> None:
        """Adds the tangent times a vector. Only values at nodes go between neighbours, and no entries of a matrix."""
        v = self.free * self.nodes.bring(v).reshape(-1)
        product = np.zeros_like(v)
        if self.operator is not None:
            product = self.free * self.operator.add_product(v, product)
        self.nodes.add(product, out)

    def gaps(self) -> list[Gap]:
        """The gaps of the slaves that carry force, after an evaluation for tangents."""
        free = self._free_equations().reshape(-1, 3)
        if self.interface is None:
            return []
        normal = self.law["penalty"]
        found = []
        for k in np.flatnonzero(self.interface.normal_forces(normal) > 0.0).tolist():
            contact = self.interface.contact(k)
            nodes = np.concatenate([[contact.slave], contact.masters])
            gradient = contact.gradient.reshape(-1, 3) * free[nodes]
            axis = int(np.argmax(np.abs(gradient[0])))
            if gradient[0, axis] != 0.0:
                equations = self.nodes.equations.reshape(-1, 3)[nodes]
                found.append(Gap(int(self.owners[nodes[0]]), axis, equations, gradient, normal * contact.area))
        return found

    def union(self, solids: Pattern) -> PETSc.Mat:
        """An empty matrix with room for the solids and for contact by its present pairing."""
        messages = {}
        if self.interface is not None:
            # Blocks of 3 × 3: the first row of each, and the first of every three columns.
            indptr, indices = self.interface.pattern()
            blocks = self.nodes.equations[::3] // 3
            counts = np.diff(indptr)[::3] // 3
            first = np.repeat(indptr[:-1:3], counts) + 3 * (
                np.arange(counts.sum()) - np.repeat(counts.cumsum() - counts, counts)
            )
            here = np.repeat(np.arange(len(blocks)), counts)
            rows, columns, owners = blocks[here], blocks[indices[first] // 3], self.owners[here]
            for rank in np.unique(owners):
                messages[int(rank)] = (rows[owners == rank], columns[owners == rank])
        return solids.with_blocks(self.exchange.to("pattern", messages).values())

    def results(self) -> dict:
        """What the slaves here have: numbers, forces, and all that the last evaluation gave."""
        found = {"slaves": self.slaves, "slave_forces": np.zeros((len(self.slaves), 3)), "contacts": []}
        if self.interface is None:
            return found
        place = len(self.names) + np.arange(len(self.slaves))
        found["slave_forces"] = self.interface.forces(**self.law).reshape(-1, 3)[place]
        for k in range(len(self.slaves)):
            contact = self.interface.contact(k)
            numbers = [contact.gap, contact.gradient, contact.hessian]
            found["contacts"].append((contact.outcome, self.names[contact.masters], contact.area, *numbers))
        return found

    def is_changed(self) -> bool:
        """Whether the pattern is another one than when this was last asked, on any rank."""
        changed, self.changed = self.changed, False
        return self.exchange.largest(float(changed)) > 0
