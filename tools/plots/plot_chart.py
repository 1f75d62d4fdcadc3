"""Plots error against time of every model, a panel a load case.

Usage: plot_chart.py CHART.csv PICTURE...
The columns are those of tools/chart/chart_point.h.
"""

import csv
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend comes first)
from matplotlib.lines import Line2D  # noqa: E402
from matplotlib.ticker import FuncFormatter, NullFormatter  # noqa: E402

DEGREES = {"1": "linear", "2": "quadratic", "3": "cubic"}
BUDGETS = ((1, "1 ms"), (33, "33 ms"))
# Place in the legend, name, mark of a line, colour and style.
TETRAHEDRA = {
    "linear_tetrahedra": (30, "linear tetrahedra, nodes (even)", "", "#2ca02c", "--"),
    "linear_graded": (31, "linear tetrahedra, nodes (finer at the load)", " graded", "#2ca02c", ":"),
    "quadratic_graded": (32, "quadratic tetrahedra, nodes (finer at the load)", " quadratic",
                         "#a0522d", ":"),
}


def look(row):
    """Label, colour and marker of a model; in the order of the legend by its first item."""
    if row["model"] == "continuum":
        return 20, "surface continuum", "#8c564b", "P"
    if row["model"] == "mass_spring":
        return 21, "mass-spring", "#e377c2", "X"
    if row["energy"] == "metric":
        box = row["strain"] == "box"
        iterative = row["solver"] == "gauss_seidel"
        name = "metric energy (the paper's)" + (", box" if box else "")
        if row["basis"] == "bernstein":
            return 16, "the paper: metric, box, Bernstein, Gauss-Seidel", "#555555", "*"
        return 12 + 2 * box + iterative, name + (", Gauss-Seidel" if iterative else ""), (
            "#999999" if box else "#bcbd22"), "x" if iterative else "+"
    if row["strain"] == "finite":
        return 10, "strain, finite, Newton", "#d62728", "D"
    if int(row["adaptive_levels"] or 0) > 0:
        return 7, "strain, adaptive functions", "#c51b8a", "p"
    if int(row["local_functions"]) > 0:
        many = int(row["local_functions"]) > 32
        return 5 + many, f"strain + up to {64 if many else 27} local functions", (
            "#e06c00" if many else "#ffb84d"), "*"
    if row["basis"] == "bernstein":
        return 8, "strain, Bernstein", "#9467bd", "h"
    if row["solver"] == "gauss_seidel":
        return 9, "strain, Gauss-Seidel", "#17becf", "<"
    colour = {"1": "#7fb8e6", "2": "#1f77b4", "3": "#0b3c64"}[row["degree"]]
    marker = {"1": "v", "2": "o", "3": "s"}[row["degree"]]
    return 1 + int(row["degree"]), f"strain, {DEGREES[row['degree']]} B-spline", colour, marker


def milliseconds(row):
    return float(row["step_us"]) / 1e3


def pareto(points):
    front = []
    for time, error in sorted(points):
        if not front or error < front[-1][1]:
            front.append((time, error))
    return front


