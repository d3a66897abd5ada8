#!/usr/bin/env python3
"""What assembly from Python costs, microseconds a slave, and its memory: `assembly.py [slaves] [rounds]`.

As many slaves as master nodes, on wavy surfaces that touch everywhere: every slave carries force, which is the worst
case. Evaluations keep N alone, and M is evaluated while it is added: the time of an evaluation with M stands beside it.
Wall clock, the best of some rounds. The last line is the largest memory that the process had before it held every M.
"""

import resource
import sys
import time
from collections.abc import Callable

import numpy as np

import diffuse_contact as dc


def scene(side: int) -> tuple[dc.ContactInterface, np.ndarray]:
    """An interface of `side`² slaves just inside as many master nodes, and the positions."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(float(side)), np.arange(float(side))))
    height = 0.2 * np.sin(0.4 * x) * np.cos(0.3 * y)
    master = np.column_stack([x, y, height])
    cells = np.arange((side - 1) ** 2)
    corner = cells % (side - 1) + side * (cells // (side - 1))
    facets = np.column_stack([corner, corner + 1, corner + side + 1, corner + side])
    within = np.clip(np.column_stack([x, y]) + [0.31, 0.17], 0.0, side - 1.001)
    lift = 0.2 * np.sin(0.4 * within[:, 0]) * np.cos(0.3 * within[:, 1]) - 0.01
    positions = np.vstack([master, np.column_stack([within, lift])])
    slaves = np.arange(side**2, 2 * side**2)
    return dc.ContactInterface(dc.MasterSurface(positions, facets), slaves, positions), positions


def best(rounds: int, work: Callable[[], object]) -> float:
    """The shortest of some rounds, seconds."""
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


def main() -> None:
    """Prints a table."""
    side = round(float(sys.argv[1]) ** 0.5) if len(sys.argv) > 1 else 317
    rounds = int(sys.argv[2]) if len(sys.argv) > 2 else 5
    interface, positions = scene(side)
    slaves = side**2
    interface.refresh_pairing(positions)
    gradient = best(rounds, lambda: interface.evaluate("gradient"))
    start = time.perf_counter()
    columns = interface.pattern()[1]
    pattern = time.perf_counter() - start
    again = best(rounds, interface.pattern)
    values = np.zeros(len(columns))
    streamed = best(rounds, lambda: interface.tangent_values(1e3, out=values))
    matrix = best(rounds, lambda: interface.tangent(1e3))
    operator = best(rounds, lambda: interface.operator(1e3))
    product, v = interface.operator(1e3), np.ones(interface.equations)
    multiply = best(rounds, lambda: product @ v)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    # With every M held, for comparison; that memory does not count.
    hessian = best(rounds, lambda: interface.evaluate("hessian"))
    held = best(rounds, lambda: interface.tangent_values(1e3, out=values))
    print(f"{slaves} slaves, {values.size / slaves:.0f} entries each, {dc.thread_count()} threads; µs a slave\n")
    for what, seconds in (
        ("evaluate('gradient')", gradient),
        ("pattern, the first time", pattern),
        ("pattern, again", again),
        ("tangent added, M in passing", streamed),
        ("tangent, a new matrix, M in passing", matrix),
        ("evaluate('hessian')", hessian),
        ("tangent added, M held", held),
        ("M in passing less evaluate('hessian')", streamed - hessian),
        ("operator made", operator),
        ("product", multiply),
    ):
        print(f"{what:<40} {1e6 * seconds / slaves:8.2f}")
    print(f"\nlargest memory without M held: {memory:.2f} GB")


if __name__ == "__main__":
    main()
