#!/usr/bin/env python3
"""What a call from Python costs beyond the Rust library, in nanoseconds an element, in batches of 10⁴.

Runs `cargo run --release --example batch` and the same elements through `diffuse_contact.gap`, in turns, on one thread.
Both keep the best of many rounds and write to memory that is reused. On a busy machine the difference is noise: run it
on a quiet one.
"""

import subprocess
import sys
import time
from pathlib import Path

import diffuse_contact as dc
import numpy as np

ELEMENTS = 10_000
PACKAGE = Path(__file__).resolve().parents[1]


def scene(nodes: int) -> tuple[np.ndarray, np.ndarray]:
    """Slaves (k, 3) and masters (k, n, 3)."""
    shift = np.arange(ELEMENTS) / ELEMENTS
    slaves = np.column_stack([0.2 * shift, np.full(ELEMENTS, 0.1), 0.05 - 0.1 * shift])
    k = np.arange(nodes)
    angle = 2.4 * k[np.newaxis, :] + shift[:, np.newaxis]
    r = np.sqrt((k + 0.5) / nodes)
    x, y = r * np.cos(angle), r * np.sin(angle)
    return slaves, np.stack([x, y, 0.1 * x - 0.1 * x * x + 0.05 * x * y], axis=-1)


def from_rust(rounds: int) -> dict[tuple[int, str], float]:
    """Nanoseconds an element by nodes and mode."""
    command = ["cargo", "run", "--quiet", "--release", "--example", "batch", "--", str(rounds)]
    text = subprocess.run(command, cwd=PACKAGE, check=True, capture_output=True, text=True).stdout
    return {(int(nodes), mode): float(ns) for nodes, mode, ns in map(str.split, text.splitlines())}


def from_python(nodes: int, mode: str, rounds: int) -> float:
    """Nanoseconds an element."""
    slaves, masters = scene(nodes)
    out = dc.GapBatch.empty(ELEMENTS, nodes, mode, packed=True)
    best = float("inf")
    for _ in range(rounds):
        start = time.perf_counter()
        dc.gap(slaves, masters, [0, 0, 1], support_radius=1.6, mode=mode, packed=True, out=out)
        best = min(best, time.perf_counter() - start)
    return 1e9 * best / ELEMENTS


def main() -> None:
    """Prints a table."""
    rounds, turns = 60, int(sys.argv[1]) if len(sys.argv) > 1 else 3
    dc.set_threads(1)
    rust: dict[tuple[int, str], float] = {}
    python: dict[tuple[int, str], float] = {}
    for _ in range(turns):
        for key, ns in from_rust(rounds).items():
            rust[key] = min(rust.get(key, ns), ns)
            python[key] = min(python.get(key, float("inf")), from_python(*key, rounds))
    print("| masters | mode | Rust, ns | Python, ns | difference |\n| ---: | --- | ---: | ---: | ---: |")
    for (nodes, mode), ns in rust.items():
        print(f"| {nodes} | {mode} | {ns:.0f} | {python[nodes, mode]:.0f} | {python[nodes, mode] - ns:+.0f} |")


if __name__ == "__main__":
    main()
