#!/usr/bin/env python3
"""Runs `cargo lab bench` and its rivals CasADi and JAX in turn, and writes docs/results/performance.md with its picture.

    python benches/rivals/run.py                 the whole report, into docs/results/
    python benches/rivals/run.py --nodes 9 --rounds 2 --docs target/rivals/trial

See README.md beside this file for what it needs.
"""

import argparse
import json
import os
import pathlib
import platform
import statistics
import subprocess
import sys
import tempfile
import time

import casadi
import jax

import casadi_rival
import jax_rival
import report
from elements import Elements

ROOT = pathlib.Path(__file__).resolve().parents[2]
# What everybody has to agree to with the generated kernels.
TOLERANCE = 1e-10
# Different elements, and elements in one call of JAX.
ELEMENTS, BATCH = 256, 1024
# CasADi's compile time grows with the fourth power of the number of nodes: the whole gap up to here.
MOST_NODES_OF_CASADI_GAP = 6
# Slave and master nodes of a whole interface.
SLAVES = 100_000
# A rival is timed so long in each round.
SECONDS = 0.5


def build(native):
    """Builds the program and the one that prints elements; their paths."""
    environment = dict(os.environ)
    # Cargo's folder, with one of its own for each set of flags.
    target = pathlib.Path(environment.get("CARGO_TARGET_DIR", ROOT / "target"))
    if native:
        environment["RUSTFLAGS"] = "-C target-cpu=native"
        target = target / "native"
        environment["CARGO_TARGET_DIR"] = str(target)
    profile = ["cargo", "build", "--profile", "bench"]
    subprocess.run([*profile, "-p", "diffuse-contact-laboratory"], cwd=ROOT, env=environment, check=True)
    examples = ["-p", "diffuse-contact-benches", "--example", "surface_elements"]
    if not native:
        subprocess.run([*profile, *examples], cwd=ROOT, env=environment, check=True)
    release = target / "release"
    return release / "diffuse-contact-laboratory", release / "examples" / "surface_elements"


def bench(program, nodes, kernels=()):
    """One run of the program: the report."""
    command = [program, "bench", "--json", "--rounds", "3", "--nodes", ",".join(map(str, nodes))]
    if kernels:
        command += ["--kernels", ",".join(kernels)]
    return json.loads(subprocess.run(command, check=True, capture_output=True).stdout)


def interface(program):
    """A whole interface on one thread: medians of three runs of `cargo lab study throughput`."""
    command = [program, "study", "throughput", "--nodes", str(SLAVES), "--threads", "1", "--json"]
    runs = [json.loads(subprocess.run(command, check=True, capture_output=True).stdout) for _ in range(3)]
    return {key: statistics.median(run[key] for run in runs) for key in runs[0] if runs[0][key] is not None}


def clean_build():
    """A release build of the kernels' crate into an empty folder: seconds, bytes of the library as Cargo leaves it and of
    the code in it (None if there is no `size`)."""
    load = os.getloadavg()[0]
    with tempfile.TemporaryDirectory() as target:
        environment = {**os.environ, "CARGO_TARGET_DIR": target}
        command = ["cargo", "build", "--release", "-p", "diffuse-contact-kernels"]
        start = time.perf_counter()
        subprocess.run(command, cwd=ROOT, env=environment, check=True)
        seconds = time.perf_counter() - start
        library = pathlib.Path(target) / "release" / "libdiffuse_contact_kernels.rlib"
        try:
            text = subprocess.run(["size", library], check=True, capture_output=True, text=True).stdout
            code = sum(int(line.split()[0]) for line in text.splitlines() if line.split()[0].isdigit())
        except (OSError, subprocess.CalledProcessError):
            code = None
        return {
            "seconds": seconds,
            "cores": len(os.sched_getaffinity(0)),
            "load": load,
            "library": library.stat().st_size,
            "code": code,
        }


