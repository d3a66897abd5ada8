#!/usr/bin/env python3
"""What a call from Python costs beyond the Rust library, in nanoseconds an element: `overhead.py [elements] [rounds]`.

`cargo run --release --bin batch` evaluates a batch on request; the same elements go through `diffuse_contact.gap`,
in turns, on one thread. Both write to memory that is reused. The table has the best of all rounds, and the median of
the differences of neighbouring rounds. The first line is the cost of a call with a single element, kernel included:
spread over a batch it is all that does not grow with the batch. On a busy machine smaller batches are disturbed less.
"""

import subprocess
import sys
import time
from pathlib import Path

import numpy as np

import diffuse_contact as dc
from diffuse_contact import _native

PACKAGE = Path(__file__).resolve().parents[1]


def scene(count: int, nodes: int) -> tuple[np.ndarray, np.ndarray]:
    """Slaves (k, 3) and masters (k, n, 3)."""
    shift = np.arange(count) / count
    slaves = np.column_stack([0.2 * shift, np.full(count, 0.1), 0.05 - 0.1 * shift])
    k = np.arange(nodes)
    angle = 2.4 * k[np.newaxis, :] + shift[:, np.newaxis]
    r = np.sqrt((k + 0.5) / nodes)
    x, y = r * np.cos(angle), r * np.sin(angle)
    return slaves, np.stack([x, y, 0.1 * x - 0.1 * x * x + 0.05 * x * y], axis=-1)


class Rust:
    """The program that evaluates with the Rust library."""

    def __init__(self) -> None:
        command = ["cargo", "run", "--quiet", "--release", "--bin", "batch"]
        # The kernels that the module was compiled with need not be compiled again.
        if _native.HAS_FRICTION:
            command += ["--features", "friction"]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, cwd=PACKAGE, stdin=pipe, stdout=pipe, text=True)

    def evaluate(self, count: int, nodes: int, mode: str) -> float:
        """Nanoseconds an element."""
        self.process.stdin.write(f"{count} {nodes} {mode}\n")
        self.process.stdin.flush()
        return float(self.process.stdout.readline())


def python(slaves: np.ndarray, masters: np.ndarray, mode: str, out: dc.GapBatch) -> float:
    """Nanoseconds of a call."""
    start = time.perf_counter()
    dc.gap(slaves, masters, [0, 0, 1], support_radius=1.6, mode=mode, packed=True, out=out)
    return 1e9 * (time.perf_counter() - start)


def main() -> None:
    """Prints a table."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    rounds = int(sys.argv[2]) if len(sys.argv) > 2 else 100
    dc.set_threads(1)
    single = min(python(*scene(1, 9), "value", dc.GapBatch.empty(1, 9, "value", packed=True)) for _ in range(1000))
    print(f"one element: {single / 1000:.1f} µs a call, {single / count:.1f} ns an element of {count}\n")
    rust = Rust()
    print("| masters | mode | Rust, ns | Python, ns | best − best | median difference |")
    print("| ---: | --- | ---: | ---: | ---: | ---: |")
    for nodes in (9, 12, 16):
        slaves, masters = scene(count, nodes)
        for mode in ("value", "gradient", "hessian"):
            out = dc.GapBatch.empty(count, nodes, mode, packed=True)
            times = []
            for _ in range(rounds + 2):
                there = rust.evaluate(count, nodes, mode)
                times.append((there, python(slaves, masters, mode, out) / count))
            there, here = np.array(times[2:]).T
            best = f"{there.min():.0f} | {here.min():.0f} | {here.min() - there.min():+.0f}"
            print(f"| {nodes} | {mode} | {best} | {np.median(here - there):+.0f} |")


if __name__ == "__main__":
    main()
