#!/usr/bin/env python3
"""Compares the wake-up latency of a session's haptic thread with cyclictest, or with itself undisturbed.

    tools/compare_wakeup.py [--against cyclictest|no-pictures|spy|stopped-spy|no-live]
                            [--pairs 10] [--seconds 30] [--json FILE] [SCENE]

Runs pairs: a whole session (deformation and rendering on) and a counterpart, in alternating order:

    cyclictest    session | cyclictest -p 80 -i 1000
    no-pictures   session | the same without rendering
    spy           session --live with `hpdm spy` reading every message | the same without a spy
    stopped-spy   session --live with a spy that was stopped (SIGSTOP) | the same without a spy
    no-live       session --live with `hpdm spy` reading every message | the same without --live

Pools each side's wake-ups and reports the ratio of the p99 with a 95 % interval. The interval is a
bootstrap over whole pairs, since disturbances of a machine come in bursts. Needs the rights for real-time
scheduling (root), the demo's build, and for cyclictest: apt-get install rt-tests.

The last three run in a private network namespace, which the script creates (root), so that nothing
reaches a real network. A spy counts the messages it receives; the exit status is 1 unless it received
every message that the session sent.

Session and cyclictest lock their memory, sleep on CLOCK_MONOTONIC until an absolute time and measure how
much later they run. cyclictest's histogram has bins of 1 us, so a session's values are cut to whole
microseconds too; percentiles are interpolated within a bin. Before each session an empty loop of the
program measures for a second (`baseline`), as cyclictest does.
"""

import argparse
import csv
import json
import os
import random
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OTHERS = {
    "cyclictest": "cyclictest",
    "no-pictures": "no-pictures",
    "spy": "no spy",
    "stopped-spy": "no spy",
    "no-live": "no-live",
}
NAMESPACE = "HPDM_WAKEUP_NAMESPACE"  # set inside the private network
LARGEST_US = 20000  # end of cyclictest's histogram; later wake-ups count as this late
DRAWS = 4000


