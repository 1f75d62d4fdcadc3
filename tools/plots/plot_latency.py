"""Plots the distributions of a session's latencies as percentile curves on log axes.

Usage: plot_latency.py LATENCY.csv PICTURE
The columns are those of tools/run/latency_table.h. A curve tells, for each share of the values,
what they do not exceed: the farther to the right, the rarer. It ends at one value in the number
there.
"""

import csv
import sys
from collections import defaultdict

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend comes first)

PANELS = {
    "the haptic loop": [
        ("haptic.wake_up", "wake-up late by"),
        ("baseline.wake_up", "the same of an empty loop"),
        ("haptic.compute", "tick"),
        ("haptic.device_to_force", "device to force"),
    ],
    "deformation and render loops": [
        ("deformation.wake_up", "deformation: wake-up late by"),
        ("deformation.compute", "deformation: step"),
        ("render.compute", "render: frame"),
    ],
    "ages and periods": [
        ("haptic.patch_age", "patch age at the tick"),
        ("render.device_to_photon", "device to photon"),
        ("haptic.period", "haptic period"),
        ("deformation.period", "deformation period"),
        ("render.period", "render period"),
    ],
}
MARKS = {0.5: "50 %", 0.1: "90 %", 0.01: "99 %", 1e-3: "99.9 %", 1e-4: "99.99 %", 1e-5: "99.999 %"}


def read(path):
    """latency -> rising list of (upper bound of the bin in us, count)."""
    bins = defaultdict(lambda: defaultdict(int))
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            bins[row["latency"]][int(row["upper_ns"])] += int(row["count"])
    return {name: sorted((ns / 1000, n) for ns, n in of.items()) for name, of in bins.items()}


def curve(bins):
    """Steps of the percentile curve: one in x values exceeds y us."""
    total = sum(count for _, count in bins)
    left, xs, ys = total, [], []
    for upper, count in bins:
        xs += [total / left, total / max(left - count, 1)]
        ys += [max(upper, 1e-3)] * 2
        left -= count
    return xs, ys


def main(table, picture):
    latencies = read(table)
    figure, panels = plt.subplots(1, len(PANELS), figsize=(14, 6.5), dpi=100)
    for axes, (title, names) in zip(panels, PANELS.items()):
        for name, label in names:
            if name not in latencies:
                continue
            xs, ys = curve(latencies[name])
            dashed = "--" if name.startswith("baseline") else "-"
            axes.plot(xs, ys, dashed, lw=1.5, label=f"{label} ({xs[-1]:,.0f})")
        axes.set(xscale="log", yscale="log", title=title, xlabel="share of the values")
        shown = {share: text for share, text in MARKS.items() if 1 / share <= axes.get_xlim()[1]}
        axes.set_xticks([1 / share for share in shown], list(shown.values()))
        axes.minorticks_on()
        axes.tick_params(axis="x", which="minor", bottom=False)
        axes.grid(alpha=0.3)
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), fontsize="small", frameon=False)
    panels[0].set_ylabel("not exceeded by them (us)")
    figure.tight_layout()
    figure.savefig(picture)


if __name__ == "__main__":
    main(*sys.argv[1:])
