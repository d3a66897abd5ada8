"""docs/results/performance.md and its picture, from the figures of a run.

`python benches/rivals/report.py RESULT.json DOCS` writes them again from a stored result, for instance after the notes
have changed.
"""

import json
import pathlib
import statistics
import sys

import reach
from tables import GAP, SURFACE, duration, lookup, table

NOTES = pathlib.Path(__file__).resolve().parent / "notes.md"
# Kernel -> how the report calls it.
NAMES = {
    "generated-batch": "generated, batch",
    "generated-single": "generated, single",
    "by-hand-nalgebra": "by hand, nalgebra",
    "by-hand-native": "by hand, native",
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
        ["the same after a refresh that keeps all lists", each(found["evaluate_s"] + found["refresh_kept_s"])],
        ["the same with the search of all neighbours", each(found["evaluate_s"] + found["refresh_s"])],
    ]
    return table(["", "each slave"], rows)


def with_native(result):
    """The result, in which the element by hand compiled for this processor is one more kernel."""
    native = [
        {**row, "kernel": "by-hand-native"} for row in result["native_rows"] if row["kernel"] == "by-hand-nalgebra"
    ]
    return {**result, "rows": result["rows"] + native}


def compiled_for(result):
    """What the code of each row is compiled for, in words."""
    baseline = result["compiled_for"]
    parts = [
        f"generated: all instruction sets, of which {result['isa']} is chosen at run time "
        f"(f, ∇f and H_f at a given point: {baseline}, number by number)",
        f"by hand and num-dual: {baseline}, which is what Cargo does unless told otherwise",
    ]
    if result["native_rows"]:
        parts.append(
            f"by hand, native: the same source with `-C target-cpu=native`, here {result['native_isa']} with fused "
            "multiply-adds"
        )
    parts += ["CasADi: `gcc -O3 -march=native`", "JAX: by XLA, for this processor"]
    items = "\n".join(f"* {part}" for part in parts)
    return f"What each row is compiled for:\n\n{items}\n\nRust is compiled with link-time optimisation."


def casadi_gap(result):
    """For which numbers of nodes there is CasADi's gap, in words."""
    nodes = sorted(row["nodes"] for row in result["rows"] if (row["kernel"], row["output"]) == ("casadi", GAP))
    if not nodes:
        return "CasADi's is not part of this run."
    return f"CasADi's is compiled for n = {', '.join(map(str, nodes))} only, for the compile times below."


def losses(result):
    """Where a rival is faster than the generated kernels, in words."""
    found = []
    for label, rows in (("", result["rows"]), (", compiled for this processor", result["native_rows"])):
        ours = best_generated(rows)
        for row in rows:
            # The native one is among the native rows.
            if row["kernel"].startswith("generated") or row["kernel"] == "by-hand-native":
                continue
            time = lookup(rows, row["nodes"], ours, GAP)
            if row["output"] == GAP and time and row["ns"] < time:
                what = f"{name(row['kernel'])}{label}, n = {row['nodes']}: {duration(row['ns'])}"
                found.append(f"- {what}, {name(ours)} {duration(time)}.")
    return "\n".join(found) if found else "None at g, N and M in this run."


