"""Draws which model fails where: a row a case, a column a model.

Usage: plot_stress.py STRESS.csv PICTURE
The columns are those of tools/stress/stress_report.h.
"""

import csv
import sys
import textwrap

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend comes first)
from matplotlib.patches import Rectangle  # noqa: E402

MODELS = (("strain_small", "strain,\nsmall"), ("strain_finite", "strain,\nfinite"),
          ("metric_small", "metric,\nsmall"), ("metric_finite", "metric,\nfinite"),
          ("continuum", "surface\ncontinuum"), ("mass_spring", "mass-\nspring"),
          ("linear_tetrahedra", "linear\ntetrahedra"), ("point_proxy", "point\nproxy"))
FATES = {"survived": "#b7dfb9", "degraded": "#fbe3a2", "failed": "#f2a9a0"}
GROUPS = {"material": "tissue, lattice, solver", "contact": "contacts", "motion": "large motions",
          "haptics": "tip, tick and device", "touch": "energy and stillness of a touch",
          "organs": "organs on each other, shaft"}


def error(row):
    if not row["error"]:
        return ""
    if row["error"] == "null":
        return "not finite"
    value = 100 * float(row["error"])
    if 0 < value < 0.005:
        return "< 0.01 %"
    return (f"{value:.2g} %" if value < 9.95 else f"{value:.0f} %") if value < 1000 else "> 10x"


def figure_of(value):
    return f"{float(value):.3g}" if abs(float(value)) < 1000 else f"{float(value):.0f}"


def boundary(row):
    unit = f" {row['unit']}" if row["unit"] else ""
    if not row["fails_from"]:
        return f"beyond {figure_of(row['utmost'])}{unit}"
    if not row["holds_to"]:
        return "fails from the start"
    return f"to {figure_of(row['holds_to'])}{unit}"


def main(table, picture):
    with open(table, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    if not rows:
        raise SystemExit(f"{table}: no rows to draw")
    cases = {}
    for row in rows:
        cases.setdefault(row["case"], {})[row["model"]] = row
    models = [(name, title) for name, title in MODELS if any(name in case for case in cases.values())]
    lines = []  # a group's title or a case
    for case in cases.values():
        group = next(iter(case.values()))["group"]
        if not lines or lines[-1][0] != group:
            lines.append((group, None))
        lines.append((group, case))
    height = sum(0.34 if case is None else 0.46 for _, case in lines)
    figure, axes = plt.subplots(figsize=(5.1 + 1.32 * len(models), height + 1), dpi=110)
    axes.set_xlim(-3.55, len(models))
    axes.set_ylim(height, -0.55)
    axes.set_axis_off()
    for x, (_, title) in enumerate(models):
        axes.text(x + 0.5, -0.1, title, ha="center", va="bottom", fontsize=9, weight="bold")
    y = 0
    for group, case in lines:
        if case is None:
            axes.text(-3.55, y + 0.2, GROUPS.get(group, group), fontsize=9.5, weight="bold", va="center")
            y += 0.34
            continue
        any_row = next(iter(case.values()))
        unit = f" {any_row['unit']}" if any_row["unit"] else ""
        asked = f"{any_row['title']}: {any_row['parameter']} {figure_of(any_row['asked'])}{unit}"
        axes.text(-3.5, y + 0.22, "\n".join(textwrap.wrap(asked, 56)[:2]), fontsize=7.5, va="center")
        for x, (name, _) in enumerate(models):
            row = case.get(name)
            axes.add_patch(Rectangle((x + 0.02, y + 0.02), 0.96, 0.42, lw=0,
                                     facecolor=FATES[row["fate"]] if row else "#f4f4f4"))
            if not row:
                continue
            verdict = " ".join(filter(None, (row["fate"], error(row))))
            axes.text(x + 0.5, y + 0.14, verdict, fontsize=7.5, ha="center", va="center")
            axes.text(x + 0.5, y + 0.33, boundary(row), fontsize=6.5, ha="center", va="center",
                      color="#444444")
            if row["harm"]:
                axes.text(x + 0.94, y + 0.14, "!", fontsize=9, ha="right", va="center", color="#b00000",
                          weight="bold")
        y += 0.46
    figure.tight_layout(pad=0.4)
    figure.savefig(picture)


if __name__ == "__main__":
    main(*sys.argv[1:])