def machine():
    """Processor, system and compilers."""
    def said(*command):
        return subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT).stdout.splitlines()

    changed = bool(said("git", "status", "--porcelain", "--untracked-files=no"))
    return {
        "system": f"{platform.system()} {platform.machine()}",
        "rustc": said("rustc", "--version")[0],
        "gcc": said("gcc", "--version")[0],
        "casadi": casadi.__version__,
        "jax": jax.__version__,
        "python": platform.python_version(),
        "commit": said("git", "rev-parse", "HEAD")[0] + (" with changes" if changed else ""),
    }


def rivals(folder, program, nodes):
    """All rivals for one number of nodes, compiled and compared."""
    elements = Elements(program, nodes, ELEMENTS)
    for what in ("surface", "gap"):
        if what == "surface" or nodes <= MOST_NODES_OF_CASADI_GAP:
            print(f"{nodes} nodes: CasADi, {what}", file=sys.stderr, flush=True)
            yield casadi_rival.Rival(folder, what, elements)
        print(f"{nodes} nodes: JAX, {what}", file=sys.stderr, flush=True)
        yield jax_rival.Rival(folder, what, elements, BATCH)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--nodes", default="6,9,12,16", help="numbers of master nodes of the rivals")
    parser.add_argument("--kernel-nodes", default="6,8,9,12,16,20,24", help="those of cargo lab bench")
    parser.add_argument("--rounds", type=int, default=5, help="rounds of which times are medians")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "target" / "rivals", help="folder for objects")
    parser.add_argument("--docs", type=pathlib.Path, default=ROOT / "docs" / "results", help="where the report goes")
    parser.add_argument(
        "--native",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="also a build for this processor alone, for the element by hand; minutes more",
    )
    arguments = parser.parse_args()
    nodes = [int(text) for text in arguments.nodes.split(",")]
    kernel_nodes = [int(text) for text in arguments.kernel_nodes.split(",")]
    folder = arguments.build.resolve()
    folder.mkdir(parents=True, exist_ok=True)

    # First, while the machine does nothing else.
    clean = clean_build()
    program, printer = build(native=False)
    native = build(native=True)[0] if arguments.native else None
    ring = [rival for count in nodes for rival in rivals(folder, printer, count)]
    agreement = {}
    for rival in ring:
        difference = rival.difference()
        agreement[rival.name] = max(difference, agreement.get(rival.name, 0.0))
        if not difference <= TOLERANCE:
            sys.exit(f"error: {rival.name} {rival.what}, {rival.elements.nodes} nodes: differs by {difference:e}")

    times, reports, natives = {}, [], []
    for turn in range(arguments.rounds):
        print(f"round {turn + 1} of {arguments.rounds}", file=sys.stderr, flush=True)
        reports.append(bench(program, kernel_nodes))
        if native:
            natives.append(bench(native, kernel_nodes, ["generated", "by-hand"]))
        for rival in ring:
            key = (rival.elements.nodes, rival.name, rival.what)
            times.setdefault(key, []).append(rival.run(SECONDS))
    rows = report.median_rows(reports)
    for (count, name, what), values in times.items():
        rows.append({"nodes": count, "kernel": name, "output": f"{what}-hessian", "ns": statistics.median(values)})
    result = {
        **machine(),
        "machine": reports[0]["machine"],
        "isa": reports[0]["isa"],
        "compiled_for": reports[0]["compiled_for"],
        "peak": statistics.median(one["peak_fma_per_ns"] for one in reports),
        "rounds": arguments.rounds,
        "rows": rows,
        "native_rows": report.median_rows(natives),
        "native_isa": natives[0]["compiled_for"] if natives else None,
        "agreement": agreement,
        "compile": [
            {"kernel": rival.name, "what": rival.what, "nodes": rival.elements.nodes, **rival.facts} for rival in ring
        ],
        "clean_build": clean,
        "interface": interface(program),
    }
    for rival in ring:
        if hasattr(rival, "close"):
            rival.close()
    (folder / "result.json").write_text(json.dumps(result, indent=1))
    report.write(result, arguments.docs)


if __name__ == "__main__":
    main()
