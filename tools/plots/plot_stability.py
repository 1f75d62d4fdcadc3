"""Plots the greatest stable stiffness against delay and period.

Usage: plot_stability.py STABILITY.csv PICTURE...
The columns are those of tools/haptics/stability_map.h.
"""

import csv
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend comes first)
from matplotlib.ticker import FuncFormatter, NullFormatter  # noqa: E402

CASES = {
    "bare": ("#1f77b4", "no hand, no friction"),
    "hand": ("#d95f02", "in a hand"),
    "hand_device": ("#2ca02c", "in a hand, friction, encoder"),
}
LIMITS = ("bare", "hand")  # the roots of hand_device are those of hand


def select(rows, **wanted):
    return [row for row in rows if all(row[key] == value for key, value in wanted.items())]


def draw(axes, rows, column, sweep):
    rows = select(rows, sweep=sweep)

    def line(chosen, value):
        return [1e3 * float(r[column]) for r in chosen], [float(r[value]) for r in chosen]

    for case in LIMITS:
        chosen = select(rows, case=case, control="0")
        if chosen:
            damping = float(chosen[0]["damping_N_s_per_m"])
            axes.plot(*line(chosen, "exact_N_per_m"), color=CASES[case][0], lw=4, alpha=0.3,
                      zorder=1, label=f"exact discrete roots, b = {damping:g} N s/m")
    for case, (colour, name) in CASES.items():
        damping = sorted({float(r["damping_N_s_per_m"]) for r in select(rows, case=case)})
        for control, state in (("0", "off"), ("1", "on")):
            chosen = select(rows, case=case, control=control)
            if not chosen:
                continue
            on = control == "1"
            label = f"measured, {name} (b = {damping[0]:g}): controller {state}"
            axes.plot(*line(chosen, "measured_N_per_m"), color=colour, lw=1.1,
                      ls="--" if on else "-", marker="^" if on else "o", ms=4.5,
                      mfc=colour if on else "white", zorder=3, label=label)
            capped = [r for r in chosen if r["beyond"] == "1"]
            if capped:
                axes.plot(*line(capped, "measured_N_per_m"), ls="", marker="$\\uparrow$", ms=11,
                          color=colour, zorder=4)
    chosen = select(rows, case="bare", control="0")
    axes.plot(*line(chosen, "passivity_N_per_m"), color="black", lw=1.3, ls=":", zorder=2,
              label=r"passivity bound of the device: min(2b/T, 2f$_c$/step)")
    if sweep == "delay":
        axes.plot(*line(chosen, "delayed_passivity_N_per_m"), color="black", lw=1, ls="-.",
                  zorder=2, label=r"the same with the delay: 2b/(T + 2 delay)")


def main(table, *pictures):
    with open(table, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    if not rows:
        raise SystemExit(f"{table}: no rows to plot")
    figure, (by_delay, by_period) = plt.subplots(1, 2, sharey=True, figsize=(10.5, 6.2), dpi=110)
    draw(by_delay, rows, "delay_s", "delay")
    draw(by_period, rows, "period_s", "period")
    period = 1e3 * float(select(rows, sweep="delay")[0]["period_s"])
    by_delay.set_title(f"period {period:g} ms", fontsize=10)
    by_delay.set_xlabel("delay beyond the hold (ms)")
    by_delay.set_ylabel("greatest stiffness without vibration (N/m)")
    by_period.set_title("no delay beyond the hold", fontsize=10)
    by_period.set_xlabel("period of the haptic loop (ms)")
    by_period.set_xscale("log")
    by_period.set_xticks([0.25, 0.5, 1, 2, 4])
    by_period.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    by_period.xaxis.set_minor_formatter(NullFormatter())
    for axes in (by_delay, by_period):
        axes.set_yscale("log")
        axes.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{y:,.0f}"))
        axes.grid(alpha=0.25, which="both", lw=0.5)
        axes.tick_params(labelsize=9)
    handles, labels = by_delay.get_legend_handles_labels()
    figure.tight_layout(rect=(0, 0.19, 1, 1))
    figure.legend(handles, labels, loc="lower center", ncol=2, fontsize=8.5, frameon=False)
    for picture in pictures:
        figure.savefig(picture)


if __name__ == "__main__":
    main(*sys.argv[1:])
