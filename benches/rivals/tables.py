"""Markdown tables, and how figures are found and written."""

GAP, SURFACE = "gap-hessian", "surface-hessian"


def duration(ns):
    """A time with three digits."""
    for unit, size in (("ms", 1e6), ("µs", 1e3)):
        if ns >= size:
            return f"{ns / size:.3g} {unit}" if ns < 1000 * size else f"{ns / size:.0f} {unit}"
    return f"{ns:.0f} ns"


def table(columns, rows, left=False):
    """Markdown; figures to the right, unless all is words."""
    align = " --- |" if left else " ---: |"
    lines = ["| " + " | ".join(columns) + " |", "| --- |" + align * (len(columns) - 1)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def lookup(rows, nodes, kernel, output, field="ns"):
    """A figure, or None."""
    for row in rows:
        if (row["nodes"], row["kernel"], row["output"]) == (nodes, kernel, output):
            return row.get(field)
    return None
