#!/usr/bin/env python3
"""A hyperelastic block pressed on and slid over a deformable arch, with dolfinx, SNES and any number of MPI ranks.

The arch is 8 × 4 × 2 with a cylindrical upper side of radius 8 in facets of 0.9; its underside is held. The block,
4 × 2 × 2, stands on it. Its upper side is bonded to a rigid plate that goes down by 0.1 and along x by 0.1 in each of
four increments, and with ``--slide`` on along x. Materials: compressible neo-Hooke, E = 1000 (block) and 2000 (arch),
ν = 0.3, finite strains. Contact: penalty per area, diffuse element, with ``--friction`` Coulomb's law.

dolfinx distributes the mesh and assembles the solids. ``Contact`` has on each rank its share of the slaves and a window
of the master; no rank holds the whole surface. Forces and rows of the tangent are added where PETSc carries them to.
``FaceContact`` integrates over the faces instead.

1. `problem_of` makes forms, conditions and contact on the mesh that `MeshFile` has read.
2. `Problem.predict` begins an increment: the last tangent says where given displacements lead.
3. SNES asks `Problem` for residual and tangent, `prepare` for a matrix wherever other nodes couple.

Run with ``python3 press.py mesh.xdmf``, or with ``mpirun -n 4 python3 -m mpi4py press.py mesh.xdmf``: an error on one
rank then ends all. ``--help`` tells the options.
"""

from __future__ import annotations

import argparse
import json
import pickle
from collections import Counter
from pathlib import Path

import numpy as np
import ufl
from compat import displacements, vector
from contact import ADD, FORWARD, INSERT, REVERSE, Contact, Pattern, beside_the_edge
from dolfinx import fem, mesh
from dolfinx.fem import petsc
from faces import FaceContact
from mpi4py import MPI
from petsc4py import PETSc
from scene import on_master, on_slave
from solvers import GapMultigrid, ShellTangent
from source import MeshFile
from surfaces import input_numbers

import diffuse_contact as dc

PENALTY, LIMIT = 2e4, 0.6
PRESS, SLIDE = np.array([0.1, 0.0, -0.1]), np.array([0.3, 0.0, 0.0])


