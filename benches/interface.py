#!/usr/bin/env python3
"""Time of g, N and M of a whole interface per slave, beside an older commit in the same run.

    python benches/interface.py 51eb4e6 [--rounds 7] [--side 317]

Builds `benches/examples/interface.rs` here and, in a work tree of its own that is removed afterwards, as an example of the runtime at the
other commit. Both run in turn on one thread. What counts is the least time of each, and the median of the ratios of neighbouring runs.
"""

import argparse
import os
import pathlib
import shutil
import statistics
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
EXAMPLE = pathlib.Path("benches/examples/interface.rs")
# Where it goes at the other commit: packages there may be others, the runtime is one of them.
ELSEWHERE = pathlib.Path("runtime/examples/interface.rs")
ENVIRONMENT = {**os.environ, "RAYON_NUM_THREADS": "1"}


def build(root: pathlib.Path, target: pathlib.Path, package: str) -> pathlib.Path:
    """The program of a tree, with its default features."""
    subprocess.run(
        ["cargo", "build", "--release", "-p", package, "--example", "interface", "--target-dir", str(target)],
        cwd=root,
        check=True,
    )
    return target / "release" / "examples" / "interface"


def times(program: pathlib.Path, side: int) -> dict[str, float]:
    """Microseconds per slave of one run: the least of each kind."""
    command = [str(program), str(side), "5"]
    printed = subprocess.run(command, check=True, capture_output=True, text=True, env=ENVIRONMENT).stdout
    found: dict[str, float] = {}
    for line in printed.splitlines():
        name, value = line.split()
        found[name] = min(found.get(name, float("inf")), float(value))
    return found


def main() -> None:
    """Measures and prints."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("commit", help="what to compare with")
    parser.add_argument("--rounds", type=int, default=7, help="runs of each [default: 7]")
    parser.add_argument("--side", type=int, default=317, help="slaves along a side [default: 317, 100,489 slaves]")
    arguments = parser.parse_args()
    here = build(ROOT, ROOT / "target", "diffuse-contact-benches")
    with tempfile.TemporaryDirectory() as folder:
        other = pathlib.Path(folder) / "tree"
        subprocess.run(["git", "worktree", "add", "--detach", str(other), arguments.commit], cwd=ROOT, check=True)
        try:
            (other / ELSEWHERE).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / EXAMPLE, other / ELSEWHERE)
            there = build(other, pathlib.Path(folder) / "target", "diffuse-contact")
            runs = [(times(there, arguments.side), times(here, arguments.side)) for _ in range(arguments.rounds)]
        finally:
            subprocess.run(["git", "worktree", "remove", "--force", str(other)], cwd=ROOT, check=True)
    print(f"| µs per slave | {arguments.commit} | here | here over {arguments.commit}, median (least, largest) |")
    print("| --- | ---: | ---: | ---: |")
    for kind in runs[0][0]:
        old, new = (min(run[k][kind] for run in runs) for k in (0, 1))
        ratios = [new[kind] / old[kind] for old, new in runs]
        spread = f"{statistics.median(ratios):.2f} ({min(ratios):.2f}, {max(ratios):.2f})"
        print(f"| {kind} | {old:.2f} | {new:.2f} | {spread} |")


if __name__ == "__main__":
    main()
