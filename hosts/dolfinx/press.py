#!/usr/bin/env python3
"""A hyperelastic block pressed on and slid over a deformable arch, with dolfinx, SNES and any number of MPI ranks.

The arch is 8 × 4 × 2 with a cylindrical upper side of radius 8 in facets of 0.9; its underside is held. The block,
4 × 2 × 2, stands on it. Its upper side is bonded to a rigid plate that goes down by 0.1 and along x by 0.1 in each of
four increments. Materials: compressible neo-Hooke, E = 1000 (block) and 2000 (arch), ν = 0.3, finite strains. Contact:
frictionless, penalty per area, diffuse element.

Who does what on several ranks:

* dolfinx distributes the mesh and assembles the solids.
* `Contact` has on each rank an interface of the slave nodes that the rank owns, against the whole master surface: its
  nodes are few. A PETSc scatter brings the displacements of both at every evaluation.
* Contact forces and the rows of the contact tangent are added after the solids' assembly with `setValues(…, ADD)`;
  PETSc sends entries of rows of other ranks to their owners.

Run with `python3 press.py [results.npz]`, or the same under `mpirun -n 4`.
"""

from __future__ import annotations

import itertools
import json
import sys

import numpy as np
import ufl
from dolfinx import fem, graph, mesh
from dolfinx.fem import petsc
from mpi4py import MPI
from petsc4py import PETSc

import diffuse_contact as dc

RADIUS, INCREMENTS, STEP = 8.0, 4, np.array([0.1, 0.0, -0.1])
PENALTY = 2e4
ADD = PETSc.InsertMode.ADD_VALUES
INSERT = PETSc.InsertMode.INSERT_VALUES
FORWARD, REVERSE = PETSc.ScatterMode.FORWARD, PETSc.ScatterMode.REVERSE


def brick(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nodes, x running fastest, and hexahedra in dolfinx's order: x fastest, then y, then z."""
    nodes = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).transpose(2, 1, 0, 3).reshape(-1, 3)
    i, j, k = (np.arange(len(axis) - 1) for axis in (x, y, z))
    rows, planes = len(x), len(x) * len(y)
    first = (i + rows * j[:, np.newaxis] + planes * k[:, np.newaxis, np.newaxis]).reshape(-1, 1)
    corner = np.array([a + rows * b + planes * c for c in (0, 1) for b in (0, 1) for a in (0, 1)])
    return nodes, first + corner


class Scene:
    """Mesh and surfaces by the numbers that nodes have in the input; every rank knows them."""

    def __init__(self) -> None:
        arch, arch_cells = brick(np.linspace(-4, 4, 10), np.linspace(-1, 3, 6), np.linspace(-2, 0, 4))
        arch[:, 2] += (np.sqrt(RADIUS**2 - arch[:, 0] ** 2) - RADIUS) * (arch[:, 2] + 2) / 2
        block, block_cells = brick(np.linspace(-2, 2, 11), np.linspace(0, 2, 5), np.linspace(0, 2, 5))
        self.nodes = np.vstack([arch, block])
        self.cells = np.vstack([arch_cells, block_cells + len(arch)])
        # The last four corners of the arch's upper cells, counter-clockwise from above; those below the block's first
        # four, which only give areas.
        self.master_facets = arch_cells[-45:][:, [4, 5, 7, 6]]
        self.slave_facets = block_cells[:40][:, [0, 2, 3, 1]] + len(arch)
        self.masters = np.unique(self.master_facets)
        self.slaves = np.unique(self.slave_facets)

    def mesh(self, comm: MPI.Comm) -> mesh.Mesh:
        """The mesh, put in by rank 0 and distributed in slices across x: contact then crosses every border of ranks."""
        domain = ufl.Mesh(ufl.VectorElement("Lagrange", ufl.hexahedron, 1))
        here = slice(None) if comm.rank == 0 else slice(0, 0)
        cells = self.cells[here].astype(np.int64)
        middle = self.nodes[cells, 0].mean(axis=1)
        slices = np.clip((middle + 2) / 4 * comm.size, 0, comm.size - 1).astype(np.int32)

        def partitioner(*_: object) -> object:
            # The rank that owns the cell, then those it is a ghost of: they own a cell with a face in common.
            ranks = [[owner] for owner in slices]
            for rank in range(comm.size):
                beside = np.isin(cells, cells[slices == rank]).sum(axis=1) >= 4
                for cell in np.flatnonzero(beside & (slices != rank)):
                    ranks[cell].append(rank)
            offsets = np.cumsum([0, *map(len, ranks)], dtype=np.int32)
            return graph.create_adjacencylist(np.array([*itertools.chain(*ranks)], dtype=np.int32), offsets)

        return mesh.create_mesh(comm, cells, self.nodes[here], domain, partitioner=partitioner)


