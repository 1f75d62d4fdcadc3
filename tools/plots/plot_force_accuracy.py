"""Plots the force that a hand feels beside the whole model's and the paper's.

Usage: plot_force_accuracy.py FORCE_ACCURACY.json COURSES_PICTURE ERRORS_PICTURE
The time series' tables lie beside the JSON file; both are those of tools/haptics/accuracy_report.h.
"""

import csv
import json
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend comes first)

COLUMNS = 4
# Column of the tables, label, look.
LINES = (
    ("paper", "the paper's Eq. 29, rest neighbours", {"color": "#bbbbbb", "lw": 0.8}),
    ("paper_fitted", "the same, k1 and k2 fitted", {"color": "#e08214", "lw": 1.0}),
    ("reference", "whole model at every tick", {"color": "black", "lw": 2.4, "alpha": 0.35}),
    ("production", "the haptic loop", {"color": "#1f77b4", "lw": 0.9}),
)
ERRORS = (
    ("paper_error", "the paper's Eq. 29, rest neighbours", "#bbbbbb"),
    ("paper_fitted_error", "the same, k1 and k2 fitted", "#e08214"),
    ("independent_error", "the haptic loop", "#1f77b4"),
)


def title(trial):
    return f"{trial['case']}: {trial['instrument']}"


def draw_time_series(trials, folder, picture):
    rows = (len(trials) + COLUMNS - 1) // COLUMNS
    figure, grid = plt.subplots(rows, COLUMNS, squeeze=False, dpi=110,
                                figsize=(4.2 * COLUMNS, 0.8 + 2.5 * rows))
    for axes in grid.flat[len(trials):]:
        axes.axis("off")
    for axes, trial in zip(grid.flat, trials):
        with open(folder / trial["time_series"], newline="", encoding="utf-8") as file:
            table = list(csv.DictReader(file))
        seconds = [float(row["t"]) for row in table]
        for column, label, look in LINES:
            force = [float(row[f"{column}_N"]) for row in table]
            axes.plot(seconds, force, label=label, **look)
        # A paper's force far beyond the hand's would flatten everything else.
        axes.set_ylim(-0.04 * trial["peak_N"], 1.6 * trial["peak_N"])
        acting = [t for t, row in zip(seconds, table) if float(row["reference_N"]) > 0]
        if acting:
            axes.set_xlim(max(0, acting[0] - 0.1), acting[-1] + 0.1)
        axes.set_title(f"{title(trial)}, {100 * trial['independent_error']:.1f} % of peak",
                       fontsize=9)
        axes.tick_params(labelsize=8)
        axes.grid(alpha=0.3)
    for axes in grid[:, 0]:
        axes.set_ylabel("|force| (N)", fontsize=8)
    for axes in grid[-1]:
        axes.set_xlabel("time (s)", fontsize=8)
    figure.legend(*grid[0, 0].get_legend_handles_labels(), loc="upper center", ncols=len(LINES),
                  fontsize=9, frameon=False)
    figure.tight_layout(rect=(0, 0, 1, 1 - 0.35 / figure.get_figheight()))
    figure.savefig(picture)


def draw_errors(trials, targets, picture):
    figure, (error, comb) = plt.subplots(1, 2, sharey=True, dpi=110,
                                         figsize=(11, 1.8 + 0.42 * len(trials)),
                                         gridspec_kw={"width_ratios": (1.7, 1)})
    places = range(len(trials))
    height = 0.8 / len(ERRORS)
    for i, (key, label, colour) in enumerate(ERRORS):
        error.barh([p + (1 - i) * height for p in places], [100 * t[key] for t in trials], height,
                   label=label, color=colour)
    comb.barh(places, [100 * (t["comb"] or 0) for t in trials], 0.4, color="#1f77b4")
    for p, trial in zip(places, trials):
        judged = 100 * trial["independent_error"]
        error.annotate(f" {judged:.1f}", (judged, p - height), va="center", fontsize=7)
        text = " contact too short" if trial["comb"] is None else f" {100 * trial['comb']:.2f}"
        comb.annotate(text, (100 * (trial["comb"] or 0), p), va="center", fontsize=7)
    for limit, style in ((targets["press_error"], ":"), (targets["grasp_error"], "--")):
        error.axvline(100 * limit, color="black", lw=1, ls=style)
    comb.axvline(100 * targets["comb"], color="black", lw=1, ls="--")
    error.set_xscale("log")
    error.set_xlim(0.1, 1000)
    error.set_yticks(places, [title(t) for t in trials], fontsize=8)
    error.invert_yaxis()
    error.set_xlabel("RMS error of the force in contact (% of its peak)\n"
                     "at most: dotted for a press, dashed for a grasp", fontsize=9)
    comb.set_xlabel("comb at the deformation rate (% of the force)\ndashed: at most", fontsize=9)
    for axes in (error, comb):
        axes.grid(axis="x", alpha=0.3)
        axes.set_axisbelow(True)
    comb.margins(x=0.15)
    figure.legend(*error.get_legend_handles_labels(), loc="upper center", ncols=len(ERRORS),
                  fontsize=9, frameon=False)
    figure.tight_layout(rect=(0, 0, 1, 1 - 0.35 / figure.get_figheight()))
    figure.savefig(picture)


def main(report, time_series, errors):
    path = pathlib.Path(report)
    results = json.loads(path.read_text(encoding="utf-8"))
    trials = results["hands"]
    if not trials:
        raise SystemExit(f"{report}: no case to plot")
    draw_time_series(trials, path.parent, time_series)
    draw_errors(trials, results["targets"], errors)


if __name__ == "__main__":
    main(*sys.argv[1:])
