#!/usr/bin/env python3
"""Compares how late a session's haptic thread wakes with cyclictest, or with itself undisturbed.

    tools/compare_wakeup.py [--against cyclictest|no-pictures] [--pairs 10] [--seconds 30]
                            [--json FILE] [SCENE]

Runs pairs of a whole session (deformation and rendering on) and of `cyclictest -p 80 -i 1000`, or of
the same session without rendering, the order changing from pair to pair, pools each side's wake-ups,
and reports the ratio of the p99 with a 95 % interval: a bootstrap that draws whole pairs, since what
disturbs a machine comes in bursts. Needs the rights for real-time scheduling (root), the demo's
build, and for cyclictest: apt-get install rt-tests.

Session and cyclictest lock their memory, sleep on CLOCK_MONOTONIC until an absolute time and measure how much
later they run. cyclictest's histogram has bins of 1 us, so a session's values are cut to whole
microseconds as its are; within a bin percentiles are interpolated. Before each session an empty
loop of its own measures for a second (`baseline`): the same as cyclictest without its program.
"""

import argparse
import csv
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LARGEST_US = 20000  # of cyclictest's histogram; later wake-ups are counted as this late
DRAWS = 4000


def run_session(program, scene, seconds, folder, extra=()):
    """Wake-ups of the session and of its baseline, each {us: count}, and its summary."""
    out = Path(folder) / "session"
    command = [program, "run", scene, "--seconds", str(seconds), "--fps", "0", "--json", *extra]
    done = subprocess.run(command + ["--require-rt", "--out", out], capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(done.stderr.strip() or f"{program}: exit {done.returncode}")
    bins = {"haptic.wake_up": {}, "baseline.wake_up": {}}
    with open(out / "latency.csv", newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if row["latency"] in bins:
                upper = int(row["upper_ns"])
                width = 1 << max(upper.bit_length() - 6, 0)  # engine/histogram.h
                us = min((upper - width // 2) // 1000, LARGEST_US)
                of = bins[row["latency"]]
                of[us] = of.get(us, 0) + int(row["count"])
    shutil.rmtree(out)
    return bins["haptic.wake_up"], bins["baseline.wake_up"], json.loads(done.stdout)


def run_cyclictest(seconds):
    command = ["cyclictest", "-p", "80", "-i", "1000", "-m", "-q", "-D", str(seconds)]
    done = subprocess.run(command + ["-h", str(LARGEST_US)], capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"cyclictest: {done.stderr.strip() or done.returncode}")
    bins = {}
    for line in done.stdout.splitlines():
        if match := re.fullmatch(r"(\d+)\s+(\d+)", line.strip()):
            if int(match[2]) > 0:
                bins[int(match[1])] = int(match[2])
        elif match := re.search(r"Histogram Overflows:\s*(\d+)", line):
            if int(match[1]) > 0:
                bins[LARGEST_US] = bins.get(LARGEST_US, 0) + int(match[1])
    return bins


def pool(parts):
    pooled = {}
    for bins in parts:
        for us, count in bins.items():
            pooled[us] = pooled.get(us, 0) + count
    return pooled


def percentile(bins, share):
    """us; the values of a bin are spread over its microsecond."""
    wanted = share * sum(bins.values())
    seen = 0
    for us, count in sorted(bins.items()):
        if seen + count >= wanted:
            return us + (wanted - seen) / count
        seen += count
    return 0.0


def summary(bins):
    if not bins:
        return {}
    named = {"p50_us": 0.5, "p90_us": 0.9, "p99_us": 0.99, "p99_9_us": 0.999}
    figures = {name: round(percentile(bins, share), 2) for name, share in named.items()}
    return {"count": sum(bins.values()), **figures, "max_us": max(bins)}


def p99_ratio(pairs):
    ours, theirs = pool(p[0] for p in pairs), pool(p[1] for p in pairs)
    return percentile(ours, 0.99) / percentile(theirs, 0.99)


def interval(pairs):
    generator = random.Random(1)
    drawn = sorted(p99_ratio(generator.choices(pairs, k=len(pairs))) for _ in range(DRAWS))
    return [round(drawn[int(q * (DRAWS - 1))], 3) for q in (0.025, 0.975)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", nargs="?", default=str(ROOT / "scenes" / "liver_palpation.toml"))
    parser.add_argument("--against", choices=["cyclictest", "no-pictures"], default="cyclictest")
    parser.add_argument("--pairs", type=int, default=10)
    parser.add_argument("--seconds", type=int, default=30, help="length of each run")
    parser.add_argument("--json", metavar="FILE", help="write all figures to FILE")
    parser.add_argument("--hpdm", default=str(ROOT / "build" / "tools" / "hpdm"))
    options = parser.parse_args()
    if options.pairs < 1 or options.seconds < 1:
        parser.error("--pairs and --seconds: at least 1")
    other = options.against
    if other == "cyclictest" and shutil.which("cyclictest") is None:
        raise SystemExit("cyclictest is not installed: apt-get install rt-tests")
    if not os.access(options.hpdm, os.X_OK):
        raise SystemExit(f"{options.hpdm}: not built; run tools/demo.sh, or name it by --hpdm")

    pairs, baselines, rows = [], [], []
    with tempfile.TemporaryDirectory() as folder:

        def run_other():
            if other == "cyclictest":
                return run_cyclictest(options.seconds)
            extra = ["--no-pictures"]
            return run_session(options.hpdm, options.scene, options.seconds, folder, extra)[0]

        for number in range(options.pairs):
            load = os.getloadavg()[0]
            first = run_other() if number % 2 else None
            ours, baseline, session = run_session(
                options.hpdm, options.scene, options.seconds, folder
            )
            theirs = first or run_other()
            pairs.append((ours, theirs))
            baselines.append(baseline)
            rows.append(
                {
                    "load_before": round(load, 2),
                    "stolen_s": session["machine"]["stolen_s"],
                    "skipped": session["haptic"]["skipped"],
                    "session": summary(ours),
                    other: summary(theirs),
                    "baseline": summary(baseline),
                }
            )
            print(
                f"pair {number + 1}: p99 {rows[-1]['session']['p99_us']} us,"
                f" {other} {rows[-1][other]['p99_us']} us, load {load:.1f}",
                file=sys.stderr,
            )
    figures = {
        "scene": options.scene,
        "seconds": options.seconds,
        "session": summary(pool(p[0] for p in pairs)),
        other: summary(pool(p[1] for p in pairs)),
        "baseline": summary(pool(baselines)),
        "p99_ratio": round(p99_ratio(pairs), 3),
        "p99_ratio_95": interval(pairs),
        "pairs": rows,
    }
    if options.json:
        Path(options.json).write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")
    print("wake-up late by (us)      p50     p90     p99   p99.9     max")
    for name in ("session", other, "baseline"):
        cells = [figures[name][k] for k in ("p50_us", "p90_us", "p99_us", "p99_9_us", "max_us")]
        print(f"{name:20}" + "".join(f"{cell:8.1f}" for cell in cells))
    low, high = figures["p99_ratio_95"]
    print(
        f"p99 of the session over that of {other}: {figures['p99_ratio']:.2f}"
        f" ({low:.2f} to {high:.2f}, 95 %, {len(pairs)} pairs of {options.seconds} s)"
    )


if __name__ == "__main__":
    main()
