"""Multigrid that the penalty does not spoil, and a tangent without a matrix."""

from __future__ import annotations

import numpy as np
import scipy.sparse
from contact import Contact
from dolfinx import fem
from petsc4py import PETSc

ADD = PETSc.InsertMode.ADD_VALUES


class ShellTangent:
    """The context of a shell matrix: the solids' matrix and the contact's operator."""

    def __init__(self, solids: PETSc.Mat, contact: Contact) -> None:
        self.solids, self.contact = solids, contact

    def mult(self, _: PETSc.Mat, v: PETSc.Vec, out: PETSc.Vec) -> None:
        """A product."""
        self.solids.mult(v, out)
        self.contact.add_product(v, out)

    def matrix(self) -> PETSc.Mat:
        """The matrix."""
        made = PETSc.Mat().createPython(self.solids.getSizes(), self, comm=self.solids.comm)
        made.setUp()
        return made


def rigid_body_modes(positions: np.ndarray, like: PETSc.Vec, without: np.ndarray) -> PETSc.NullSpace:
    """For algebraic multigrid: what elasticity hardly resists. 0 in the equations of this rank ``without``."""
    modes = []
    for mode in range(6):
        values = np.zeros_like(positions)
        if mode < 3:
            values[:, mode] = 1.0
        else:
            i, j = ((1, 2), (2, 0), (0, 1))[mode - 3]
            values[:, i], values[:, j] = -positions[:, j], positions[:, i]
        made = like.duplicate()
        made.array_w[:] = values.reshape(-1)
        made.array_w[without] = 0.0
        for other in modes:
            made.axpy(-made.dot(other), other)
        made.normalize()
        modes.append(made)
    return PETSc.NullSpace().create(vectors=modes, comm=like.comm)


class GapMultigrid:
    """The context of a preconditioner: algebraic multigrid in unknowns in which the penalty is a diagonal.

    Of each slave that carries force the displacement along the axis closest to its normal is replaced by its gap
    w = N u. With u = T u', ε N Nᵀ becomes ε at the place of w in Tᵀ A T. Smoothers by the diagonal see nothing of it,
    and rigid body modes have w = 0. T differs from the identity in one row of each such slave.

    Args:
        contact: whose gaps are taken.
        space: of the displacements.
        adds: whether ε N Nᵀ is to be added to the matrix, as it has the solids alone.

    """

    def __init__(self, contact: Contact, space: fem.FunctionSpace, adds: bool) -> None:
        self.contact, self.adds = contact, adds
        self.u = contact.vector
        count = self.u.getLocalSize() // 3
        self.first = space.tabulate_dof_coordinates()[:count].copy()
        #: None where no gap is an unknown.
        self.transformation = None
        self.inner = None
        self.work = [self.u.duplicate() for _ in range(2)]

    def setUp(self, pc: PETSc.PC) -> None:
        """For the matrix of the moment."""
        # What Python alone forgets, PETSc keeps: all ranks have to say so.
        for old in (self.inner, self.transformation):
            if old is not None:
                old.destroy()
        _, matrix = pc.getOperators()
        stiffness, without = self._take_gaps(matrix)
        if self.transformation is None:
            transformed = matrix
        else:
            transformed = matrix.ptap(self.transformation)
            transformed.setBlockSize(3)
        if self.adds and self.transformation is not None:
            self.work[0].array_w[:] = stiffness
            transformed.setDiagonal(self.work[0], addv=ADD)
        positions = self.first + self.u.array_r.reshape(-1, 3)
        transformed.setNearNullSpace(rigid_body_modes(positions, self.u, without))
        self.inner = PETSc.PC().create(pc.comm)
        self.inner.setOptionsPrefix((pc.getOptionsPrefix() or "") + "gap_")
        self.inner.setType("gamg")
        self.inner.setOperators(transformed)
        self.inner.setFromOptions()
        self.inner.setUp()

    def _take_gaps(self, matrix: PETSc.Mat) -> tuple[np.ndarray, np.ndarray]:
        """Makes T. ε in the equations of gaps, and which they are, of this rank."""
        exchange = self.contact.exchange
        messages: dict[int, list] = {}
        for gap in self.contact.gaps():
            messages.setdefault(gap.owner, []).append(gap)
        rows = {rank: _rows(gaps) for rank, gaps in messages.items()}
        found = [*exchange.to("gaps", rows).values()]
        if exchange.largest(float(len(found))) == 0:
            self.transformation = None
            return np.empty(0), np.empty(0, dtype=np.int64)
        first, last = matrix.getOwnershipRange()
        count, size = last - first, matrix.getSize()[0]
        gaps, stiffness = np.concatenate([[], *(of[0] for of in found)]).astype(np.int64), np.zeros(count)
        stiffness[gaps - first] = np.concatenate([[], *(of[1] for of in found)])
        own = np.setdiff1d(np.arange(first, last), gaps)
        i, j, values = (
            np.concatenate([start, *(of[2 + k] for of in found)])
            for k, start in enumerate((own, own, np.ones(len(own))))
        )
        made = scipy.sparse.csr_matrix((values, (i - first, j)), shape=(count, size))
        csr = (made.indptr.astype(PETSc.IntType), made.indices.astype(PETSc.IntType), made.data)
        self.transformation = PETSc.Mat().createAIJ(matrix.getSizes(), bsize=3, csr=csr, comm=matrix.comm)
        return stiffness, gaps - first

    def apply(self, _: PETSc.PC, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """T M⁻¹ Tᵀ b."""
        if self.transformation is None:
            self.inner.apply(b, x)
            return
        one, other = self.work
        self.transformation.multTranspose(b, one)
        self.inner.apply(one, other)
        self.transformation.mult(other, x)


def _rows(gaps: list) -> tuple[np.ndarray, ...]:
    """Of some gaps: their equations and stiffnesses, and rows, columns and values of T."""
    equations = np.array([gap.equations[0, gap.axis] for gap in gaps], dtype=np.int64)
    lengths = [gap.equations.size for gap in gaps]
    columns = np.concatenate([gap.equations.reshape(-1) for gap in gaps]).astype(np.int64)
    values = [-gap.gradient.reshape(-1) / gap.gradient[0, gap.axis] for gap in gaps]
    for gap, row in zip(gaps, values, strict=True):
        row[gap.axis] = 1.0 / gap.gradient[0, gap.axis]
    stiffness = np.array([gap.stiffness for gap in gaps])
    return equations, stiffness, np.repeat(equations, lengths), columns, np.concatenate(values)
