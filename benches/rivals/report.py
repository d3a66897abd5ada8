"""docs/performance.md and its picture, from the figures of a run.

`python benches/rivals/report.py RESULT.json DOCS` writes them again from a stored result, for instance after the notes
have changed.
"""

import json
import pathlib
import statistics
import sys

NOTES = pathlib.Path(__file__).resolve().parent / "notes.md"
GAP, SURFACE = "gap-hessian", "surface-hessian"
# Kernel -> how the report calls it.
NAMES = {
    "generated-batch": "generated, batch",
    "generated-single": "generated, single",
    "by-hand-nalgebra": "by hand, nalgebra",
    "num-dual-dual2-vec": "num-dual `Dual2Vec`",
    "num-dual-hyper-dual": "num-dual `HyperDual`",
    "casadi": "CasADi",
    "jax": "JAX",
}


def median_rows(reports):
    """Rows of several runs of the program as one: medians."""
    found = {}
    for report in reports:
        for row in report["rows"]:
            found.setdefault((row["nodes"], row["kernel"], row["output"]), []).append(row)

    def middle(rows, field):
        values = [row[field] for row in rows if row[field] is not None]
        return statistics.median(values) if values else None

    fields = {"ns": "ns_per_element", "operations": "fma_per_element", "fraction": "fraction_of_peak"}
    return [
        {"nodes": nodes, "kernel": kernel, "output": output}
        | {short: middle(rows, long) for short, long in fields.items()}
        for (nodes, kernel, output), rows in found.items()
    ]


def name(kernel):
    """How the report calls a kernel."""
    return NAMES.get(kernel, kernel)


def duration(ns):
    """A time with three digits."""
    for unit, size in (("ms", 1e6), ("µs", 1e3)):
        if ns >= size:
            return f"{ns / size:.3g} {unit}" if ns < 1000 * size else f"{ns / size:.0f} {unit}"
    return f"{ns:.0f} ns"


