"""What versions of dolfinx differ in: 0.5 of Debian 12, and 0.8 and later."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import ufl
from dolfinx import fem, graph, mesh
from mpi4py import MPI
from petsc4py import PETSc


def hexahedra(
    comm: MPI.Comm, cells: np.ndarray, nodes: np.ndarray, partitioner: Callable[..., object] | None
) -> mesh.Mesh:
    """A mesh of hexahedra; ``cells`` and ``nodes`` are those that this rank puts in. No partitioner: dolfinx's own."""
    options = {} if partitioner is None else {"partitioner": partitioner}
    try:
        from basix.ufl import element
    except ImportError:
        domain = ufl.Mesh(ufl.VectorElement("Lagrange", ufl.hexahedron, 1))
        return mesh.create_mesh(comm, cells, nodes, domain, **options)
    if partitioner is None:
        options = {"partitioner": mesh.create_cell_partitioner(mesh.GhostMode.shared_facet)}
    return mesh.create_mesh(comm, cells=cells, x=nodes, e=element("Lagrange", "hexahedron", 1, shape=(3,)), **options)


def destinations(ranks: list[list[int]]) -> object:
    """What a partitioner returns: for each cell its owner, then the ranks that it is a ghost of."""
    offsets = np.cumsum([0, *map(len, ranks)], dtype=np.int32)
    data = np.array([rank for row in ranks for rank in row], dtype=np.int32)
    if hasattr(graph, "create_adjacencylist"):
        return graph.create_adjacencylist(data, offsets)
    made = graph.adjacencylist(data, offsets)
    return getattr(made, "_cpp_object", made)


def displacements(domain: mesh.Mesh) -> fem.FunctionSpace:
    """The space of linear displacements."""
    if hasattr(fem, "functionspace"):
        return fem.functionspace(domain, ("Lagrange", 1, (3,)))
    return fem.VectorFunctionSpace(domain, ("Lagrange", 1))


def vector(u: fem.Function) -> PETSc.Vec:
    """The PETSc vector of a function."""
    return u.x.petsc_vec if hasattr(u.x, "petsc_vec") else u.vector


def nodes_of_cells(
    domain: mesh.Mesh, space: fem.FunctionSpace, count: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of the first cells, shape (count, 8, …): numbers of nodes in the input, blocks of unknowns here, positions."""
    dofmap = domain.geometry.dofmap
    if isinstance(dofmap, np.ndarray):
        geometry = dofmap[:count]
    else:
        geometry = np.array([dofmap.links(cell) for cell in range(count)], dtype=np.int64).reshape(count, 8)
    blocks = np.array([space.dofmap.cell_dofs(cell) for cell in range(count)], dtype=np.int64).reshape(count, 8)
    return np.asarray(domain.geometry.input_global_indices)[geometry], blocks, domain.geometry.x[geometry]


def owners(space: fem.FunctionSpace) -> np.ndarray:
    """The rank that owns each block of unknowns that is known here."""
    index_map = space.dofmap.index_map
    ghosts = index_map.owners() if callable(index_map.owners) else index_map.owners
    own = np.full(index_map.size_local, space.mesh.comm.rank)
    return np.concatenate([own, np.asarray(ghosts)]).astype(np.int64)
