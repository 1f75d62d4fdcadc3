"""Plots the transparency of the shipped contacts: rendered over model stiffness, and its phase.

Usage: plot_transparency.py TRANSPARENCY.csv PICTURE...
The columns are those of tools/haptics/transparency.h.
"""

import csv
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend comes first)
from matplotlib.ticker import FuncFormatter, NullFormatter  # noqa: E402

COLOURS = ("#1f77b4", "#d95f02", "#2ca02c", "#9467bd", "#8c564b", "#e377c2", "#17becf", "#7f7f7f")
MARKS = "osD^vPX*"


def main(table, *pictures):
    with open(table, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    if not rows:
        raise SystemExit(f"{table}: no rows to plot")
    contacts = list(dict.fromkeys(row["contact"] for row in rows))
    figure, (ratio, phase) = plt.subplots(2, 1, sharex=True, figsize=(9.5, 9), dpi=110)
    for contact, colour, mark in zip(contacts, COLOURS, MARKS):
        for shipped in (True, False):
            chosen = [r for r in rows
                      if r["contact"] == contact and (r["guard"] == "1") == shipped]
            x = [float(r["frequency_Hz"]) for r in chosen]
            look = {"color": colour, "marker": mark, "ms": 5, "lw": 1.3,
                    "ls": "-" if shipped else "--", "mfc": colour if shipped else "white"}
            label = f"{contact} ({float(chosen[0]['model_N_per_m']):,.0f} N/m)" if chosen else ""
            ratio.plot(x, [float(r["ratio"]) for r in chosen],
                       label=label if shipped else None, **look)
            phase.plot(x, [float(r["phase_degrees"]) for r in chosen], **look)
    ratio.axhline(1, color="black", lw=0.8)
    phase.axhline(0, color="black", lw=0.8)
    low, high = ratio.get_ylim()
    ratio.set_ylim(min(low, 0.9), max(high, 1.1))
    ratio.set_ylabel("rendered over model stiffness")
    phase.set_ylabel("phase of the rendered force (degrees)")
    phase.set_xlabel("frequency of the tip's motion (Hz)")
    phase.set_xscale("log")
    phase.set_xticks(sorted({float(r["frequency_Hz"]) for r in rows}))
    phase.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    phase.xaxis.set_minor_formatter(NullFormatter())
    for axes in (ratio, phase):
        axes.grid(alpha=0.25, lw=0.5)
        axes.tick_params(labelsize=9)
    handles, _ = ratio.get_legend_handles_labels()
    for style, face, text in (("-", "black", "as shipped"),
                              ("--", "white", "without passivity controller and guard's limits")):
        handles.append(plt.Line2D([], [], color="black", marker="o", ms=5, lw=1.3, ls=style,
                                  mfc=face, label=text))
    figure.tight_layout(rect=(0, 0.13, 1, 1))
    figure.legend(handles=handles, loc="lower center", ncol=2, fontsize=9, frameon=False)
    for picture in pictures:
        figure.savefig(picture)


if __name__ == "__main__":
    main(*sys.argv[1:])
