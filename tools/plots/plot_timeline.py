"""Plots the force on the hand and the depth of the tip over time.

Usage: plot_timeline.py TIMELINE.csv PICTURE
The columns are those of lcmtypes/telemetry/timeline.h.
"""

import csv
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend comes first)


def main(table, picture):
    with open(table, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    if not rows:
        raise SystemExit(f"{table}: no rows to plot")
    seconds = [float(row["t"]) for row in rows]
    tools = [name[: -len("_force")] for name in rows[0] if name.endswith("_force")]

    figure, (force, depth) = plt.subplots(2, 1, sharex=True, figsize=(10, 5.5), dpi=120)
    for tool in tools:
        force.plot(seconds, [float(row[f"{tool}_force"]) for row in rows], label=tool, lw=1)
        depth.plot(seconds, [1000 * float(row[f"{tool}_depth"]) for row in rows], lw=1)
    force.set_ylabel("force on the hand (N)")
    depth.set_ylabel("depth of the tip (mm)")
    depth.set_xlabel("session time (s)")
    depth.invert_yaxis()
    force.legend(loc="upper right")
    for axes in (force, depth):
        axes.grid(alpha=0.3)
        axes.margins(x=0)
    figure.tight_layout()
    figure.savefig(picture)


if __name__ == "__main__":
    main(*sys.argv[1:])
