#!/usr/bin/env python3
"""An element of one's own, a neo-Hooke tetrahedron from its energy, beside CasADi, SymPy, wrenfold, num-dual and nalgebra, all in one run;
writes docs/results/own-elements.md.

    python benches/rivals/own_elements.py                 the page
    python benches/rivals/own_elements.py --rounds 1 --docs target/rivals/trial

Needs Rust, gcc, g++, `size` and `nm` of the binutils, and the packages of requirements.txt.
"""

import argparse
import importlib.metadata
import inspect
import json
import os
import pathlib
import platform
import re
import statistics
import subprocess
import time
import typing

import casadi as ca
import numpy as np
import sympy as sp
import wrenfold as wf
from wrenfold import sym

from tables import duration, table

ROOT = pathlib.Path(__file__).resolve().parents[2]
HERE = pathlib.Path(__file__).parent
FLAGS = ["-O3", "-march=native"]
TOLERANCE = 1e-10
# SymX, ACM TOG 45(1):5, 2026: one thread of a Ryzen 9 5900X, batches with AVX2.
SYMX = {"operations": 1833, "batch": 54.1, "single": 204.9, "differentiate": 0.37e-3, "write": 0.6e-3, "compile": 0.33}
# On a machine of so many fused multiply-adds a nanosecond the hexahedron's time was asked for.
ASKED_PEAK = 29.0


def with_casadi(inputs):
    x, X, lam, mu = ca.reshape(inputs[:12], 3, 4), ca.reshape(inputs[12:24], 3, 4), inputs[24], inputs[25]
    d, D = (ca.horzcat(*(y[:, k] - y[:, 0] for k in (1, 2, 3))) for y in (x, X))
    F = d @ ca.inv(D)
    L = ca.log(ca.det(F))
    W = mu / 2 * (ca.sumsqr(F) - 3) - mu * L + lam / 2 * L**2
    energy = ca.det(D) / 6 * W
    hessian, gradient = ca.hessian(energy, inputs[:12])
    return ca.Function("casadi", [inputs], [energy, gradient, hessian], {"cse": True})


def with_sympy(inputs):
    x, X, lam, mu = (sp.Matrix(4, 3, inputs[:12]).T, sp.Matrix(4, 3, inputs[12:24]).T, inputs[24], inputs[25])
    d, D = (sp.Matrix(3, 3, lambda i, k: y[i, k + 1] - y[i, 0]) for y in (x, X))
    # Of the entries themselves the derivatives do not end in minutes: the inverse stays a matrix of symbols, with its definition beside it.
    B = sp.Matrix(3, 3, sp.symbols("B0:9"))
    F = sp.Matrix(3, 3, lambda i, j: sum(d[i, k] * B[k, j] for k in range(3)))
    det = lambda A: sum(
        A[0, i] * (A[1, j] * A[2, k] - A[1, k] * A[2, j]) for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
    )
    L = sp.log(det(F))
    W = mu / 2 * (sum(f**2 for f in F) - 3) - mu * L + lam / 2 * L**2
    volume = sp.Symbol("volume")
    energy = volume / 6 * W
    gradient = [sp.diff(energy, x) for x in inputs[:12]]
    hessian = [sp.diff(gradient[i], inputs[j]) for i in range(12) for j in range(i + 1)]
    cofactor = lambda i, j: (
        D[(i + 1) % 3, (j + 1) % 3] * D[(i + 2) % 3, (j + 2) % 3]
        - D[(i + 1) % 3, (j + 2) % 3] * D[(i + 2) % 3, (j + 1) % 3]
    )
    inverse = [(volume, det(D)), *((B[j, i], cofactor(i, j) / volume) for i in range(3) for j in range(3))]
    return inverse, sp.cse([energy, *gradient, *hessian], optimizations=[], order="none")


def with_wrenfold(inputs: typing.Annotated[sym.MatrixExpr, wf.Shape(rows=26, cols=1)]):
    x, X = (sym.matrix([[inputs[at + 3 * k + i] for k in range(4)] for i in range(3)]) for at in (0, 12))
    lam, mu = inputs[24], inputs[25]
    d, D = (sym.hstack([y[:, k] - y[:, 0] for k in (1, 2, 3)]) for y in (x, X))
    cofactor = lambda i, j: (
        D[(i + 1) % 3, (j + 1) % 3] * D[(i + 2) % 3, (j + 2) % 3]
        - D[(i + 1) % 3, (j + 2) % 3] * D[(i + 2) % 3, (j + 1) % 3]
    )
    F = d * sym.matrix([[cofactor(j, i) / sym.det(D) for j in range(3)] for i in range(3)])
    L = sym.log(sym.det(F))
    W = mu / 2 * (F.squared_norm() - 3) - mu * L + lam / 2 * L**2
    energy = sym.det(D) / 6 * W
    variables = [inputs[k] for k in range(12)]
    gradient = sym.jacobian([energy], variables).to_flat_list()
    hessian = sym.jacobian(gradient, variables)
    packed = [hessian[i, j] for i in range(12) for j in range(i + 1)]
    return [wf.OutputArg(sym.vector(energy, *gradient, *packed), "out")]