class Problem:
    """What SNES asks for."""

    def __init__(self, u: fem.Function, form: ufl.Form, conditions: list, contact: Contact, shell: bool) -> None:
        self.u, self.vector, self.conditions, self.contact = u, vector(u), conditions, contact
        self.residual_form = fem.form(form)
        self.tangent_form = fem.form(ufl.derivative(form, u))
        self.way = fem.Function(u.function_space)
        self.change_form = fem.form(ufl.derivative(form, u, self.way))
        solids = petsc.assemble_matrix(self.tangent_form)
        solids.assemble()
        self.pattern, self.solids = Pattern.of(solids), solids
        #: The tangent, if it is an operator.
        self.shell = ShellTangent(solids, contact).matrix() if shell else None
        #: Whether SNES has a matrix with the contact's tangent: all of it, or what preconditions the operator.
        self.assembles = not shell or contact.preconditioned_by_matrix
        self.residual, self.forces = self.vector.duplicate(), self.vector.duplicate()
        #: Equations of this rank with given displacements, as they are numbered here; behind them come those of ghosts.
        held = np.concatenate([given.dof_indices()[0] for given in conditions])
        self.held = held[held < self.residual.getLocalSize()]
        contact.held.array_w[self.held] = 1.0
        self.which = "gauss-newton"
        #: Displacements at which F has evaluated contact last.
        self.evaluated_at = None

    def take_over(self, x: PETSc.Vec) -> None:
        """The displacements of the next evaluation."""
        x.copy(self.vector)
        self.vector.ghostUpdate(addv=INSERT, mode=FORWARD)

    def F(self, snes: PETSc.SNES, x: PETSc.Vec, b: PETSc.Vec) -> None:
        """Internal minus contact forces; u − u₀ where displacements are given."""
        self.take_over(x)
        with b.localForm() as local:
            local.set(0.0)
        petsc.assemble_vector(b, self.residual_form)
        b.ghostUpdate(addv=ADD, mode=REVERSE)
        self.contact.evaluate(self.vector, "gradient")
        self.forces.zeroEntries()
        self.contact.add_forces(self.forces)
        b.axpy(-1.0, self.forces)
        self.which = self.adaptive_tangent(b)
        petsc.set_bc(b, self.conditions, x, -1.0)
        self.evaluated_at = x.array_r.copy()

    def adaptive_tangent(self, b: PETSc.Vec) -> str:
        """The contact tangent at this residual, in which held equations have their reactions. The same on all ranks."""
        reactions, residual = b.array_r[self.held], np.delete(b.array_r, self.held)
        squares = np.array([residual @ residual, reactions @ reactions])
        residual, reaction = np.sqrt(b.comm.tompi4py().allreduce(squares))
        return dc.adaptive_tangent(residual, max(reaction, self.forces.norm()))

    def prepare(self, snes: PETSc.SNES, iteration: int) -> None:
        """Before each linear system: where other nodes couple, an assembled matrix is another one."""
        if self.contact.is_changed():
            matrix = self.contact.union(self.pattern)
            snes.setJacobian(self.J, self.shell or matrix, matrix)

    def J(self, snes: PETSc.SNES, x: PETSc.Vec, A: PETSc.Mat, P: PETSc.Mat) -> None:
        """The derivative of F, which SNES has called here last."""
        self.take_over(x)
        self.solids.zeroEntries()
        petsc.assemble_matrix(self.solids, self.tangent_form, bcs=self.conditions)
        self.solids.assemble()
        if self.shell is None:
            mode = self.contact.mode_of_tangent
            # A line search evaluates F in a vector of its own.
            is_other = float(self.evaluated_at is None or not np.array_equal(self.evaluated_at, x.array_r))
            if mode != "gradient" or self.contact.exchange.largest(is_other) > 0:
                self.contact.evaluate(self.vector, mode)
        else:
            self.contact.linearise(self.vector, self.which)
            A.assemble()
        if self.assembles:
            P.zeroEntries()
            P.axpy(1.0, self.solids, structure=PETSc.Mat.Structure.SUBSET)
            # The operator turns its forces; a matrix that only preconditions it need not.
            self.contact.add_tangent(P, self.which if self.shell is None else "gauss-newton")

    def shell_error(self) -> float:
        """By how much a product of the shell differs from that of the assembled matrix, over the latter; after J."""
        self.contact.evaluate(self.vector, self.contact.mode_of_tangent)
        matrix = self.contact.union(self.pattern)
        petsc.assemble_matrix(matrix, self.tangent_form, bcs=self.conditions)
        matrix.assemble()
        self.contact.add_tangent(matrix, self.which)
        v = self.vector.duplicate()
        v.setRandom()
        expected, found = matrix * v, self.shell * v
        return (found - expected).norm() / expected.norm()

    def predict(self, snes: PETSc.SNES, x: PETSc.Vec) -> int:
        """Moves x to where the tangent says that the given displacements lead; iterations of the linear solver.

        A line search needs them imposed, and imposed alone they crush the cells beside them.
        """
        b = self.residual.duplicate()
        self.F(snes, x, b)
        if self.assembles:
            self.prepare(snes, 0)
        A, P = snes.getJacobian()[:2]
        with beside_the_edge(self.contact):
            self.J(snes, x, A, P)
        way = x.duplicate()
        petsc.set_bc(way, self.conditions)
        way.array_w[self.held] -= x.array_r[self.held]
        way.copy(vector(self.way))
        vector(self.way).ghostUpdate(addv=INSERT, mode=FORWARD)
        change = self.residual.duplicate()
        petsc.assemble_vector(change, self.change_form)
        change.ghostUpdate(addv=ADD, mode=REVERSE)
        b.axpy(1.0, change)
        b.scale(-1.0)
        b.array_w[self.held] = 0.0
        ksp = snes.getKSP()
        ksp.setOperators(A, P)
        free = x.duplicate()
        ksp.solve(b, free)
        if ksp.getConvergedReason() <= 0:
            raise RuntimeError(f"the linear solver ends with reason {ksp.getConvergedReason()}")
        x.axpy(1.0, way)
        x.axpy(1.0, free)
        petsc.set_bc(x, self.conditions)
        for vec in (b, way, change, free):
            vec.destroy()
        return ksp.getIterationNumber()


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


#: What PETSc's defaults are replaced by; ``-press_…`` on the command line come last.
OPTIONS = {
    # The residual's norm has kinks where contacts close, in which a search for less of it (bt) gets caught. This one
    # seeks where the residual does no work.
    "snes_linesearch_type": "cp",
    "snes_linesearch_max_it": 5,
}