def table(columns, rows):
    """Markdown."""
    lines = ["| " + " | ".join(columns) + " |", "| --- |" + " ---: |" * (len(columns) - 1)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def lookup(rows, nodes, kernel, output, field="ns"):
    """A figure, or None."""
    for row in rows:
        if (row["nodes"], row["kernel"], row["output"]) == (nodes, kernel, output):
            return row.get(field)
    return None


def by_nodes(rows, output, kernels, show, field="ns"):
    """One row for each kernel, one column for each number of nodes."""
    counts = sorted({row["nodes"] for row in rows if row["output"] == output and row["kernel"] in kernels})
    lines = []
    for kernel in kernels:
        figures = [lookup(rows, nodes, kernel, output, field) for nodes in counts]
        if any(figure is not None for figure in figures):
            lines.append([name(kernel)] + ["–" if figure is None else show(figure) for figure in figures])
    return table([""] + [f"n = {nodes}" for nodes in counts], lines)


def best_generated(rows):
    """The batch kernels where there are any."""
    kernels = {row["kernel"] for row in rows}
    return "generated-batch" if "generated-batch" in kernels else "generated-single"


def factors(rows, reference):
    """How many times longer the others take than the `reference` for the full gap, or for H_f where they have only that."""
    lines = []
    counts = sorted({row["nodes"] for row in rows if row["kernel"] == reference and row["output"] == GAP})
    for kernel in NAMES:
        for output in (GAP, SURFACE):
            pairs = [(lookup(rows, n, kernel, output), lookup(rows, n, reference, GAP)) for n in counts]
            if kernel == reference or (kernel.startswith("generated") and output == SURFACE):
                continue
            if not any(theirs for theirs, _ in pairs):
                continue
            what = "g, N, M" if output == GAP else "f, ∇f, H_f only"
            ratios = [f"{theirs / ours:,.3g}" if theirs else "–" for theirs, ours in pairs]
            lines.append([f"{name(kernel)}: {what}"] + ratios)
    return table([f"time over {name(reference)}"] + [f"n = {n}" for n in counts], lines)


def whole_interface(found):
    """Times per slave of a whole interface."""
    each = lambda seconds: f"{1e6 * seconds / found['nodes']:.3g} µs"
    rows = [
        ["g, N and M of all slaves, pairing as it is", each(found["evaluate_s"])],
        ["the same after a refresh that keeps all pairings", each(found["evaluate_s"] + found["refresh_kept_s"])],
        ["the same with the search of all neighbours", each(found["evaluate_s"] + found["refresh_s"])],
    ]
    return table(["", "each slave"], rows)


def losses(result):
    """Where a rival is faster than the generated kernels, in words."""
    found = []
    for label, rows in (("", result["rows"]), (", compiled for this processor", result["native_rows"])):
        ours = best_generated(rows)
        for row in rows:
            if row["kernel"].startswith("generated"):
                continue
            time = lookup(rows, row["nodes"], ours, GAP)
            if row["output"] == GAP and time and row["ns"] < time:
                what = f"{name(row['kernel'])}{label}, n = {row['nodes']}: {duration(row['ns'])}"
                found.append(f"- {what}, {name(ours)} {duration(time)}.")
    return "\n".join(found) if found else "Nowhere in this run is a rival faster at g, N and M."


def compile_table(result):
    """Compile times and code sizes of the rivals."""
    lines = []
    for fact in result["compile"]:
        size = f"{fact['code_bytes']:,}" if "code_bytes" in fact else "–"
        what = "f, ∇f, H_f" if fact["what"] == "surface" else "g, N, M"
        generate = f"{fact['generate_s']:.1f}" if "generate_s" in fact else "–"
        operations = f"{fact['operations']:,}" if "operations" in fact else "–"
        row = [f"{name(fact['kernel'])}: {what}", str(fact["nodes"]), generate, f"{fact['compile_s']:.1f}"]
        lines.append([*row, size, operations])
    lines.sort(key=lambda row: (row[0], int(row[1])))
    return table(["", "n", "generation, s", "compiler, s", "code, bytes", "operations"], lines)


def plot(result, path):
    """Time against the number of nodes, both axes logarithmic."""
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "performance"
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(8, 5.5), layout="constrained")
    for k, kernel in enumerate(NAMES):
        for output, style in ((GAP, "-"), (SURFACE, "--")):
            if kernel.startswith("generated") and output == SURFACE:
                continue
            rows = [r for r in result["rows"] if (r["kernel"], r["output"]) == (kernel, output)]
            rows.sort(key=lambda row: row["nodes"])
            if rows:
                label = name(kernel).replace("`", "") + ("" if output == GAP else " (f, ∇f, H_f only)")
                x, y = [row["nodes"] for row in rows], [row["ns"] / 1e3 for row in rows]
                axes.loglog(x, y, style, marker="o", markersize=4, color=f"C{k}", label=label)
    ticks = sorted({row["nodes"] for row in result["rows"]})
    axes.set_xticks(ticks, [str(tick) for tick in ticks])
    axes.minorticks_off()
    axes.set_xlabel("master nodes n")
    axes.set_ylabel("time for one element, µs")
    axes.set_title("Gap g, gradient N and Hessian M of one element, one thread", fontsize=11)
    axes.grid(alpha=0.3)
    figure.legend(fontsize=8, loc="outside right upper", frameon=False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


def text(result):
    """The page."""
    rows, native = result["rows"], result["native_rows"]
    ours = best_generated(rows)
    generated = [kernel for kernel in NAMES if kernel.startswith("generated")]
    agreement = ", ".join(f"{name(kernel)} {value:.1e}" for kernel, value in sorted(result["agreement"].items()))
    kernels = result["kernels"]
    parts = [
        "# Performance",
        "Written by `benches/rivals/run.py`; do not edit. Its last part comes from `benches/rivals/notes.md`.",
        f"**Machine** {result['machine'] or 'unknown'}, {result['system']}, one thread. **Commit** `{result['commit']}`. "
        f"**Tools** {result['rustc']}, {result['gcc']}, CasADi {result['casadi']}, JAX {result['jax']} "
        f"(Python {result['python']}).",
        f"All run in the same {result['rounds']} rounds, one after another; times are medians. The elements are 256 "
        "curved patches with noise for each n: quadratic basis, cubic weight, the frame held. Before timing, everybody's "
        "value, gradient and Hessian is compared with the generated kernels; the largest relative difference of those "
        f"outside the program: {agreement}. Rust is compiled with link-time optimisation for {result['compiled_for']}; "
        f"the generated kernels use {result['isa']}.",
        "## g, foot, ν, N and the lower triangle of M",
        by_nodes(rows, GAP, NAMES, duration),
        "![Time against the number of nodes](pictures/performance.svg)",
        factors(rows, ours),
        "CasADi's and JAX's gap starts from the foot and takes two Newton steps for its derivatives: they need not find it. "
        "CasADi's is compiled for n = 6 only, for the compile times below.",
        "## f, ∇f and H_f at a given point",
        "The smaller problem: no foot, no normal. The generated kernel adds ∇f_1 and ∇f_2.",
        by_nodes(rows, SURFACE, NAMES, duration),
        "## Fraction of peak",
        f"Operations of the generated kernels (a fused multiply-add counts one, so does any other) over time, relative to "
        f"{result['peak']:.1f} fused multiply-adds a nanosecond that a loop of nothing else reaches in the same run with "
        f"{result['isa']}.",
        by_nodes(rows, GAP, generated, lambda fraction: f"{100 * fraction:.0f} %", "fraction"),
        "Other outputs of the generated kernels, gap and N, and gap, N and M with the frame moving along:",
        by_nodes(rows, "gap-gradient", generated, duration),
        by_nodes(rows, "gap-co-moving-hessian", generated, duration),
    ]
    found = result["interface"]
    parts += [
        "## A whole interface",
        f"`diffuse-contact study throughput`: {found['nodes']:,.0f} slaves over as many master nodes, {found['masters']:.1f} "
        "masters each, the frame moving along, one thread. Elements of the same number of masters are gathered from "
        "the positions into vectors and evaluated side by side; results go straight to each slave's place in the arrays that "
        "assembly reads.",
        whole_interface(found),
    ]
    if native:
        parts += [
            f"## Compiled for this processor ({result['native_isa']})",
            "The same program with `-C target-cpu=native`, which gives the element written by hand what the processor has.",
            by_nodes(native, GAP, NAMES, duration),
        ]
    parts += [
        "## Where we lose",
        losses(result),
        "## Compile times and code sizes",
        "CasADi: `gcc -O3 -march=native`. JAX: XLA, one process.",
        compile_table(result),
        (
            f"The whole Rust program, with all kernels for all n, three weights and two bases, and all rivals within: "
            f"{result['cargo_s']:.0f} s in the profile `bench`."
            # Next to nothing if it was there already.
            if result["cargo_s"] > 20
            else ""
        )
        + (
            f" The library with all kernels, in that profile: {kernels['library']:,} bytes, {kernels['code']:,} of them code."
            if kernels
            else ""
        ),
    ]
    notes = NOTES.read_text().strip() if NOTES.exists() else ""
    return "\n\n".join(part.strip() for part in [*parts, notes] if part.strip()) + "\n"


def write(result, docs):
    """Page and picture into a folder."""
    docs.mkdir(parents=True, exist_ok=True)
    plot(result, docs / "pictures" / "performance.svg")
    (docs / "performance.md").write_text(text(result))


if __name__ == "__main__":
    write(json.loads(pathlib.Path(sys.argv[1]).read_text()), pathlib.Path(sys.argv[2]))