def lines(text):
    """Lines that are no comment, no documentation and not empty."""
    return sum(1 for line in text.splitlines() if line.strip() and not line.strip().startswith(("//", "#", '"""')))


def rust_lines(path, function):
    """Lines of a Rust function."""
    text = (ROOT / path).read_text()
    return lines(re.search(rf"^(pub )?fn {function}\b.*?^}}", text, re.S | re.M).group(0))


def casadi_code(folder):
    """C source of a function `rival(in, out)`, operations, and how long it took."""
    start = time.perf_counter()
    function = with_casadi(ca.SX.sym("inputs", 26))
    differentiated = time.perf_counter()
    generator = ca.CodeGenerator("casadi.c", {"with_header": False})
    generator.add(function)
    generator.generate(f"{folder}/")
    written = time.perf_counter()
    # Results: energy, gradient, and of the symmetric matrix one triangle by rows.
    adapter = f"""#include "casadi.c"
void rival(const double *in, double *out) {{
    static double full[144], w[{max(function.sz_w(), 1)}];
    const double *arg[{max(function.sz_arg(), 1)}] = {{in}};
    double *res[{max(function.sz_res(), 3)}] = {{out, out + 1, full}};
    casadi(arg, res, 0, w, 0);
    for (int i = 0, k = 13; i < 12; i++) for (int j = 0; j <= i; j++) out[k++] = full[12 * i + j];
}}
"""
    return adapter, function.n_instructions(), differentiated - start, written - differentiated


def sympy_code(folder):
    """As `casadi_code`."""
    start = time.perf_counter()
    inputs = list(sp.symbols("in0:26"))
    inverse, (parts, outputs) = with_sympy(inputs)
    differentiated = time.perf_counter()
    body = [f"const double {symbol} = in[{k}];" for k, symbol in enumerate(inputs)]
    names = {symbol: sp.Symbol(f"t{k}") for k, (symbol, _) in enumerate(parts)}
    operations = 0
    for symbol, expression in inverse:
        body.append(f"const double {symbol} = {sp.ccode(expression)};")
        operations += sp.count_ops(expression)
    for symbol, expression in parts:
        body.append(f"const double {names[symbol]} = {sp.ccode(expression.xreplace(names))};")
        operations += sp.count_ops(expression)
    for k, expression in enumerate(outputs):
        body.append(f"out[{k}] = {sp.ccode(expression.xreplace(names))};")
        operations += sp.count_ops(expression)
    text = "#include <math.h>\nvoid rival(const double *in, double *out) {\n" + "\n".join(body) + "\n}\n"
    written = time.perf_counter()
    return text, int(operations), differentiated - start, written - differentiated


def wrenfold_code(_):
    """As `casadi_code`, in C++."""
    start = time.perf_counter()
    description = wf.create_function_description(with_wrenfold)
    differentiated = time.perf_counter()
    text = wf.CppGenerator().generate(wf.transpile(description))
    written = time.perf_counter()
    adapter = """#include <cmath>
#include "span.h"
%s
extern "C" void rival(const double *in, double *out) {
    const auto span = [](auto *data, auto rows) {
        return wf::make_span(data, rows, wf::make_constant_value_pack<1, 0>());
    };
    with_wrenfold<double>(
        span(in, wf::make_constant_value_pack<26, 1>()), span(out, wf::make_constant_value_pack<91, 1>()));
}
"""
    operations = int(re.search(r"// total: (\d+)", text).group(1))
    return adapter % text, operations, differentiated - start, written - differentiated


def wrenfold_headers():
    """The folder of the headers that its C++ includes."""
    files = importlib.metadata.files("wrenfold") or []
    return next(pathlib.Path(file.locate()).resolve().parent for file in files if file.name == "span.h")


