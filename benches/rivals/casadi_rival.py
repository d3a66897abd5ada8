"""CasADi: symbolic expression, C code, compiler."""

import datetime
import json
import os
import pathlib
import subprocess
import time

import casadi as ca
import numpy as np

import model
from elements import HELD, split_held

HERE = pathlib.Path(__file__).parent
FLAGS = ["-O3", "-march=native"]


def function(what, nodes, cse):
    """Coordinates and what is held in one column -> value, gradient, lower triangle of the Hessian by columns."""
    size = 3 * (nodes + 1)
    inputs = ca.SX.sym("inputs", size + HELD)
    x = inputs[:size]
    frame, radius, point, foot, inverse = split_held([inputs[size + k] for k in range(HELD)])
    positions = ca.reshape(x, 3, nodes + 1).T
    offsets = (positions[1:, :] - ca.repmat(positions[0, :], nodes, 1)) / radius
    a, b, z = (offsets @ ca.vertcat(*frame[3 * k : 3 * k + 3]) for k in range(3))
    alpha = model.coefficients(a, b, z, ca.sum1, ca.sqrt)
    if what == "surface":
        value = model.surface(alpha, radius, point)
    else:
        value = model.gap(alpha, radius, foot, inverse, ca.sqrt)
    hessian, gradient = ca.hessian(value, x)
    return ca.Function("rival", [inputs], [value, gradient, ca.densify(ca.tril(hessian))], {"cse": cse})


class Rival:
    """The compiled function of one number of nodes."""

    name = "casadi"

    def __init__(self, folder, what, elements, cse=True):
        self.what, self.elements = what, elements
        stem = f"casadi-{ca.__version__}-{what}-{elements.nodes}" + ("" if cse else "-no-cse")
        folder = folder / stem
        self.program, self.facts_file = folder / "driver", folder / "facts.json"
        self.inputs_file, self.results_file = folder / "inputs.bin", folder / "results.bin"
        if not self.facts_file.exists():
            folder.mkdir(parents=True, exist_ok=True)
            self.build(folder, cse)
        # Of objects compiled before this was noted, the file tells the day.
        day = datetime.date.fromtimestamp(self.facts_file.stat().st_mtime).isoformat()
        self.facts = {"compiled": day, "load": None} | json.loads(self.facts_file.read_text())
        elements.inputs().astype(np.float64).tofile(self.inputs_file)

    def build(self, folder, cse):
        """C code, object file, driver; remembers times and sizes."""
        compiled_on, load = datetime.date.today().isoformat(), os.getloadavg()[0]
        start = time.perf_counter()
        code = function(self.what, self.elements.nodes, cse)
        generator = ca.CodeGenerator("rival.c", {"with_header": False})
        generator.add(code)
        generator.generate(f"{folder}/")
        generated = time.perf_counter()
        subprocess.run(["gcc", *FLAGS, "-c", "rival.c", "-o", "rival.o"], cwd=folder, check=True)
        compiled = time.perf_counter()
        driver = ["gcc", *FLAGS, "-DFUNCTION=rival", str(HERE / "driver.c"), "rival.o", "-lm", "-o", "driver"]
        subprocess.run(driver, cwd=folder, check=True)
        text = subprocess.run(["size", "rival.o"], cwd=folder, check=True, capture_output=True, text=True)
        facts = {
            "generate_s": generated - start,
            "compile_s": compiled - generated,
            "code_bytes": int(text.stdout.splitlines()[1].split()[0]),
            "operations": code.n_instructions(),
            "compiled": compiled_on,
            "load": load,
        }
        self.facts_file.write_text(json.dumps(facts))

    def run(self, seconds, results="-"):
        """Nanoseconds an element."""
        count = len(self.elements.coordinates)
        command = [self.program, self.inputs_file, str(count), str(seconds), results]
        answer = subprocess.run(command, check=True, capture_output=True)
        return json.loads(answer.stdout)["ns_per_element"]

    def difference(self):
        """Largest difference from the generated kernels."""
        self.run(0.0, self.results_file)
        size = 3 * (self.elements.nodes + 1)
        results = np.fromfile(self.results_file).reshape(len(self.elements.coordinates), -1)
        # Dense column-major squares with zeros above the diagonal.
        hessians = results[:, 1 + size :].reshape(-1, size, size).transpose(0, 2, 1)
        return self.elements.difference(self.what, results[:, 0], results[:, 1 : 1 + size], hessians)