def dofs_of_input(space: fem.FunctionSpace) -> tuple[np.ndarray, np.ndarray]:
    """Input numbers of the nodes this rank owns, and the global numbers of their blocks of unknowns."""
    geometry, index_map = space.mesh.geometry, space.dofmap.index_map
    cells = space.mesh.topology.index_map(3)
    input_of = np.empty(index_map.size_local + index_map.num_ghosts, dtype=np.int64)
    for cell in range(cells.size_local + cells.num_ghosts):
        input_of[space.dofmap.cell_dofs(cell)] = np.asarray(geometry.input_global_indices)[geometry.dofmap.links(cell)]
    owned = np.arange(index_map.size_local, dtype=np.int32)
    return input_of[owned], index_map.local_to_global(owned)


class Contact:
    """The contact of the slave nodes this rank owns."""

    def __init__(self, scene: Scene, space: fem.FunctionSpace, vector: PETSc.Vec) -> None:
        comm = space.mesh.comm
        own, blocks = dofs_of_input(space)
        #: Global block of every input node.
        block_of = np.empty(len(scene.nodes), dtype=np.int64)
        for inputs, numbers in comm.allgather((own, blocks)):
            block_of[inputs] = numbers
        own_slaves = np.intersect1d(own, scene.slaves)
        # Nodes here: all masters, the slaves of this rank, and the other corners of their facets, which areas need.
        facets = scene.slave_facets[np.isin(scene.slave_facets, own_slaves).any(axis=1)]
        here = np.concatenate([scene.masters, own_slaves, np.setdiff1d(facets, own_slaves)])
        self.reference = scene.nodes[here]
        self.equations = (3 * block_of[here][:, np.newaxis] + np.arange(3)).reshape(-1).astype(PETSc.IntType)
        self.slaves = own_slaves
        place = np.full(len(scene.nodes), -1)
        place[here] = np.arange(len(here))
        self.interface = dc.ContactInterface(
            dc.MasterSurface(self.reference, place[scene.master_facets]),
            place[own_slaves],
            self.reference,
            slave_facets=place[facets],
        )
        self.values = PETSc.Vec().createSeq(len(self.equations))
        source = PETSc.IS().createGeneral(self.equations, comm=PETSc.COMM_SELF)
        self.scatter = PETSc.Scatter().create(vector, source, self.values, None)

    def positions(self, u: PETSc.Vec) -> np.ndarray:
        """Present positions of the nodes here."""
        self.scatter.scatter(u, self.values, addv=INSERT, mode=FORWARD)
        return self.reference + self.values.array_r.reshape(-1, 3)

    def evaluate(self, u: PETSc.Vec, mode: str) -> None:
        """Evaluates at these displacements."""
        self.interface.follow(self.positions(u))
        self.interface.evaluate(mode)

    def add_forces(self, forces: PETSc.Vec) -> None:
        """Adds the contact forces on the nodes."""
        forces.setValues(self.equations, self.interface.residual(PENALTY), addv=ADD)
        forces.assemble()

    def add_tangent(self, matrix: PETSc.Mat, which: str) -> None:
        """Adds the contact tangent, ``"exact"`` or ``"gauss-newton"``, row by row."""
        tangent = self.interface.tangent(PENALTY, tangent=which)
        for row in np.flatnonzero(np.diff(tangent.indptr)):
            entries = slice(tangent.indptr[row], tangent.indptr[row + 1])
            columns = self.equations[tangent.indices[entries]]
            matrix.setValues(self.equations[row : row + 1], columns, tangent.data[entries], addv=ADD)
        matrix.assemble()


class Problem:
    """What SNES asks for."""

    def __init__(self, u: fem.Function, form: ufl.Form, conditions: list, contact: Contact) -> None:
        self.u, self.conditions, self.contact = u, conditions, contact
        self.residual_form = fem.form(form)
        self.tangent_form = fem.form(ufl.derivative(form, u))
        self.residual = petsc.create_vector(self.residual_form)
        self.tangent = petsc.create_matrix(self.tangent_form)
        self.forces = self.residual.duplicate()
        #: Equations of this rank with given displacements, as they are numbered here; behind them come those of ghosts.
        held = np.concatenate([given.dof_indices()[0] for given in conditions])
        self.held = held[held < self.residual.getLocalSize()]
        # Contact couples what no cell couples.
        self.tangent.setOption(PETSc.Mat.Option.NEW_NONZERO_ALLOCATION_ERR, False)

    def take_over(self, x: PETSc.Vec) -> None:
        """The displacements of the next evaluation."""
        x.copy(self.u.vector)
        self.u.vector.ghostUpdate(addv=INSERT, mode=FORWARD)

    def F(self, snes: PETSc.SNES, x: PETSc.Vec, b: PETSc.Vec) -> None:
        """Internal minus contact forces; u − u₀ where displacements are given."""
        self.take_over(x)
        with b.localForm() as local:
            local.set(0.0)
        petsc.assemble_vector(b, self.residual_form)
        b.ghostUpdate(addv=ADD, mode=REVERSE)
        self.contact.evaluate(self.u.vector, "gradient")
        self.forces.zeroEntries()
        self.contact.add_forces(self.forces)
        b.axpy(-1.0, self.forces)
        self.which = self.adaptive_tangent(b)
        petsc.set_bc(b, self.conditions, x, -1.0)

    def adaptive_tangent(self, b: PETSc.Vec) -> str:
        """The contact tangent at this residual, in which held equations have their reactions. The same on all ranks."""
        reactions, residual = b.array_r[self.held], np.delete(b.array_r, self.held)
        squares = np.array([residual @ residual, reactions @ reactions])
        residual, reaction = np.sqrt(b.comm.tompi4py().allreduce(squares))
        return dc.adaptive_tangent(residual, max(reaction, self.forces.norm()))

    def J(self, snes: PETSc.SNES, x: PETSc.Vec, A: PETSc.Mat, P: PETSc.Mat) -> None:
        """The derivative of F, which SNES has called here. Nodes in contact have no given displacements."""
        self.take_over(x)
        A.zeroEntries()
        petsc.assemble_matrix(A, self.tangent_form, bcs=self.conditions)
        A.assemble()
        self.contact.evaluate(self.u.vector, "hessian")
        self.contact.add_tangent(A, self.which)


