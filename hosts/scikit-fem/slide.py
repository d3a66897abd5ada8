#!/usr/bin/env python3
"""An elastic block pushed along a rigid plane with friction: scikit-fem assembles the solid, contact is over its faces.

The block of ``press`` stands on a plane whose facets match none of its nodes. Its upper face, bonded to a rigid
plate, goes down by 0.02, then sideways by 0.06. When all of the underside slides, the push is μ = 0.3 of the pressing
force, but for what its corners slide sideways.

1. `start` makes a ``FaceInterface`` over nodes of block and plane, those of the plane without equations.
2. `newton` balances internal and contact forces. The tangent is not symmetric.
3. `push` accepts each increment that has converged: friction of the next one is measured from there. A solver that cuts
   an increment back has nothing to undo.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, field

import numpy as np
import scipy.sparse.linalg
from press import Block

import diffuse_contact as dc

FRICTION, PENALTY, TOLERANCE = 0.3, 2e3, 1e-11
#: Where the plate goes: along x and z, from increment to increment.
WAY = [(0.0, -0.02), (0.02, -0.02), (0.04, -0.02), (0.06, -0.02)]


@dataclass
class Increment:
    """What the tests look at."""

    #: Force of the plate along x, and down.
    push: float
    force: float
    report: dc.FrictionReport
    #: Residual over the contact forces at each iteration.
    residuals: list[float] = field(default_factory=list)


def plane(cells: int = 5) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and facets, outside up, of a plane from −5 to 5."""
    side = np.linspace(-5.0, 5.0, cells + 1)
    x, y = (grid.ravel() for grid in np.meshgrid(side, side))
    first = (np.arange(cells)[:, np.newaxis] * (cells + 1) + np.arange(cells)).ravel()
    facets = np.column_stack([first, first + 1, first + cells + 2, first + cells + 1])
    return np.column_stack([x, y, np.zeros_like(x)]), facets


def start(block: Block, master: np.ndarray, facets: np.ndarray, **options: str) -> dc.FaceInterface:
    """The underside over the plane, in touch and without history."""
    positions = np.vstack([block.positions, master])
    interface = dc.FaceInterface(
        dc.MasterSurface(positions, facets + len(block.positions)),
        block.underside,
        positions,
        dofs=np.vstack([block.dofs, np.full_like(master, -1, dtype=np.int64)]),
        equations=block.stiffness.shape[0],
        **options,
    )
    interface.refresh(positions)
    interface.accept(PENALTY, friction=FRICTION)
    return interface


def newton(
    block: Block, interface: dc.FaceInterface, master: np.ndarray, u: np.ndarray, plate: np.ndarray
) -> list[float]:
    """Brings ``u`` into balance with the plate's displacements; the relative residuals of the iterations."""
    residuals: list[float] = []
    step = np.zeros_like(u)
    step[block.held] = plate[block.held] - u[block.held]
    for _ in range(20):
        interface.update(np.vstack([block.positions + u[block.dofs], master]))
        interface.evaluate(PENALTY, friction=FRICTION)
        contact = interface.forces()
        residual = block.stiffness @ u - contact
        if not step.any():
            residuals.append(float(np.linalg.norm(residual[block.free]) / max(np.linalg.norm(contact), 1e-30)))
            if residuals[-1] < TOLERANCE:
                return residuals
        tangent = block.stiffness + interface.tangent()
        right = -(residual + tangent @ step)[block.free]
        free = tangent[block.free][:, block.free].tocsc()
        u[block.free] += scipy.sparse.linalg.spsolve(free, right)
        u += step
        step[:] = 0.0
    raise RuntimeError(f"Newton's iteration does not converge: {residuals}")


def push(**options: str) -> list[Increment]:
    """Presses the block on the plane and pushes it, with an interface of these options."""
    block = Block((8, 3, 3))
    master, facets = plane()
    interface = start(block, master, facets, **options)
    u, plate = np.zeros(block.stiffness.shape[0]), np.zeros(block.stiffness.shape[0])
    top = block.dofs[np.isclose(block.positions[:, 2], 3.0)]
    increments = []
    for along, down in WAY:
        interface.refresh(np.vstack([block.positions + u[block.dofs], master]))
        plate[top[:, 0]], plate[top[:, 2]] = along, down
        residuals = newton(block, interface, master, u, plate)
        reaction = block.stiffness @ u
        forces = float(reaction[top[:, 0]].sum()), -float(reaction[top[:, 2]].sum())
        increments.append(Increment(*forces, interface.accept(PENALTY, friction=FRICTION), residuals))
    return increments


def main() -> None:
    """Prints every increment."""
    for element in ("diffuse", "node-to-facet"):
        for increment in push(element=element):
            report = increment.report
            print(
                f"{element}: push over force {increment.push / increment.force:.6f}, {report.stuck} stick, "
                f"{report.sliding} slide, work {report.dissipated:.6f}; "
                + " ".join(f"{residual:.1e}" for residual in increment.residuals)
            )


if __name__ == "__main__":
    sys.exit(main())