def compiled(folder, name, text, compiler=("gcc",)):
    """A driver with this code: its path, seconds to compile the code, bytes of its functions."""
    source = f"{name}_rival.{'c' if compiler[0] == 'gcc' else 'cc'}"
    (folder / source).write_text(text)
    start = time.perf_counter()
    subprocess.run([*compiler, *FLAGS, "-c", source, "-o", f"{name}.o"], cwd=folder, check=True)
    seconds = time.perf_counter() - start
    size = subprocess.run(["size", f"{name}.o"], cwd=folder, check=True, capture_output=True, text=True).stdout
    driver = ["gcc", "-O2", str(HERE / "own_elements.c"), f"{name}.o", "-lm", "-o", f"{name}"]
    subprocess.run(driver, cwd=folder, check=True)
    return folder / name, seconds, int(size.splitlines()[1].split()[0])


def run(program, inputs_file, count, seconds, results_file="-"):
    """Nanoseconds an element."""
    command = [program, inputs_file, str(count), str(seconds), results_file]
    return json.loads(subprocess.run(command, check=True, capture_output=True).stdout)["ns"]


def user_crate(folder):
    """The book's crate beside a clone, outside of the workspace: seconds from a change of the formula to the program."""
    page = (ROOT / "docs" / "how-to" / "own-element.md").read_text()
    blocks = re.findall(r"```(\S*)\n(.*?)```", page, re.S)
    manifest = next(text for kind, text in blocks if kind == "toml")
    rust = [text for kind, text in blocks if kind.startswith("rust")]
    crate = folder / "my-element"
    (crate / "src").mkdir(parents=True, exist_ok=True)
    clone = folder / "diffuse-contact"
    if not clone.exists():
        clone.symlink_to(ROOT)
    package = '[package]\nname = "my-element"\nversion = "0.1.0"\nedition = "2024"\n\n[workspace]\n\n'
    (crate / "Cargo.toml").write_text(package + manifest)
    (crate / "build.rs").write_text(rust[0])
    (crate / "src" / "main.rs").write_text(next(text for text in rust if "include!" in text))
    environment = {name: value for name, value in os.environ.items() if name != "CARGO_TARGET_DIR"}
    build = ["cargo", "build", "--release", "--quiet"]
    subprocess.run(build, cwd=crate, env=environment, check=True)
    seconds = []
    for factor in ("0.51", "0.52", "0.5"):
        (crate / "build.rs").write_text(rust[0].replace("0.5 * mu", f"{factor} * mu"))
        start = time.perf_counter()
        subprocess.run(build, cwd=crate, env=environment, check=True)
        seconds.append(time.perf_counter() - start)
    return min(seconds)


def text_bytes(program, name):
    """Bytes of the functions of a generated module: all modes and instructions."""
    listing = subprocess.run(["nm", "-SC", program], check=True, capture_output=True, text=True).stdout
    rows = (line.split(maxsplit=3) for line in listing.splitlines())
    return sum(
        int(row[1], 16)
        for row in rows
        if len(row) == 4 and row[2] in "tT" and row[3].startswith(f"diffuse_contact_benches::tetrahedron::{name}::")
    )


def header_code(header):
    """The generated C header with the drivers' functions: one element, and many."""
    single = """void rival(const double *in, double *out) {
    tet4_inputs inputs;
    tet4_values values;
    memcpy(&inputs, in, sizeof inputs);
    tet4_hessian(&inputs, &values, out + 1, out + 13);
    out[0] = values.energy;
}
"""
    batch = """void rival_batch(size_t count, const double *restrict in, double *restrict out) {
    tet4_hessian_batch(count, in, out, out + count, out + 13 * count);
}
"""
    start = header + "#include <string.h>\n"
    return start + single, start + batch


