#!/usr/bin/env python3
"""Runs long sessions with random hand motion and checks that they stay correct and bounded.

    tools/soak.py [--seconds 600] [--hogs N] [SCENE]             the real clock
    tools/soak.py --clock lockstep [--seconds 3600] [SCENE]      virtual time, as fast as it goes

Every instrument of the scene gets the hand script "random". The first seed is --seed; each further hand
adds one. --hand NAME.KEY=VALUE sets a key of an instrument's [instrument.hand], such as
hook.depth=0.015. A hand with exchanges takes another instrument at random, every ten seconds on
average, and presses its pedal every four seconds if one of them is a hook. --strain finite gives the
organs finite strain, without local functions.

On the real clock the session draws pictures and publishes with --live in a private network
namespace, which the script creates (root). --hogs starts that many processes of stress-ng (apt-get
install stress-ng) beside it, each of which occupies a whole core. Ten minutes of two hands need about
450 MB in --out or the folder for temporary files, an hour in lockstep 2.7 GB. The folder is removed at
the end unless --out names it.

In lockstep a second session of the same length follows. It repeats the first part of the random motion
as a trace: one minute (--stretch), with the tools away and at rest at both ends. Late forces must equal
the first ones bit for bit. Where attachments or ducts can be torn or cut, nothing repeats: there the log of
the session is replayed instead, and every number must be the same.

Prints one line for each check; exit status 1 if one fails:

    complete   no message of a channel is missing, damaged, out of order or unreadable, and every tick
               that ran is in the log with its input and output
    memory     after a quarter of a session, its resident memory grows by less than 1 MiB: over an hour
               less than 0.4 bytes a tick. Compares the medians of the first and the last fifth of the
               rest. Mesa's renderer grows in steps of 64 kB when the picture becomes busier
    replay     `hpdm replay` computes the same numbers
    finite, ticks, steps, force, slew, energy, work, rest, repeats
               defined by `hpdm log check` (lcmtypes/analysis/session_invariants.h)
"""

import argparse
import contextlib
import json
import os
import random
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import threading
import time
import tomllib
from pathlib import Path

from compare_wakeup import ROOT, enter_private_network

MEMORY_BOUND = 1024  # KiB
WARM_UP = 0.25  # of a session
SAMPLE_PERIOD = 0.05  # s
FEWEST = 20  # samples needed to measure growth
BYTES_A_SECOND = 1.1e6  # log of two hands and three organs
EXCHANGE_EVERY, PEDAL_EVERY = 10, 4  # s, means
PEDAL_FOR = 0.1, 2.5  # s
REST = 0.5, 2.5  # s, before and after the repeated motion; a second of travel separates them
TRACE_STEP = 10  # ms


def write_scene(scene, folder, seed, strain, hand_keys):
    """Writes the scene with random hands into `folder` and links its files beside it."""
    for entry in scene.parent.iterdir():
        if entry.name != "scene.toml":
            (folder / entry.name).symlink_to(entry.resolve())
    hands = iter(range(seed, seed + 100))
    names = iter(tool["name"] for tool in tomllib.loads(scene.read_text("utf-8"))["instrument"])
    lines, table, changed = [], "", {}
    for line in scene.read_text(encoding="utf-8").splitlines():
        if match := re.match(r"\s*\[+([\w.]+)\]+", line):
            table = match[1]
            if table == "instrument":
                changed = hand_keys.get(next(names), {})
        key = line.split("=")[0].strip()
        if table == "instrument.hand" and (key == "seed" or key in changed):
            continue
        if table == "instrument.hand" and key == "script":
            more = [f"{name} = {value}" for name, value in changed.items()]
            line = "\n".join(['script = "random"', f"seed = {next(hands)}", *more])
        if strain and table == "organ.energy" and key == "strain":
            line = f'strain = "{strain}"'
        if strain == "finite" and table == "organ.lattice" and key == "local_functions":
            line = "local_functions = 0"
        lines.append(line)
    written = folder / "scene.toml"
    written.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return written


