#!/usr/bin/env python3
"""An elastic block pressed on a rigid faceted cylinder: scikit-fem assembles the solid, diffuse-contact the contact.

The cylinder has radius 8 and its axis along y; its nodes lie in columns of a given angle and are fixed. The block,
6 × 2 × 3, stands on it with its underside. Its upper face, which is bonded to a rigid plate, goes down by 0.3 in three
increments. Material: linear elastic, E = 1000, ν = 0.3, small strains; contact: frictionless, penalty per area.

1. `Block` has what scikit-fem gives: positions of the nodes, equations of their displacements, stiffness.
2. `press` adds contact: nodes of block and cylinder get one numbering, those of the cylinder have no equations.
3. `newton` balances internal and contact forces; the sum of the matrices is solved with scipy.

Run it to see the pressing force and Newton's residuals with the diffuse element, with the node-to-facet element, and on
a cylinder of very fine facets.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, field

import numpy as np
import scipy.sparse.linalg
from skfem import Basis, ElementHex1, ElementVector, MeshHex
from skfem.models.elasticity import lame_parameters, linear_elasticity

import diffuse_contact as dc

RADIUS, DEPTH, INCREMENTS = 8.0, 0.3, 3
PENALTY = 2e4
#: Newton's iteration ends at this residual over the contact forces.
TOLERANCE = 1e-11


class Block:
    """The solid: numbering and stiffness as scikit-fem makes them."""

    def __init__(self, cells: tuple[int, int, int] = (24, 4, 6)) -> None:
        x, y, z = (np.linspace(*ends, n + 1) for ends, n in zip(((-3, 3), (0, 2), (0, 3)), cells, strict=True))
        self.mesh = MeshHex.init_tensor(x, y, z)
        basis = Basis(self.mesh, ElementVector(ElementHex1()))
        self.stiffness = linear_elasticity(*lame_parameters(1000.0, 0.3)).assemble(basis).tocsr()
        self.positions = self.mesh.p.T.copy()
        #: Equations of each node's x, y and z, shape (nodes, 3).
        self.dofs = basis.nodal_dofs.T.copy()
        self.held = basis.get_dofs(lambda x: np.isclose(x[2], 3.0)).all()
        self.held_down = self.dofs[np.isclose(self.positions[:, 2], 3.0), 2]
        self.free = np.setdiff1d(np.arange(self.stiffness.shape[0]), self.held)
        facets = self.mesh.facets[:, self.mesh.facets_satisfying(lambda x: np.isclose(x[2], 0.0))].T
        self.underside = np.array([self._around(facet) for facet in facets])

    def _around(self, facet: np.ndarray) -> np.ndarray:
        """The corners of a facet of the underside one after the other, counter-clockwise seen from below."""
        offset = self.positions[facet] - self.positions[facet].mean(axis=0)
        return facet[np.argsort(-np.arctan2(offset[:, 1], offset[:, 0]))]


def cylinder(degrees: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and facets, outside up, of a cylinder with columns of nodes every ``degrees``, half of that within ±40°.

    No column lies at the top: there is the middle of a facet.
    """
    half = round(40 / degrees)
    angles = np.radians(degrees * (np.arange(2 * half) - half + 0.5))
    width = min(2 * RADIUS * np.sin(np.radians(degrees) / 2), 1.0)
    along = np.linspace(-2.0, 4.0, round(6.0 / width) + 1)
    angle, y = np.meshgrid(angles, along)
    nodes = np.column_stack([(RADIUS * np.sin(angle)).ravel(), y.ravel(), (RADIUS * np.cos(angle) - RADIUS).ravel()])
    columns = len(angles)
    first = (np.arange(len(along) - 1)[:, np.newaxis] * columns + np.arange(columns - 1)).ravel()
    return nodes, np.column_stack([first, first + 1, first + columns + 1, first + columns])


@dataclass
class Result:
    """What the tests look at."""

    #: Force on the plate at the end.
    force: float
    #: Largest contact pressure at the end, and deepest penetration.
    pressure: float
    penetration: float
    #: Residual over the contact forces at each iteration of each increment.
    residuals: list[list[float]] = field(default_factory=list)


def newton(block: Block, interface: dc.ContactInterface, master: np.ndarray, u: np.ndarray, down: float) -> list[float]:
    """Brings ``u`` into balance with the plate at ``−down``; the relative residuals of the iterations."""
    residuals: list[float] = []
    step = np.zeros_like(u)
    step[block.held_down] = -down - u[block.held_down]
    for _ in range(20):
        positions = np.vstack([block.positions + u[block.dofs], master])
        interface.follow(positions)
        interface.evaluate("hessian")
        contact = interface.forces(PENALTY)
        # Internal forces minus contact forces; the plate's motion is part of the first step.
        residual = block.stiffness @ u - contact
        norm, force = np.linalg.norm(residual[block.free]), np.linalg.norm(contact)
        if not step[block.held].any():
            residuals.append(float(norm / max(force, 1e-30)))
            if residuals[-1] < TOLERANCE:
                return residuals
        # Far from equilibrium ε N Nᵀ alone. The other forces are the plate's reactions.
        which = dc.adaptive_tangent(norm, max(force, np.linalg.norm(residual[block.held])))
        tangent = block.stiffness + interface.tangent(PENALTY, tangent=which)
        right = -(residual + tangent @ step)[block.free]
        free = tangent[block.free][:, block.free].tocsc()
        u[block.free] += scipy.sparse.linalg.spsolve(free, right)
        u += step
        step[:] = 0.0
    raise RuntimeError(f"Newton's iteration does not converge: {residuals}")


def press(degrees: float = 10.0, **options: str) -> Result:
    """Presses the block on a cylinder of such facets, with an interface of these options."""
    block = Block()
    master, facets = cylinder(degrees)
    nodes = len(block.positions)
    positions = np.vstack([block.positions, master])
    interface = dc.ContactInterface(
        dc.MasterSurface(positions, facets + nodes),
        np.unique(block.underside),
        positions,
        slave_facets=block.underside,
        dofs=np.vstack([block.dofs, np.full_like(master, -1, dtype=np.int64)]),
        equations=block.stiffness.shape[0],
        **options,
    )
    u = np.zeros(block.stiffness.shape[0])
    residuals = []
    for down in DEPTH * np.arange(1, INCREMENTS + 1) / INCREMENTS:
        interface.refresh_pairing(np.vstack([block.positions + u[block.dofs], master]))
        residuals.append(newton(block, interface, master, u, down))
    force = -float((block.stiffness @ u)[block.held_down].sum())
    pressure = float(interface.pressures(PENALTY).max())
    return Result(force, pressure, float(interface.contacts.penetration.max()), residuals)


def main() -> None:
    """Prints the three cases."""
    cases = {
        "diffuse, 10°": {},
        "node to facet, 10°": {"element": "node-to-facet"},
        "node to facet, 0.5°": {"degrees": 0.5, "element": "node-to-facet"},
    }
    for name, options in cases.items():
        result = press(**options)
        print(f"{name}: force {result.force:.6f}, pressure {result.pressure:.4f}, depth {result.penetration:.2e}")
        for increment, residuals in enumerate(result.residuals, 1):
            print(f"  increment {increment}: " + " ".join(f"{residual:.1e}" for residual in residuals))


if __name__ == "__main__":
    sys.exit(main())