def run_session(program, scene, seconds, folder, extra=()):
    """Returns the wake-ups of the session and of its baseline, each {us: count}, and its summary."""
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
                width = 1 << max(upper.bit_length() - 6, 0)  # engine/threads/histogram.h
                us = min((upper - width // 2) // 1000, LARGEST_US)
                of = bins[row["latency"]]
                of[us] = of.get(us, 0) + int(row["count"])
    shutil.rmtree(out)
    return bins["haptic.wake_up"], bins["baseline.wake_up"], json.loads(done.stdout)


class Spy:
    """An `hpdm spy` that reads all messages; if `stopped`, it is suspended at once."""

    def __init__(self, program, stopped):
        self.stopped = stopped
        words = [program, "spy", "--once", "--json", "--seconds", "100000"]
        self.process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
        time.sleep(1)  # until it listens
        if stopped:
            self.process.send_signal(signal.SIGSTOP)

    def counts(self, session):
        """Ends the spy. Returns the sent and received messages, or None if it was stopped."""
        if self.stopped:
            self.process.kill()
            self.process.communicate()
            return None
        time.sleep(0.5)  # for the last messages
        self.process.send_signal(signal.SIGINT)
        spied = json.loads(self.process.communicate()[0])
        return {
            "sent": session["live"]["messages"],
            "received": spied["messages"],
            "lost_by_sequence": sum(channel["lost"] for channel in spied["channels"]),
        }


def enter_private_network():
    """Runs the script again inside a private network namespace, and returns only there."""
    if NAMESPACE in os.environ:
        return
    if os.geteuid() != 0 or shutil.which("unshare") is None or shutil.which("ip") is None:
        raise SystemExit("a private network needs root, unshare and ip: run as root, and apt-get"
                         " install util-linux iproute2")
    os.environ[NAMESPACE] = "1"
    os.environ.pop("LCM_DEFAULT_URL", None)
    script = " ".join(shlex.quote(word) for word in [sys.executable, *sys.argv])
    up = "ip link set lo up; ip link set lo multicast on; ip route add 239.255.76.67 dev lo"
    os.execvp("unshare", ["unshare", "-n", "sh", "-c", f"{up}; exec {script}"])


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
    """Returns the percentile in us; the values of a bin are spread over its microsecond."""
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
    results = {name: round(percentile(bins, share), 2) for name, share in named.items()}
    return {"count": sum(bins.values()), **results, "max_us": max(bins)}


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
    parser.add_argument("--against", choices=list(OTHERS), default="cyclictest")
    parser.add_argument("--pairs", type=int, default=10)
    parser.add_argument("--seconds", type=int, default=30, help="length of each run")
    parser.add_argument("--json", metavar="FILE", help="write all results to FILE")
    parser.add_argument("--hpdm", default=str(ROOT / "build" / "tools" / "hpdm"))
    options = parser.parse_args()
    if options.pairs < 1 or options.seconds < 1:
        parser.error("--pairs and --seconds: at least 1")
    against = options.against
    if against == "cyclictest" and shutil.which("cyclictest") is None:
        raise SystemExit("cyclictest is not installed: apt-get install rt-tests")
    if not os.access(options.hpdm, os.X_OK):
        raise SystemExit(f"{options.hpdm}: not built; run tools/demo.sh, or name it by --hpdm")
    with_spy = against in ("spy", "stopped-spy", "no-live")
    if with_spy:
        enter_private_network()
    other = OTHERS[against]

    pairs, baselines, rows = [], [], []
    with tempfile.TemporaryDirectory() as folder:

        def run(extra):
            return run_session(options.hpdm, options.scene, options.seconds, folder, extra)

        def run_ours():
            if not with_spy:
                return *run(()), None
            spy = Spy(options.hpdm, against == "stopped-spy")
            try:
                ours, baseline, session = run(["--live"])
                return ours, baseline, session, spy.counts(session)
            finally:
                spy.process.kill()

        def run_other():
            if against == "cyclictest":
                return run_cyclictest(options.seconds)
            extra = {"no-pictures": ["--no-pictures"], "no-live": []}.get(against, ["--live"])
            return run(extra)[0]

        for number in range(options.pairs):
            load = os.getloadavg()[0]
            first = run_other() if number % 2 else None
            ours, baseline, session, spied = run_ours()
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
            if spied:
                rows[-1]["spy"] = spied
            print(
                f"pair {number + 1}: p99 {rows[-1]['session']['p99_us']} us,"
                f" {other} {rows[-1][other]['p99_us']} us, load {load:.1f}",
                file=sys.stderr,
            )
    results = {
        "scene": options.scene,
        "against": against,
        "seconds": options.seconds,
        "session": summary(pool(p[0] for p in pairs)),
        other: summary(pool(p[1] for p in pairs)),
        "baseline": summary(pool(baselines)),
        "p99_ratio": round(p99_ratio(pairs), 3),
        "p99_ratio_95": interval(pairs),
        "pairs": rows,
    }
    if options.json:
        Path(options.json).write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")
    print("wake-up late by (us)      p50     p90     p99   p99.9     max")
    for name in ("session", other, "baseline"):
        cells = [results[name][k] for k in ("p50_us", "p90_us", "p99_us", "p99_9_us", "max_us")]
        print(f"{name:20}" + "".join(f"{cell:8.1f}" for cell in cells))
    low, high = results["p99_ratio_95"]
    print(
        f"p99 of the session over that of {other}: {results['p99_ratio']:.2f}"
        f" ({low:.2f} to {high:.2f}, 95 %, {len(pairs)} pairs of {options.seconds} s)"
    )
    counts = [row["spy"] for row in rows if "spy" in row]
    if counts:
        sent, received = (sum(c[key] for c in counts) for key in ("sent", "received"))
        print(f"the spy received {received} of {sent} messages")
        if received != sent or any(c["lost_by_sequence"] for c in counts):
            raise SystemExit(1)


if __name__ == "__main__":
    main()