def compile_table(result):
    """Compile times and code sizes of the rivals."""
    lines = []
    for fact in result["compile"]:
        size = f"{fact['code_bytes']:,}" if "code_bytes" in fact else "–"
        what = "f, ∇f, H_f" if fact["what"] == "surface" else "g, N, M"
        generate = f"{fact['generate_s']:.1f}" if "generate_s" in fact else "–"
        operations = f"{fact['operations']:,}" if "operations" in fact else "–"
        row = [f"{name(fact['kernel'])}: {what}", str(fact["nodes"]), generate, f"{fact['compile_s']:.1f}"]
        when = fact.get("compiled", "–")
        load = f"{fact['load']:.1f}" if fact.get("load") is not None else "–"
        lines.append([*row, size, operations, when, load])
    lines.sort(key=lambda row: (row[0], int(row[1])))
    columns = ["", "n", "generation, s", "compiler, s", "code, bytes", "operations", "compiled on", "load"]
    return table(columns, lines)


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
    result = with_native(result)
    rows, native = result["rows"], result["native_rows"]
    ours = best_generated(rows)
    generated = [kernel for kernel in NAMES if kernel.startswith("generated")]
    agreement = ", ".join(f"{name(kernel)} {value:.1e}" for kernel, value in sorted(result["agreement"].items()))
    clean = result["clean_build"]
    parts = [
        "# Performance",
        "Written by `benches/rivals/run.py`; do not edit. Its last part comes from `benches/rivals/notes.md`.",
        f"**Machine** {result['machine'] or 'unknown'}, {result['system']}, one thread. **Commit** `{result['commit']}`. "
        f"**Tools** {result['rustc']}, {result['gcc']}, CasADi {result['casadi']}, JAX {result['jax']} "
        f"(Python {result['python']}). All tables up to the compile times are of that commit, not of the present code.",
        f"All run in the same {result['rounds']} rounds, one after another; times are medians. The elements are 256 "
        "curved patches with noise for each n: quadratic basis, cubic weight, the frame held. Before timing, everybody's "
        "value, gradient and Hessian is compared with the generated kernels; the largest relative difference of those "
        f"outside the program: {agreement}.",
        compiled_for(result),
        "## g, foot, ν, N and the lower triangle of M",
        by_nodes(rows, GAP, NAMES, duration),
        "![Time against the number of nodes](pictures/performance.svg)",
        factors(rows, ours),
        "CasADi's and JAX's gap starts from the foot and takes two Newton steps for its derivatives: they need not find it. "
        + casadi_gap(result),
        "## f, ∇f and H_f at a given point",
        "The smaller problem: no foot, no normal. The generated kernel adds ∇f_1 and ∇f_2.",
        by_nodes(rows, SURFACE, NAMES, duration),
        "## Fraction of peak",
        "Operations of the generated kernels over time; a fused multiply-add counts one, so does any other. They are relative to "
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
        f"`cargo lab study throughput`: {found['nodes']:,.0f} slaves over as many master nodes, nodal domains "
        f"(the default), {found['masters']:.1f} masters each, one thread. Elements of nearly as many masters are gathered from "
        "the positions into vectors and evaluated side by side; results go straight to each slave's place in the arrays that "
        "assembly reads.",
        whole_interface(found),
    ]
    if native:
        parts += [
            f"## Compiled for this processor ({result['native_isa']})",
            "The same program with `-C target-cpu=native`, which gives the element written by hand what the processor has; "
            "the generated kernels choose at run time here, too.",
            by_nodes(native, GAP, NAMES, duration),
        ]
    parts += [
        "## Rivals that are faster",
        losses(result),
        "## Compile times and code sizes",
        "CasADi: `gcc -O3 -march=native`; JAX: XLA, one process. Objects of CasADi stay from one run to the next: times are "
        "of the day they were compiled, with so many other processes running or waiting (load average).",
        compile_table(result),
        "The generated kernels are all n, three weights and two bases, and facets. `cargo build --release -p "
        f"diffuse-contact-kernels` into an empty folder, generator and its dependencies included, took "
        f"{clean['seconds']:.0f} s on {clean['cores']} cores at a load of {clean['load']:.1f} before. The library has "
        f"{clean['library']:,} bytes{', ' + format(clean['code'], ',') + ' of them code' if clean['code'] else ''}.",
    ]
    notes = NOTES.read_text().strip() if NOTES.exists() else ""
    return "\n\n".join(part.strip() for part in [*parts, notes] if part.strip()) + "\n"


def write(result, docs):
    """Page and picture into a folder; what was asked for goes to the terminal."""
    print(reach.text(result))
    docs.mkdir(parents=True, exist_ok=True)
    plot(result, docs / "pictures" / "performance.svg")
    (docs / "performance.md").write_text(text(result))


if __name__ == "__main__":
    write(json.loads(pathlib.Path(sys.argv[1]).read_text()), pathlib.Path(sys.argv[2]))
