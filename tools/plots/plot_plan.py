"""Draws what `hpdm plan` decided from: plot_plan.py plan.csv PICTURE.

A panel an organ: estimated error against the time of a step, a colour a family of models, the Pareto
front, what was asked for, and the choice.
"""

import csv
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.ticker import FuncFormatter, NullFormatter

TICKS = (0.1, 0.2, 0.5, 1, 2, 3, 5, 7, 10, 15, 20, 30, 50, 70, 100, 200)


def draw(axes, rows, colours, handles):
    axes.set_xscale("log")
    axes.set_yscale("log")
    for row in rows:
        place = float(row["step_us"]) / 1e3, 100 * float(row["error"])
        colour = colours[row["family"]]
        solid = row["converged"] == "1" and row["choosable"] == "1"
        drawn = axes.scatter(*place, s=36, marker="o", zorder=3, linewidths=0.8,
                             facecolors=colour if solid else "none",
                             edgecolors="white" if solid else colour)
        handles.setdefault(row["family"], drawn)
    front = [(float(row["step_us"]) / 1e3, 100 * float(row["error"])) for row in rows
             if row["front"] == "1"]
    if front:
        handles["Pareto front"], = axes.step(*zip(*front), where="post", color="black", lw=1.1,
                                             alpha=0.75, zorder=2)
    error, budget = 100 * float(rows[0]["demand_error"]), float(rows[0]["demand_us"]) / 1e3
    handles["asked for"] = axes.axhline(error, color="#2ca02c", lw=1.2, ls="--", zorder=1)
    axes.axvline(budget, color="#2ca02c", lw=1.2, ls="--", zorder=1)
    doubt = 100 * float(rows[0]["doubt"])
    if doubt > 0:
        handles["doubt of the estimate"] = axes.axhline(doubt, color="#888888", lw=1, ls=":",
                                                        zorder=1)
    low_x, high_x = axes.get_xlim()
    low_y, high_y = axes.get_ylim()
    axes.fill_between([low_x, budget], [low_y, low_y], [error, error], color="#2ca02c", alpha=0.08,
                      lw=0, zorder=0)
    axes.set_xlim(low_x, high_x)
    axes.set_ylim(low_y, high_y)
    for row in rows:
        if row["chosen"] != "1":
            continue
        place = float(row["step_us"]) / 1e3, 100 * float(row["error"])
        handles["chosen"] = axes.scatter(*place, s=170, marker="o", facecolors="none",
                                         edgecolors="#d62728", linewidths=2, zorder=4)
        axes.annotate(row["model"], place, xytext=(10, -18), textcoords="offset points", fontsize=8,
                      color="#a01010", zorder=5,
                      bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1})
    axes.set_yticks([tick for tick in TICKS if low_y <= tick <= high_y])
    axes.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{y:g} %"))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    axes.grid(alpha=0.25, which="both", lw=0.5)
    hollow = rows[0]["hollow"] == "1"
    axes.set_title(rows[0]["organ"] + (" (hollow)" if hollow else ""), fontsize=11)
    axes.set_xlabel("a step (ms)", fontsize=9)
    axes.tick_params(labelsize=8)


def main(table, picture):
    with open(table, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    if not rows:
        raise SystemExit(f"{table}: no rows to plot")
    organs = {}
    for row in rows:
        organs.setdefault(row["organ"], []).append(row)
    families = sorted({row["family"] for row in rows})
    palette = plt.get_cmap("tab20")
    colours = {family: palette(i % 20) for i, family in enumerate(families)}
    columns = min(2, len(organs))
    lines = -(-len(organs) // columns)
    figure, panels = plt.subplots(lines, columns, squeeze=False, dpi=110,
                                  figsize=(8.2 if columns == 1 else 11, 4.2 * lines + 1.1))
    handles = {}
    for axes, members in zip(panels.flat, organs.values()):
        draw(axes, members, colours, handles)
    for axes in panels.flat[len(organs):]:
        axes.set_axis_off()
    for axes in panels[:, 0]:
        axes.set_ylabel("estimated error of the surface's motion", fontsize=9)
    last = ("Pareto front", "asked for", "doubt of the estimate", "chosen")
    names = sorted(handles, key=lambda name: (last.index(name) if name in last else -1, name))
    rows_of_legend = -(-len(names) // 3)
    figure.tight_layout(rect=(0, (0.2 * rows_of_legend + 0.15) / figure.get_figheight(), 1, 1))
    figure.legend([handles[name] for name in names], names, loc="lower center", ncol=3, fontsize=8,
                  frameon=False)
    figure.savefig(picture)


if __name__ == "__main__":
    main(*sys.argv[1:])