def solver(comm: MPI.Comm, linear: str, symmetric: bool, multigrid: GapMultigrid) -> PETSc.SNES:
    """Newton with a line search; MUMPS, or multigrid with CG, for tangents that are not symmetric GMRES."""
    snes = PETSc.SNES().create(comm)
    snes.setOptionsPrefix("press_")
    options = PETSc.Options("press_")
    if linear == "gamg":
        # No aggressive coarsening, which takes twice the iterations: by the name of this version.
        name = "square_graph" if PETSc.Sys.getVersion() < (3, 19) else "aggressive_coarsening"
        OPTIONS[f"gap_pc_gamg_{name}"] = 0
    for name, value in OPTIONS.items():
        if not options.hasName(name):
            options[name] = value
    snes.setType("newtonls")
    snes.setTolerances(rtol=0.0, atol=1e-9, stol=0.0, max_it=40)
    ksp = snes.getKSP()
    if linear == "mumps":
        ksp.setType("preonly")
        ksp.getPC().setType("lu")
        ksp.getPC().setFactorSolverType("mumps")
    else:
        ksp.setType("cg" if symmetric else "gmres")
        ksp.setTolerances(rtol=1e-8, max_it=500)
        ksp.getPC().setType("python")
        ksp.getPC().setPythonContext(multigrid)
    snes.setFromOptions()
    return snes


def lowered(space: fem.FunctionSpace, way: float) -> PETSc.Vec:
    """Displacements: the block as a whole goes down."""
    made = fem.Function(space)
    # What dolfinx 0.9 does not make by itself.
    space.mesh.topology.create_connectivity(3, 3)
    block = mesh.locate_entities(space.mesh, 3, lambda x: x[2] > -1e-9)
    nodes = fem.locate_dofs_topological(space, 3, block)
    found = vector(made).duplicate()
    found.array_w[3 * nodes[3 * nodes < found.getLocalSize()] + 2] = -way
    return found


def problem_of(domain: mesh.Mesh, arguments: argparse.Namespace) -> tuple[Problem, fem.Constant]:
    """The problem, and where the plate is."""
    space = displacements(domain)
    u = fem.Function(space)
    plate = fem.Constant(domain, np.zeros(3))
    bottom = fem.locate_dofs_geometrical(space, lambda x: np.isclose(x[2], -2.0))
    top = fem.locate_dofs_geometrical(space, lambda x: np.isclose(x[2], 2.0))
    conditions = [fem.dirichletbc(np.zeros(3), bottom, space), fem.dirichletbc(plate, top, space)]
    law = {
        "penalty": arguments.penalty,
        "limit": arguments.limit / arguments.fine,
        "skin": 2 / 3 * arguments.limit / arguments.fine,
        "friction": arguments.friction,
    }
    of = FaceContact if arguments.integration == "faces" else Contact
    contact = of(space, vector(u), on_master, on_slave, **law)
    return Problem(u, hyperelastic(space, u), conditions, contact, arguments.tangent == "operator"), plate


def newton_of(comm: MPI.Comm, problem: Problem, arguments: argparse.Namespace) -> PETSc.SNES:
    """The solver of the problem."""
    symmetric = arguments.friction is None and arguments.integration == "nodes"
    multigrid = GapMultigrid(problem.contact, problem.u.function_space, adds=not problem.assembles)
    snes = solver(comm, arguments.linear, symmetric, multigrid)
    snes.setFunction(problem.F, problem.residual)
    if problem.assembles:
        snes.setUpdate(problem.prepare)
    else:
        snes.setJacobian(problem.J, problem.shell, problem.solids)
    return snes