def measured(arguments, folder):
    """All figures."""
    build = ["cargo", "build", "--release", "-p", "diffuse-contact-benches", "--example", "own_elements"]
    subprocess.run(build, cwd=ROOT, check=True)
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    program = target / "release" / "examples" / "own_elements"
    header = subprocess.run([program, "c"], check=True, capture_output=True, text=True).stdout
    single, batch = header_code(header)
    facts, drivers = {}, {}
    cpp = ("g++", "-std=c++17", f"-I{wrenfold_headers()}")
    for name, code, compiler in (
        ("CasADi", casadi_code, ("gcc",)),
        ("SymPy", sympy_code, ("gcc",)),
        ("wrenfold", wrenfold_code, cpp),
    ):
        text, operations, differentiate, write = code(folder)
        drivers[name], seconds, size = compiled(folder, name.lower(), text, compiler)
        facts[name] = {
            "operations": operations,
            "differentiate": differentiate,
            "write": write,
            "compile": seconds,
            "bytes": size,
        }
    drivers["C single"], seconds, size = compiled(folder, "single", single)
    facts["C single"] = {"compile": seconds, "bytes": size}
    flags = ["-ffast-math", "-DBATCH"]
    drivers["C batch"] = compiled_batch(folder, batch, flags)

    reports, times = [], {name: [] for name in drivers}
    for turn in range(arguments.rounds):
        print(f"round {turn + 1} of {arguments.rounds}", flush=True)
        reports.append(
            json.loads(subprocess.run([program, str(arguments.seconds)], check=True, capture_output=True).stdout)
        )
        inputs, expected = np.array(reports[-1]["inputs"]), np.array(reports[-1]["results"])
        for name, driver in drivers.items():
            files = folder / "inputs.bin", folder / "results.bin"
            # Columns a power of two apart would share a few lines of the cache.
            by_columns, count = name == "C batch", len(inputs) - 8
            (inputs[:count].T if by_columns else inputs[:count]).astype(float).tofile(files[0])
            times[name].append(run(driver, files[0], count, arguments.seconds, files[1]))
            found = np.fromfile(files[1])
            found = found.reshape(91, -1).T if by_columns else found.reshape(-1, 91)
            worst = np.max(np.abs(found - expected[:count])) / np.max(np.abs(expected))
            if not worst < TOLERANCE:
                raise SystemExit(f"error: {name} differs by {worst:e}")
    ns = {key: statistics.median(one["ns"][key] for one in reports) for key in reports[0]["ns"]}
    ns |= {name: statistics.median(values) for name, values in times.items()}
    bytes_of = {name: text_bytes(program, name) for name in ("tet4", "hex8")}
    last = {key: reports[-1][key] for key in ("isa", "operations", "generate_s")}
    peak = statistics.median(one["peak_fma_per_ns"] for one in reports)
    return {
        "ns": ns,
        "facts": facts,
        "bytes": bytes_of,
        "peak": peak,
        "rebuild": user_crate(arguments.user.resolve()),
        **last,
    }


def compiled_batch(folder, text, flags):
    """The driver of the batch in C."""
    (folder / "batch_rival.c").write_text(text)
    subprocess.run(["gcc", *FLAGS, *flags, "-c", "batch_rival.c", "-o", "batch.o"], cwd=folder, check=True)
    driver = ["gcc", "-O2", "-DBATCH", str(HERE / "own_elements.c"), "batch.o", "-lm", "-lmvec", "-o", "batch"]
    subprocess.run(driver, cwd=folder, check=True)
    return folder / "batch"


def seconds(value):
    """A time given in seconds."""
    return f"{value:.3g} s" if value >= 1 else duration(1e9 * value)


def kilobytes(value):
    """Bytes in thousands."""
    return f"{value / 1000:.3g} kB"


