"""Plots the greatest stable stiffness of the shipped contacts against rate, delay and hand.

Usage: plot_z_width.py Z_WIDTH.csv PICTURE...
The columns are those of tools/haptics/z_width.h.
"""

import csv
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend comes first)
from matplotlib.ticker import FuncFormatter, NullFormatter  # noqa: E402

SWEEPS = {
    "rate": ("rate_hz", 1, "rate of the haptic loop (Hz)"),
    "delay": ("delay_s", 1e3, "delay beyond the hold (ms)"),
    "hand": ("hand", 1, "impedance of the hand over the scene's"),
}
COLOURS = ("#1f77b4", "#d95f02", "#2ca02c", "#9467bd", "#8c564b", "#e377c2", "#17becf", "#7f7f7f")
MARKS = "osD^vPX*"


def select(rows, **wanted):
    return [row for row in rows if all(row[key] == value for key, value in wanted.items())]


def draw(axes, rows, contacts, sweep):
    column, unit, label = SWEEPS[sweep]
    for contact, colour, mark in zip(contacts, COLOURS, MARKS):
        own = select(rows, contact=contact, sweep=sweep)
        for control in ("1", "0"):
            chosen = sorted(select(own, control=control), key=lambda r: float(r[column]))
            if not chosen:
                continue
            x = [unit * float(r[column]) for r in chosen]
            axes.plot(x, [float(r["measured_N_per_m"]) for r in chosen], color=colour, marker=mark,
                      ms=5, lw=1.2, ls="-" if control == "1" else "--",
                      mfc=colour if control == "1" else "white", zorder=3)
        chosen = sorted(select(own, control="0"), key=lambda r: float(r[column]))
        x = [unit * float(r[column]) for r in chosen]
        for value, style in (("exact_N_per_m", {"lw": 4, "alpha": 0.18}),
                             ("passivity_N_per_m", {"lw": 0.9, "ls": ":"})):
            axes.plot(x, [float(r[value]) for r in chosen], color=colour, zorder=1, **style)
    axes.set_xlabel(label, fontsize=10)
    if sweep == "rate":
        axes.set_xscale("log")
        ticks = sorted({float(r[column]) for r in select(rows, sweep=sweep)})
        axes.set_xticks(ticks)
        axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:,.0f}"))
        axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{y:,.0f}"))
    axes.grid(alpha=0.25, which="both", lw=0.5)
    axes.tick_params(labelsize=9)


def main(table, *pictures):
    with open(table, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    if not rows:
        raise SystemExit(f"{table}: no rows to plot")
    contacts = list(dict.fromkeys(row["contact"] for row in rows))
    figure, panels = plt.subplots(1, 3, sharey=True, figsize=(13, 7.4), dpi=110)
    for axes, sweep in zip(panels, SWEEPS):
        draw(axes, rows, contacts, sweep)
    for contact, colour in zip(contacts, COLOURS):
        shipped = float(select(rows, contact=contact)[0]["shipped_N_per_m"])
        for axes in panels:
            axes.axhline(shipped, color=colour, lw=0.8, alpha=0.6, zorder=0)
    panels[0].set_ylabel("stiffness along the guide (N/m)")
    handles = [plt.Line2D([], [], color=colour, marker=mark, ms=5, lw=1.2,
                          label=f"{contact} (shipped: "
                                f"{float(select(rows, contact=contact)[0]['shipped_N_per_m']):,.0f}"
                                " N/m)")
               for contact, colour, mark in zip(contacts, COLOURS, MARKS)]
    black = {"color": "black"}
    handles += [
        plt.Line2D([], [], marker="o", ms=5, lw=1.2, label="measured, as shipped", **black),
        plt.Line2D([], [], marker="o", ms=5, lw=1.2, ls="--", mfc="white",
                   label="measured, without the passivity controller", **black),
        plt.Line2D([], [], lw=4, alpha=0.25, label="exact discrete roots, linear device in the hand",
                   **black),
        plt.Line2D([], [], lw=0.9, ls=":", label="2 b / (T + 2 delay), device and hand", **black),
        plt.Line2D([], [], lw=0.8, alpha=0.6, label="thin level line: the shipped stiffness",
                   **black),
    ]
    figure.tight_layout(rect=(0, 0.21, 1, 1))
    figure.legend(handles=handles, loc="lower center", ncol=3, fontsize=9, frameon=False)
    for picture in pictures:
        figure.savefig(picture)


if __name__ == "__main__":
    main(*sys.argv[1:])