def solve(comm: MPI.Comm, arguments: argparse.Namespace) -> tuple[dict, dict]:
    """All increments. What rank 0 prints, and what this rank has of the result."""
    dc.set_threads(1)
    file = MeshFile(comm, arguments.mesh)
    problem, plate = problem_of(file.mesh(arguments.partitioner), arguments)
    contact, u = problem.contact, problem.vector
    contact.accept(u)
    x = lowered(problem.u.function_space, arguments.lower)
    problem.take_over(x)
    snes = newton_of(comm, problem, arguments)
    found = {"iterations": [], "linear": [], "residuals": [], "renewals": []}
    # Every M is held only to be written.
    mode = "gradient" if arguments.results is None else "hessian"
    first, received = Counter(contact.exchange.received), []
    for increment in range(1, arguments.press + arguments.slide + 1):
        plate.value += arguments.way * (PRESS if increment <= arguments.press else SLIDE)
        before = Counter(contact.exchange.received)
        predicted = problem.predict(snes, x)
        snes.setConvergenceHistory()
        snes.solve(None, x)
        if snes.getConvergedReason() <= 0:
            raise RuntimeError(f"increment {increment}: SNES ends with reason {snes.getConvergedReason()}")
        problem.take_over(x)
        found["iterations"].append(snes.getIterationNumber())
        found["linear"].append(predicted + snes.getLinearSolveIterations())
        found["residuals"].append(snes.getConvergenceHistory()[0].tolist())
        found["renewals"].append(contact.renewals)
        contact.evaluate(u, mode)
        results = contact.results()
        contact.accept(u)
        problem.evaluated_at = None
        received.append(contact.exchange.received - before)
    if not found["iterations"]:
        contact.evaluate(u, mode)
        results = contact.results()
    if problem.shell is not None:
        tangent, preconditioner = snes.getJacobian()[:2]
        problem.J(snes, x, tangent, preconditioner)
        found["shell_error"] = problem.shell_error()
    results["displacements"] = u.array_r.reshape(-1, 3).copy()
    results["nodes"] = input_numbers(problem.u.function_space)
    of_ranks = {
        "slaves_of_ranks": len(contact.slaves),
        "masters_of_ranks": contact.masters,
        "bytes_of_ranks": contact.nbytes,
        "read_of_ranks": file.nbytes,
        "sent_of_ranks": dict(contact.exchange.sent),
        "messages_of_ranks": dict(contact.exchange.messages),
        # Before the first increment, and in each.
        "received_of_ranks": [dict(first), *map(dict, received)],
        "vectors_of_ranks": contact.vector_bytes,
    }
    found.update({name: comm.gather(value) for name, value in of_ranks.items()})
    found["force"] = comm.allreduce(results["slave_forces"].sum(axis=0)).tolist()
    found["unknowns"] = u.getSize()
    return found, results


def main() -> None:
    """Prints the results, and writes what each rank has to files if a folder is named."""
    shows_defaults = argparse.ArgumentDefaultsHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], formatter_class=shows_defaults)
    parser.add_argument("mesh", type=Path, help="an XDMF file: scene.py writes one")
    parser.add_argument(
        "--partitioner", choices=["dolfinx", "strips", "blocks", "random"], default="dolfinx", help="of the mesh"
    )
    parser.add_argument(
        "--linear", choices=["mumps", "gamg"], default="mumps", help="factors, or iterations with multigrid"
    )
    parser.add_argument("--integration", choices=["nodes", "faces"], default="nodes", help="of the contact")
    parser.add_argument(
        "--tangent",
        choices=["assembled", "operator"],
        default="assembled",
        help="a matrix, or a PETSc shell: with --linear gamg",
    )
    parser.add_argument(
        "--friction", type=float, help="coefficient; the module has to be built with its feature friction"
    )
    parser.add_argument("--penalty", type=float, default=PENALTY, help="force per length³")
    parser.add_argument("--limit", type=float, default=LIMIT, help="no contact beyond this, length times --fine")
    parser.add_argument("--lower", type=float, default=0.0, help="the block before the first increment, length")
    parser.add_argument("--way", type=float, default=1.0, help="of the plate in an increment, over that of the problem")
    parser.add_argument("--press", type=int, default=4, help="increments down and along x")
    parser.add_argument("--slide", type=int, default=0, help="increments of 0.3 along x after that")
    parser.add_argument("--fine", type=int, default=1, help="the --fine that scene.py made the mesh with")
    parser.add_argument("--results", type=Path, help="a folder")
    arguments, others = parser.parse_known_args()
    unknown = [word for word in others if word.startswith("--")]
    if unknown:
        parser.error(f"unknown: {' '.join(unknown)}; options of PETSc begin with one dash")
    for file in (arguments.mesh, arguments.mesh.with_suffix(".h5")):
        if not file.is_file():
            parser.error(f"there is no file {file}: scene.py writes an .xdmf file with an .h5 beside it")
    if arguments.fine < 1 or min(arguments.press, arguments.slide) < 0:
        parser.error("--fine has to be 1 or more, --press and --slide 0 or more")
    if arguments.tangent == "operator" and arguments.linear == "mumps":
        parser.error("MUMPS factors a matrix: --tangent operator goes with --linear gamg")
    if arguments.results is not None:
        arguments.results.mkdir(parents=True, exist_ok=True)
    PETSc.Options().insertString(" ".join(others))
    comm = MPI.COMM_WORLD
    summary, results = solve(comm, arguments)
    if comm.rank == 0:
        print(json.dumps(summary))
    if arguments.results is not None:
        with (arguments.results / f"{comm.rank}.pickle").open("wb") as file:
            pickle.dump(results, file)


if __name__ == "__main__":
    main()