def hyperelastic(space: fem.FunctionSpace, u: fem.Function) -> ufl.Form:
    """Virtual work of both bodies; that above z = 0 is the block."""
    x = ufl.SpatialCoordinate(space.mesh)
    E, nu = ufl.conditional(ufl.gt(x[2], 0.0), 1000.0, 2000.0), 0.3
    mu, lmbda = E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))
    F = ufl.Identity(3) + ufl.grad(u)
    J = ufl.det(F)
    energy = mu / 2 * (ufl.inner(F, F) - 3) - mu * ufl.ln(J) + lmbda / 2 * ufl.ln(J) ** 2
    dx = ufl.dx(metadata={"quadrature_degree": 2})
    return ufl.derivative(energy * dx, u, ufl.TestFunction(space))


def solve(comm: MPI.Comm) -> dict:
    """All increments; on rank 0 what the tests look at."""
    dc.set_threads(1)
    scene = Scene()
    domain = scene.mesh(comm)
    space = fem.VectorFunctionSpace(domain, ("Lagrange", 1))
    u = fem.Function(space)
    plate = fem.Constant(domain, np.zeros(3))
    bottom = fem.locate_dofs_geometrical(space, lambda x: np.isclose(x[2], -2.0))
    top = fem.locate_dofs_geometrical(space, lambda x: np.isclose(x[2], 2.0))
    conditions = [fem.dirichletbc(np.zeros(3), bottom, space), fem.dirichletbc(plate, top, space)]
    contact = Contact(scene, space, u.vector)
    problem = Problem(u, hyperelastic(space, u), conditions, contact)

    snes = PETSc.SNES().create(comm)
    snes.setFunction(problem.F, problem.residual)
    snes.setJacobian(problem.J, problem.tangent)
    snes.setOptionsPrefix("press_")
    PETSc.Options("press_")["snes_linesearch_type"] = "basic"
    snes.setFromOptions()
    snes.setType("newtonls")
    snes.setTolerances(rtol=0.0, atol=1e-9, stol=0.0, max_it=20)
    snes.getKSP().setType("preonly")
    snes.getKSP().getPC().setType("lu")
    snes.getKSP().getPC().setFactorSolverType("mumps")

    x = u.vector.duplicate()
    iterations, residuals = [], []
    for increment in range(1, INCREMENTS + 1):
        plate.value[:] = increment * STEP
        contact.interface.refresh_pairing(contact.positions(u.vector))
        snes.setConvergenceHistory()
        snes.solve(None, x)
        if snes.getConvergedReason() <= 0:
            raise RuntimeError(f"increment {increment}: SNES ends with reason {snes.getConvergedReason()}")
        problem.take_over(x)
        iterations.append(snes.getIterationNumber())
        residuals.append(snes.getConvergenceHistory()[0].tolist())

    contact.evaluate(u.vector, "gradient")
    contacts = contact.interface.contacts
    forces = contact.interface.normal_forces(PENALTY)
    own, _ = dofs_of_input(space)
    parts = comm.gather((own, u.vector.array_r.reshape(-1, 3), contact.slaves, forces, contacts.normal, contacts.gap))
    if comm.rank != 0:
        return {}
    displacements, slave_forces = np.empty_like(scene.nodes), np.zeros(len(scene.nodes))
    total = np.zeros(3)
    for own, values, slaves, forces, normals, _ in parts:
        displacements[own] = values
        slave_forces[slaves] = forces
        total += np.nan_to_num(forces[:, np.newaxis] * normals).sum(axis=0)
    return {
        "iterations": iterations,
        "residuals": residuals,
        "force": total.tolist(),
        "touching": int((slave_forces > 0).sum()),
        "penetration": max((-float(np.nanmin(part[5])) for part in parts if len(part[5])), default=0.0),
        "slaves_of_ranks": [len(part[2]) for part in parts],
        "displacements": displacements,
        "forces": slave_forces,
    }


def main() -> None:
    """Prints the results, and writes them to a file if one is named."""
    result = solve(MPI.COMM_WORLD)
    if result:
        arrays = {name: result.pop(name) for name in ("displacements", "forces")}
        print(json.dumps(result))
        if len(sys.argv) > 1:
            np.savez(sys.argv[1], **arrays)


if __name__ == "__main__":
    main()