def draw_case(axes, rows, handles):
    families = {}
    for row in rows:
        if row["step_us"] and row["error"] and float(row["error"]) < 10:
            families.setdefault(look(row), []).append(row)
    for (order, label, colour, marker), members in sorted(families.items()):
        thin = marker in "+x"
        for converged in (True, False):
            points = [(milliseconds(r), 100 * float(r["error"])) for r in members
                      if (r["converged"] == "1") == converged]
            if not points:
                continue
            drawn = axes.scatter(*zip(*points), s=64 if marker == "*" else 30, marker=marker, zorder=3,
                                 linewidths=1.2 if thin else 0.7, alpha=0.9,
                                 **({"color": colour} if thin else
                                    {"facecolors": colour if converged else "none",
                                     "edgecolors": "white" if converged else colour}))
            if not converged:
                handles[(40, "open symbol: not converged within a step")] = Line2D(
                    [], [], ls="", marker="o", markersize=5, mfc="none", mec="#444444")
            if converged or (order, label) not in handles:
                handles[(order, label)] = drawn

    front = pareto([(milliseconds(r), 100 * float(r["error"])) for r in rows
                    if r["step_us"] and r["error"] and r["converged"] == "1"])
    if front:
        line, = axes.step(*zip(*front), where="post", color="black", lw=1.1, alpha=0.75, zorder=2)
        handles[(0, "Pareto front")] = line
    below = None  # label of the line below, which this one's may cover
    tetrahedra = [row for row in rows if row["model"] in TETRAHEDRA]
    for row in sorted(tetrahedra, key=lambda r: float(r["error"])):
        order, name, mark, colour, style = TETRAHEDRA[row["model"]]
        error = 100 * float(row["error"])
        line = axes.axhline(error, color=colour, lw=1.1, ls=style, zorder=1)
        crowded = below is not None and error < 1.09 * below
        axes.annotate(f"{int(row['unknowns']):,}{mark}",
                      (0.86 if crowded else 0.995, error), xycoords=("axes fraction", "data"),
                      xytext=(0, 1.5), textcoords="offset points", ha="right", va="bottom",
                      fontsize=7, color=colour)
        below = None if crowded else error
        handles[(order, f"{name}: error only")] = line
    for budget, name in BUDGETS:
        axes.axvline(budget, color="#444444", lw=1, ls="-.", zorder=1)
        axes.annotate(name, (budget, 1), xycoords=("data", "axes fraction"), xytext=(3, -3),
                      textcoords="offset points", va="top", fontsize=8, color="#444444")


def main(table, *pictures):
    with open(table, newline="", encoding="utf-8") as file:
        lines = [line for line in file if not line.startswith("#")]
    cases = {}
    for row in csv.DictReader(lines):
        cases.setdefault(row["case"], []).append(row)
    if not cases:
        raise SystemExit(f"{table}: no rows to plot")
    order = sorted(cases, key=lambda case: cases[case][0]["hollow"])  # solid first; stable
    columns = min(3, len(order))
    lines_of_panels = -(-len(order) // columns)
    figure, panels = plt.subplots(lines_of_panels, columns, squeeze=False, sharex=True, dpi=110,
                                  figsize=(4.6 * columns + 0.4, 3.5 * lines_of_panels + 1.5))
    handles = {}
    for axes, case in zip(panels.flat, order):
        axes.set_xscale("log")
        axes.set_yscale("log")
        draw_case(axes, cases[case], handles)
        hollow = cases[case][0]["hollow"] == "1"
        if hollow:
            axes.set_facecolor("#fdf1e3")
        axes.set_title(case + (" (hollow: the hard case)" if hollow else ""), fontsize=11,
                       color="#a04000" if hollow else "black")
        axes.grid(alpha=0.25, which="both", lw=0.5)
        low, high = axes.get_ylim()
        axes.set_ylim(low, min(high, 200))
        axes.set_yticks([y for y in (0.5, 1, 2, 3, 5, 7, 10, 15, 20, 30, 50, 70, 100, 200)
                         if low <= y <= min(high, 200)])
        axes.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{y:g} %"))
        axes.yaxis.set_minor_formatter(NullFormatter())
        axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
        axes.tick_params(labelsize=8, labelbottom=True)
    for axes in panels.flat[len(order):]:
        axes.set_axis_off()
    for axes in panels[:, 0]:
        axes.set_ylabel("error of the surface displacement", fontsize=9)
    for axes in list(panels.flat)[max(0, len(order) - columns):len(order)]:
        axes.set_xlabel("a step, relocation of 30,000 triangles included (ms)", fontsize=9)
    keys = sorted(handles)
    legend_rows = -(-len(keys) // columns)
    bottom = (0.2 * legend_rows + 0.15) / figure.get_figheight()
    figure.tight_layout(rect=(0, bottom, 1, 1))
    figure.legend([handles[key] for key in keys], [key[1] for key in keys], loc="lower center",
                  ncol=columns, fontsize=9, frameon=False)
    for picture in pictures:
        figure.savefig(picture)


if __name__ == "__main__":
    main(*sys.argv[1:])