def page(found):
    """The page."""
    ns, facts, isa = found["ns"], found["facts"], found["isa"]
    batch, hexahedron = ns[f"generated, batch, {isa}"], ns[f"hex8, batch, {isa}"]
    python = {"CasADi, C": with_casadi, "SymPy, C": with_sympy, "wrenfold, C++": with_wrenfold}
    rows = [
        [
            "this generator, single",
            str(rust_lines("benches/formulas.rs", "tet4")),
            str(found["operations"]["tet4"]),
            kilobytes(found["bytes"]["tet4"]),
            seconds(found["generate_s"]),
            seconds(found["rebuild"]),
            duration(ns["generated, single"]),
        ],
        [f"this generator, batch, {isa}", "same", "same", "same", "same", "same", duration(batch)],
        [
            "this generator, C, single",
            "same",
            "same",
            kilobytes(facts["C single"]["bytes"]),
            "same",
            seconds(facts["C single"]["compile"]),
            duration(ns["C single"]),
        ],
        ["this generator, C, batch", "same", "same", "", "same", "", duration(ns["C batch"])],
    ]
    for title, function in python.items():
        name = title.split(",")[0]
        fact = facts[name]
        rows.append(
            [
                title,
                str(lines(inspect.getsource(function))),
                f"{fact['operations']:,}",
                kilobytes(fact["bytes"]),
                seconds(fact["differentiate"] + fact["write"]),
                seconds(fact["compile"]),
                duration(ns[name]),
            ]
        )
    by_hand, dual = (rust_lines("benches/src/tetrahedron.rs", name) for name in ("by_hand", "energy"))
    dual += rust_lines("benches/src/tetrahedron.rs", "by_dual_numbers")
    rows.append(["nalgebra, by hand", str(by_hand), "", "", "", "", duration(ns["by hand, nalgebra"])])
    rows.append(["num-dual", str(dual), "", "", "", "", duration(ns["num-dual"])])
    rows.append(
        [
            "SymX, published",
            "",
            f"{SYMX['operations']:,}",
            "",
            seconds(SYMX["differentiate"] + SYMX["write"]),
            seconds(SYMX["compile"]),
            f"{SYMX['single']} ns; batch {SYMX['batch']} ns",
        ]
    )
    scaled = hexahedron * found["peak"] / ASKED_PEAK
    asked = [
        ["operations", "≤ 1,833", str(found["operations"]["tet4"]), found["operations"]["tet4"] <= 1833],
        [
            "batch over nalgebra by hand",
            "≤ 1/5",
            f"1/{ns['by hand, nalgebra'] / batch:.1f}",
            5 * batch <= ns["by hand, nalgebra"],
        ],
        [
            "single over nalgebra by hand",
            "≤ 1/1.5",
            f"1/{ns['by hand, nalgebra'] / ns['generated, single']:.2f}",
            1.5 * ns["generated, single"] <= ns["by hand, nalgebra"],
        ],
        ["batch over CasADi's C", "≤ 1/4", f"1/{ns['CasADi'] / batch:.1f}", 4 * batch <= ns["CasADi"]],
        ["generate, compile and link after a change", "≤ 3 s", seconds(found["rebuild"]), found["rebuild"] <= 3],
        [
            "hexahedron, eight points, batch, scaled to 29 multiply-adds a ns",
            "≤ 1.5 µs",
            duration(scaled),
            scaled <= 1500,
        ],
        [
            "its functions, all modes and instructions",
            "≤ 100 kB",
            kilobytes(found["bytes"]["hex8"]),
            found["bytes"]["hex8"] <= 1e5,
        ],
    ]
    print(table(["", "goal", "measured", ""], [row[:3] + ["✓" if row[3] else "✗"] for row in asked]))
    columns = ["", "lines", "operations", "functions", "differentiate, write", "compile", "an element"]
    return f"""# An element of one's own beside rivals

Written by `benches/rivals/own_elements.py`; do not edit.

A tetrahedron of compressible neo-Hooke material from its energy: energy, 12 gradient entries and the Hessian's 78. All ways agree to
{TOLERANCE:g} of the largest entry. 256 elements and their results stay in the cache; times are of one thread, medians of interleaved
rounds. [An element of your own](../how-to/own-element.md) shows the formulas.

{table(columns, rows)}
* Lines are those of the function that states the energy; by hand, those of all derivatives too.
* Operations of this generator count a fused multiply-add once, those of CasADi, SymPy and wrenfold none fused.
* Functions are machine code. This generator's Rust has three numbers of derivatives, each for one element and for all vector instructions;
  the others have one function. In C and C++ they have one function, and {" ".join(FLAGS)}; the batch in C also -ffast-math.
* This generator's compile time is that of the book's crate, outside the workspace: Cargo runs the build script, compiles and links.
* SymX's figures are its authors' (ACM TOG 45(1):5, 2026), on one thread of a Ryzen 9 5900X with AVX2: another machine.
  Its batch takes {SYMX['batch']} ns. This generator's batch takes {duration(batch)} here in Rust, and {duration(ns['C batch'])} in C.

A hexahedron with eight points takes {duration(hexahedron)} in batches, its functions take {kilobytes(found["bytes"]["hex8"])}, all modes
and instructions. This machine does {found["peak"]:.1f} fused multiply-adds a nanosecond.

{platform.system()} {platform.machine()}, {isa}, {version("rustc")}, {version("gcc")}, CasADi {ca.__version__}, SymPy {sp.__version__},
wrenfold {importlib.metadata.version('wrenfold')}.
"""


def version(program):
    """What it says of itself, without the parentheses."""
    text = subprocess.run([program, "--version"], check=True, capture_output=True, text=True).stdout.splitlines()[0]
    return re.sub(r" \(.*\)", "", text)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5, help="rounds of which times are medians")
    parser.add_argument("--seconds", type=float, default=0.2, help="how long each way is timed in a round")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "target" / "rivals", help="folder for objects")
    parser.add_argument("--docs", type=pathlib.Path, default=ROOT / "docs" / "results", help="where the page goes")
    parser.add_argument(
        "--user", type=pathlib.Path, default=ROOT / "target" / "rivals", help="folder for a user's crate"
    )
    arguments = parser.parse_args()
    folder = arguments.build.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    found = measured(arguments, folder)
    (folder / "own-elements.json").write_text(json.dumps(found, indent=1))
    arguments.docs.mkdir(parents=True, exist_ok=True)
    (arguments.docs / "own-elements.md").write_text(page(found))


if __name__ == "__main__":
    main()
