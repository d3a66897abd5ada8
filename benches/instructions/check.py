#!/usr/bin/env python3
"""Counts the instructions of the generated kernels under callgrind and compares them with the stored baseline.

    benches/instructions/check.py            exit code 1 if a count exceeds the baseline by more than the tolerance
    benches/instructions/check.py --update   writes the baseline instead

Instructions, unlike times, do not depend on how busy the machine is. They do on the compiler: with another one than the
baseline's the tolerance is wider. A case of the baseline that could not be counted is a failure. Needs valgrind.
"""

import argparse
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
BASELINE = HERE / "baseline.json"
# (shape, instruction set, nodes). Valgrind knows none of AVX-512, and not
# all versions know all of AVX2: what one does not know is left out.
CASES = [("single", "scalar", 12), ("single", "avx2", 12), ("batch", "avx2", 12)]
# Elements of a round in the program, and rounds that are counted.
ELEMENTS = 16
ROUNDS = 8
# Largest increase that passes, relative: with the baseline's compiler, and with another one.
TOLERANCE, OTHER_COMPILER = 0.03, 0.25


def build():
    """The program, optimised; its path."""
    command = ["cargo", "build", "--release", "-p", "diffuse-contact-benches", "--no-default-features"]
    command += ["--bin", "instructions"]
    command += ["--message-format", "json-render-diagnostics"]
    output = subprocess.run(command, cwd=HERE, check=True, stdout=subprocess.PIPE, text=True).stdout
    messages = [json.loads(line) for line in output.splitlines()]
    return next(
        message["executable"]
        for message in messages
        if message["reason"] == "compiler-artifact" and message["target"]["name"] == "instructions"
    )


def instructions(program, case, rounds):
    """Instructions of a whole run; None if valgrind does not know one of them."""
    shape, isa, nodes = case
    with tempfile.TemporaryDirectory() as folder:
        valgrind = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder}/out"]
        command = [*valgrind, program, shape, isa, str(nodes), str(rounds)]
        answer = subprocess.run(command, capture_output=True, text=True)
    if "unhandled instruction" in answer.stderr:
        return None
    found = re.search(r"Collected : (\d+)", answer.stderr)
    if answer.returncode or not found:
        sys.exit(f"error: {' '.join(command)}\n{answer.stderr}")
    return int(found[1])


def per_element(program, case):
    """Instructions an element: the difference of a run with rounds and one without."""
    counts = [instructions(program, case, rounds) for rounds in (ROUNDS, 0)]
    return None if None in counts else (counts[0] - counts[1]) / (ROUNDS * ELEMENTS)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--update", action="store_true", help="write the baseline")
    arguments = parser.parse_args()
    if not shutil.which("valgrind"):
        sys.exit("error: valgrind is not installed")
    program = build()
    compiler = subprocess.run(["rustc", "--version"], check=True, capture_output=True, text=True).stdout.strip()
    counts = {f"{shape} {isa} {nodes}": per_element(program, (shape, isa, nodes)) for shape, isa, nodes in CASES}
    for name in [name for name, count in counts.items() if count is None]:
        print(f"{name}: left out, this valgrind does not know all of its instructions")
        del counts[name]
    if arguments.update:
        text = json.dumps({"compiler": compiler, "instructions_per_element": counts}, indent=2)
        BASELINE.write_text(text + "\n")
        print(text)
        return
    stored = json.loads(BASELINE.read_text())
    baseline = stored["instructions_per_element"]
    tolerance = TOLERANCE if stored["compiler"] == compiler else OTHER_COMPILER
    if tolerance != TOLERANCE:
        print(f"the baseline is of {stored['compiler']}, this is {compiler}: {tolerance:.0%} more pass")
    missing = sorted(baseline.keys() - counts.keys())
    passes = bool(baseline) and not missing
    for name in missing:
        print(f"{name}: in the baseline, but NOT COUNTED")
    for name, count in counts.items():
        expected = baseline.get(name)
        if expected is None:
            print(f"{name}: {count:.0f} instructions an element")
            continue
        change = count / expected - 1
        sound = change <= tolerance
        passes &= sound
        verdict = "MORE" if not sound else "fewer: --update" if change < -tolerance else "ok"
        print(f"{name}: {count:.0f} instructions an element, baseline {expected:.0f}, {change:+.2%}, {verdict}")
    sys.exit(0 if passes else 1)


if __name__ == "__main__":
    main()
