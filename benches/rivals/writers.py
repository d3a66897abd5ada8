#!/usr/bin/env python3
"""How long wrenfold and SymPy take to write the surface's derivatives for few nodes, with the function of `model.py`.

    benches/rivals/writers.py [NODES]               6 unless said otherwise

SymPy's derivatives do not end: it is asked for them, one after the other, for `LIMIT` seconds.
"""

import multiprocessing
import re
import sys
import time
import typing

import sympy as sp
import wrenfold as wf
from wrenfold import sym

import model

# Seconds for SymPy.
LIMIT = 600


def surface(inputs, nodes, one, root):
    """f at a point, in a frame that is held, lengths over R; inputs are slave and nodes, then the point."""
    variables = [inputs[k] for k in range(3 * (nodes + 1))]
    offsets = [[variables[3 * (k + 1) + axis] - variables[axis] for k in range(nodes)] for axis in range(3)]
    # Nodes are terms of a sum that is written out.
    a, b, z = (Column(entries) for entries in offsets)
    alpha = model.coefficients(
        a, b, z, lambda terms: sum(terms.entries[1:], terms.entries[0]), lambda column: column.mapped(root)
    )
    point = [inputs[3 * (nodes + 1) + k] for k in range(2)]
    return variables, model.surface(alpha, one, point)


class Column:
    """Expressions of all nodes, with the operations of one."""

    def __init__(self, entries):
        self.entries = list(entries)

    def _with(self, other, operation):
        others = other.entries if isinstance(other, Column) else [other] * len(self.entries)
        return Column(operation(x, y) for x, y in zip(self.entries, others))

    def __add__(self, other):
        return self._with(other, lambda x, y: x + y)

    def __sub__(self, other):
        return self._with(other, lambda x, y: x - y)

    def __rsub__(self, other):
        return self._with(other, lambda x, y: y - x)

    def __mul__(self, other):
        return self._with(other, lambda x, y: x * y)

    __radd__, __rmul__ = __add__, __mul__

    def mapped(self, function):
        """The function of each of them."""
        return Column(map(function, self.entries))


def with_wrenfold(nodes, with_hessian):
    """Seconds to describe and to write the function, and its operations."""
    length = 3 * (nodes + 1) + 2

    def rival(inputs: typing.Annotated[sym.MatrixExpr, wf.Shape(rows=length, cols=1)]):
        variables, f = surface(inputs, nodes, sym.integer(1), sym.sqrt)
        gradient = sym.jacobian([f], variables).to_flat_list()
        outputs = [f, *gradient]
        if with_hessian:
            hessian = sym.jacobian(gradient, variables)
            outputs += [hessian[i, j] for i in range(len(variables)) for j in range(i + 1)]
        return [wf.OutputArg(sym.vector(*outputs), "out")]

    start = time.perf_counter()
    description = wf.create_function_description(rival)
    described = time.perf_counter()
    text = wf.CppGenerator().generate(wf.transpile(description))
    operations = re.search(r"// total: (\d+)", text).group(1)
    return described - start, time.perf_counter() - described, operations


def with_sympy(nodes, done):
    """Writes f and prints how; then its derivatives, one after the other. `done` counts those that are written."""
    start = time.perf_counter()
    inputs = sp.symbols(f"x0:{3 * (nodes + 1) + 2}")
    variables, f = surface(inputs, nodes, sp.Integer(1), sp.sqrt)
    described = time.perf_counter()
    steps, results = sp.cse([f], optimizations=[], order="none")
    written = time.perf_counter() - described
    operations = sum(value.count_ops() for _, value in steps) + results[0].count_ops()
    seconds = f"{described - start:.1f} s, written in {written:.1f} s"
    print(f"SymPy, n = {nodes}, f: {seconds}, {operations} operations", flush=True)
    for variable in variables:
        sp.cse([sp.diff(f, variable)], optimizations=[], order="none")
        done.value += 1


def main():
    nodes = int(sys.argv[1]) if len(sys.argv) > 1 else 6
    for name, with_hessian in (("f, gradient", False), ("f, gradient, Hessian", True)):
        described, written, operations = with_wrenfold(nodes, with_hessian)
        seconds = f"{described:.1f} s, written in {written:.1f} s"
        print(f"wrenfold, n = {nodes}, {name}: {seconds}, {operations} operations", flush=True)
    done = multiprocessing.Value("i", 0)
    process = multiprocessing.Process(target=with_sympy, args=(nodes, done))
    start = time.perf_counter()
    process.start()
    process.join(LIMIT)
    seconds = time.perf_counter() - start
    print(f"SymPy, n = {nodes}: {done.value} of {3 * (nodes + 1)} first derivatives after {seconds:.0f} s", flush=True)
    process.kill()


if __name__ == "__main__":
    main()