def random_controls(scene, seconds, seed):
    """Returns the options of a session in which hands exchange instruments and press pedals at random."""
    chance = random.Random(seed)

    def times(every):
        now = chance.uniform(0, 2 * every)
        while now < seconds - PEDAL_FOR[1]:
            yield now
            now += PEDAL_FOR[1] + chance.uniform(0, 2 * (every - PEDAL_FOR[1]))

    options = []
    for tool in scene["instrument"]:
        name, others = tool["name"], tool.get("exchange", [])
        held = [name, *(other["name"] for other in others)]
        if others:
            for now in times(EXCHANGE_EVERY):
                options += ["--exchange", f"{name}={chance.choice(held)}@{now:.3f}"]
        if any(one.get("type") == "hook" for one in [tool, *others]):
            for now in times(PEDAL_EVERY):
                options += ["--pedal", f"{name}@{now:.3f}-{now + chance.uniform(*PEDAL_FOR):.3f}"]
    return options


class Memory(threading.Thread):
    """Samples a process's resident memory (KiB) against its session's progress (bytes logged)."""

    def __init__(self, pid, log):
        super().__init__(daemon=True)
        self.status = Path(f"/proc/{pid}/status")
        self.log = log
        self.samples = []
        self.start()

    def run(self):
        with contextlib.suppress(OSError):
            while match := re.search(r"VmRSS:\s*(\d+)", self.status.read_text(encoding="ascii")):
                with contextlib.suppress(OSError):
                    self.samples.append((self.log.stat().st_size, int(match[1])))
                time.sleep(SAMPLE_PERIOD)

    def results(self):
        """Summarises the session without its warm-up and without its end, where plots are made."""
        self.join()
        end = self.log.stat().st_size
        steady = [s for s in self.samples if WARM_UP * end < s[0] < 0.99 * end]
        if len(steady) < FEWEST:
            return {"samples": len(steady), "growth_KiB": None}
        sizes = [size for _, size in steady]
        part = len(sizes) // 5
        return {
            "samples": len(steady),
            "least_KiB": min(sizes),
            "largest_KiB": max(sizes),
            "growth_KiB": statistics.median(sizes[-part:]) - statistics.median(sizes[:part]),
            "history_KiB": sizes[:: max(1, len(sizes) // 20)],
        }


@contextlib.contextmanager
def hogs(count, seconds):
    """Keeps `count` cores busy for at most `seconds`, even if this process is killed."""
    if count == 0:
        yield
        return
    command = ["stress-ng", "--quiet", "--cpu", str(count), "--timeout", str(seconds)]
    with subprocess.Popen(command, stdin=subprocess.DEVNULL) as process:
        try:
            yield
            if process.poll() is not None:
                raise SystemExit(f"stress-ng ended early: exit {process.returncode}")
        finally:
            process.terminate()


def hpdm_json(command, answers=(0, 1)):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in answers or not done.stdout:
        raise SystemExit(done.stderr.strip() or f"{command[0]}: exit {done.returncode}")
    return json.loads(done.stdout)


def run_session(options, scene, folder, extra):
    """Runs a session and returns its results; its folder remains."""
    command = [options.hpdm, "run", scene, "--clock", options.clock, "--json", "--out", folder]
    command += ["--seconds", str(options.seconds), "--fps", "0", *extra]
    command += ["--no-pictures"] if options.clock == "lockstep" else ["--live"]
    load = os.getloadavg()[0]
    began = time.monotonic()
    with hogs(options.hogs, options.seconds + 120), subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        memory = Memory(process.pid, folder / "session.lcmlog")
        output, errors = process.communicate()
    if not output:
        raise SystemExit(errors.strip() or f"{options.hpdm}: exit {process.returncode}")
    session = json.loads(output)
    return {
        "seconds": options.seconds,
        "wall_s": round(time.monotonic() - began, 1),
        "load_before": round(load, 2),
        "ended": 0 if process.returncode == 0 else errors.strip().splitlines()[-1],
        "ticks": session["haptic"]["ticks"],
        "skipped": session["haptic"]["skipped"],
        "steps": session["deformation"]["steps"],
        "memory": memory.results(),
    }


def judge(options, folder, results, extra):
    """Returns the checks of the session of `results`: [{name, holds, text}]."""
    health = hpdm_json([options.hpdm, "log", "check", "--json", folder, *extra])
    channels = {channel["channel"]: channel for channel in health["channels"]}
    amiss = {key: sum(c[key] for c in channels.values()) for key in ("lost", "unreadable", "gaps")}
    amiss["out of order"] = sum(c["not_rising"] for c in channels.values())
    for name in ("HPDM_TOOL", "HPDM_FORCE"):
        amiss[f"of {name}"] = channels.get(name, {}).get("messages", 0) - results["ticks"]
    amiss["damaged bytes"] = health["damaged_bytes"] + health["torn_bytes"]
    amiss["times back"] = health["time_back"]
    amiss["not closed"] = 0 if health["closed"] else 1
    wrong = ", ".join(f"{count} {what}" for what, count in amiss.items() if count)
    if results["ended"]:
        wrong += f"; {results['ended']}"
    results["events"] = health["events"]
    results["invariants"] = health["invariants"]
    memory = results["memory"]
    growth = memory["growth_KiB"]
    checks = [
        {
            "name": "complete",
            "holds": not wrong,
            "text": wrong or f"{health['events']:,} messages of {len(channels)} channels",
        },
        {
            "name": "memory",
            "holds": growth is None or growth < MEMORY_BOUND,
            "text": f"not judged: {memory['samples']} samples are too few"
            if growth is None
            else f"grows by {growth} KiB (bound {MEMORY_BOUND});"
            f" {memory['least_KiB']:,} to {memory['largest_KiB']:,} KiB",
        },
    ]
    for invariant in health["invariants"]:
        worst = "not finite" if invariant["worst"] is None else f"{invariant['worst']:.4g}"
        unit = f" {invariant['unit']}" if invariant["unit"] else ""
        text = f"{worst}{unit} (bound {invariant['bound']:.4g}), {invariant['checked']:,} values"
        if not invariant["holds"]:
            text += f"; {invariant['broken']:,} beyond the bound, first at {invariant['first_s']} s:"
            text += f" {invariant['what']}"
        checks.append({"name": invariant["name"], "holds": invariant["holds"], "text": text})
    return checks


def judge_replay(options, folder):
    """Computes a session again. Returns a check."""
    report = hpdm_json([options.hpdm, "replay", "--json", folder])
    first = report["first_difference"]
    text = f"{report['ticks']['compared']:,} ticks, {report['steps']['compared']:,} steps"
    if first:
        text += "; first difference: " + json.dumps(first)
    return {"name": "replay", "holds": report["result"] == "identical", "text": text}


def print_checks(title, results, checks):
    skipped = results["skipped"]["total"]
    print(
        f"{title}: {results['ticks']:,} ticks, {skipped:,} skipped, {results['steps']:,} steps"
        f" in {results['wall_s']} s, load {results['load_before']} before"
    )
    for check in checks:
        print(f"  {check['name']:9} {'ok    ' if check['holds'] else 'BROKEN'}  {check['text']}")
    sys.stdout.flush()


def write_traces(options, log, folder):
    """Writes the session's motion as a repeated trace for each instrument. Returns the files."""
    tables = folder / "tables"
    command = [options.hpdm, "log", "export", log, "--channels", "HPDM_TOOL", "--out", tables]
    hpdm_json([*command, "--json"])
    with open(tables / "HPDM_TOOL.csv", encoding="utf-8") as file:
        header = file.readline().strip().split(",")
        rows = [line.strip().split(",") for line in file][::TRACE_STEP]
    tools = sum(name.endswith(".joints[0]") for name in header)
    step = TRACE_STEP / 1000
    moving = int((options.stretch - sum(REST) - 1) / step)
    for tool in range(tools):
        first = header.index(f"tools[{tool}].joints[0]")
        motion = [",".join(row[first : first + 5]) for row in rows[:moving]]
        pattern = [(n * step, motion[0]) for n in range(int(REST[0] / step))]
        pattern += [(REST[0] + n * step, joints) for n, joints in enumerate(motion)]
        away = options.stretch - REST[1]
        pattern += [(away + n * step, motion[0]) for n in range(int(REST[1] / step))]
        with open(folder / f"{tool}.csv", "w", encoding="utf-8") as file:
            file.write("t,pitch,yaw,insertion,roll,jaw\n")
            for start in range(0, options.seconds, options.stretch):
                file.writelines(f"{start + at:.3f},{joints}\n" for at, joints in pattern)
    shutil.rmtree(tables)
    return [folder / f"{tool}.csv" for tool in range(tools)]


def hand_keys(settings):
    """Returns {instrument: {key: TOML value}} of the --hand arguments."""
    keys = {}
    for setting in settings:
        match = re.fullmatch(r"(.+)\.(\w+)=(.+)", setting)
        if not match:
            raise SystemExit(f"--hand {setting}: give NAME.KEY=VALUE, such as hook.depth=0.015")
        keys.setdefault(match[1], {})[match[2]] = match[3]
    return keys


def soak(options, folder):
    """Runs and checks the sessions. Returns {title: results} and whether all checks passed."""
    place = folder / "scene"
    place.mkdir()
    scene = write_scene(
        Path(options.scene), place, options.seed, options.strain, hand_keys(options.hand)
    )
    tables = tomllib.loads(scene.read_text("utf-8"))
    controls = random_controls(tables, options.seconds, options.seed)
    all_results, sound = {}, True

    def session(title, name, extra, checking=(), replayed=False):
        nonlocal sound
        results = run_session(options, scene, folder / name, extra)
        checks = judge(options, folder / name, results, checking)
        if replayed:
            checks.append(judge_replay(options, folder / name))
        print_checks(title, results, checks)
        all_results[name] = results | {"holds": {c["name"]: c["holds"] for c in checks}}
        sound = sound and all(check["holds"] for check in checks)
        if not options.out:
            shutil.rmtree(folder / name)

    if options.clock == "real":
        beside = f" beside {options.hogs} hogs" if options.hogs else ""
        session(f"{options.seconds} s{beside}", "session", controls)
        return all_results, sound
    tears = "attachment" in tables or "duct" in tables
    session(f"{options.seconds} s in lockstep", "session", controls, replayed=tears)
    if tears:
        return all_results, sound
    begin = folder / "begin"
    command = [options.hpdm, "run", scene, "--clock", "lockstep", "--no-pictures", "--json"]
    command += ["--seconds", str(options.stretch), "--out", begin]
    names = [tool["name"] for tool in hpdm_json(command)["tools"]]
    traces = write_traces(options, begin, folder)
    devices = [w for n, t in zip(names, traces) for w in ("--device", f"{n}=trace:{t}")]
    title = f"{options.seconds} s of repeating the first {options.stretch} s"
    session(title, "repeated", devices, ["--period", str(options.stretch)])
    return all_results, sound


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("scene", nargs="?", default=str(ROOT / "scenes" / "two_hands.toml"))
    parser.add_argument("--clock", choices=["real", "lockstep"], default="real")
    parser.add_argument("--seconds", type=int, help="session time [600; in lockstep 3600]")
    parser.add_argument("--hogs", type=int, default=0, help="number of processes that each keep a core busy")
    parser.add_argument("--seed", type=int, default=1, help="seed of the first hand")
    parser.add_argument("--hand", action="append", default=[], metavar="NAME.KEY=VALUE", help="key of a hand")
    parser.add_argument("--strain", choices=["small", "finite"], help="[the scene's]")
    parser.add_argument("--stretch", type=int, default=60, help="length of the repeated part, s")
    parser.add_argument("--json", metavar="FILE", help="write all results to FILE")
    parser.add_argument("--out", metavar="DIR", help="folder to create and keep")
    parser.add_argument("--hpdm", default=str(ROOT / "build" / "tools" / "hpdm"))
    options = parser.parse_args()
    if options.seconds is None:
        options.seconds = 600 if options.clock == "real" else 3600
    if options.seconds < 1 or options.hogs < 0:
        parser.error("--seconds: at least 1; --hogs: at least 0")
    if options.clock == "lockstep":
        if options.hogs:
            parser.error("--hogs: virtual time does not feel them; leave it out")
        if not 5 <= options.stretch <= options.seconds / 3:
            parser.error("--stretch: at least 5 s, and a third of --seconds at most")
    if options.hogs and shutil.which("stress-ng") is None:
        raise SystemExit("stress-ng is not installed: apt-get install stress-ng")
    if options.clock == "real":
        enter_private_network()
    with contextlib.ExitStack() as stack:
        if options.out:
            folder = Path(options.out)
            folder.mkdir(parents=True)
        else:
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        free = shutil.disk_usage(folder).free
        if free < BYTES_A_SECOND * options.seconds:
            raise SystemExit(f"{folder}: {free / 1e9:.1f} GB free, too little for the log; free space or choose another --out")
        results, sound = soak(options, folder)
    if options.json:
        Path(options.json).write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")
    return 0 if sound else 1


if __name__ == "__main__":
    sys.exit(main())
