#!/usr/bin/env python3
"""Runs a long session and checks that its log lacks nothing.

    tools/soak.py [--seconds 600] [--out DIR] [SCENE]

A real-clock session of two hands (1 kHz, pictures drawn, published with --live in a private network
namespace, which the script makes itself: root), then `hpdm log check`. Exit status 0: every tick that
ran is in the log with what went in and what came out, and no message of any channel is missing,
damaged or out of order. Ten minutes take about 450 MB in DIR.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from compare_wakeup import ROOT, enter_private_network


def soak(hpdm, scene, seconds, out):
    """Runs the session; a line of figures and what is wrong."""
    command = [hpdm, "run", scene, "--seconds", str(seconds), "--fps", "0", "--live", "--json"]
    ran = subprocess.run(command + ["--out", out], capture_output=True, text=True)
    if not ran.stdout:
        raise SystemExit(ran.stderr.strip() or f"{hpdm}: exit {ran.returncode}")
    session = json.loads(ran.stdout)
    log = out / "session.lcmlog"
    checked = subprocess.run(
        [hpdm, "log", "check", "--json", log], capture_output=True, text=True
    )
    health = json.loads(checked.stdout)
    channels = {channel["channel"]: channel for channel in health["channels"]}
    ticks, skipped = session["haptic"]["ticks"], session["haptic"]["skipped"]["total"]
    lost = sum(channel["lost"] for channel in channels.values())
    tools = len(session["tools"])
    figures = (
        f"{seconds} s, {tools} tools: {ticks} ticks ran, {skipped} were skipped;"
        f" {health['events']} messages of {len(channels)} channels in the log, {lost} lost"
    )
    faults = []
    if ran.returncode != 0:
        faults.append(ran.stderr.strip().splitlines()[-1])
    if checked.returncode != 0:
        faults.append(f"hpdm log check {log}: exit {checked.returncode}")
    for name in ("HPDM_TOOL", "HPDM_FORCE"):
        if channels.get(name, {}).get("messages") != ticks:
            faults.append(f"{name}: {channels.get(name, {}).get('messages')} messages")
    return figures, faults


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", nargs="?", default=str(ROOT / "scenes" / "two_hands.toml"))
    parser.add_argument("--seconds", type=int, default=600)
    parser.add_argument("--out", metavar="DIR", help="keep the session folder there")
    parser.add_argument("--hpdm", default=str(ROOT / "build" / "tools" / "hpdm"))
    options = parser.parse_args()
    enter_private_network()
    with tempfile.TemporaryDirectory() as folder:
        out = Path(options.out) if options.out else Path(folder) / "session"
        figures, faults = soak(options.hpdm, options.scene, options.seconds, out)
    print(figures)
    for fault in faults:
        print(f"soak: {fault}", file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
