#!/usr/bin/python3
"""Measures the module on this machine and writes tools/python/RESULTS.md.

Usage: PYTHONPATH=build/python tools/python/benchmark/benchmark.py [--out FILE] [--quick | --memory]

Rates are medians of rounds of CPU time or wall time, as the table says. What is compared runs in
turn. Memory is the resident size of a process of its own; --memory measures it alone, also on a
loaded machine, and replaces its row.
"""

import argparse
import os
import resource
import statistics
import subprocess
import sys
import time

import numpy as np

import hpdm

PALPATION = hpdm.scene_path("liver_palpation.toml")
ABDOMEN = hpdm.scene_path("abdomen_on_springs.toml")


def palpate(command, start, step):
    """A press of up to 15 mm, and 2 mm of slide, once in two seconds."""
    phase = 2 * np.pi * step / 60
    command[..., 2] = start + 0.0225 * (1 - np.cos(phase))
    command[..., 1] = 0.01 * np.sin(phase)


def median_rate(work, rounds, count):
    """Median of steps a second over rounds, by CPU time of this thread."""
    rates = []
    for _ in range(rounds):
        began = time.thread_time()
        work(count)
        rates.append(count / (time.thread_time() - began))
    return statistics.median(rates), max(rates)


def palpation_rate(rounds):
    session = hpdm.Session(PALPATION)
    start = session.command["probe"][2]
    command, force = session.command["probe"], session.force
    touched = [0]

    def work(count):
        for step in range(count):
            palpate(command, start, step)
            session.step()
            state = np.concatenate([session.tip[0], session.velocity[0], force[0], session.jaw])
            touched[0] += bool(state[6:9].any())
    work(60)
    touched[0] = 0
    rate = median_rate(work, rounds, 240)
    return rate, touched[0] / (rounds * 240)


def abdomen_rate(rounds):
    session = hpdm.Session(ABDOMEN, device="sim")
    for _ in range(60):
        session.step()
    state = session.save()

    def work(count):
        session.load(state)
        for _ in range(count):
            session.step()
            np.concatenate([session.tip.ravel(), session.force.ravel(),
                            session.organ_force.ravel()])
    return median_rate(work, rounds, 60)


def reset_ms(rounds):
    session = hpdm.Session(PALPATION)
    start = session.command["probe"][2]
    times = []
    for _ in range(10 * rounds):
        for step in range(20):
            session.command["probe"][2] = start + 0.002 * step
            session.step()
        began = time.thread_time()
        session.reset()
        times.append(1e3 * (time.thread_time() - began))
    return statistics.median(times)


def frame_rates(rounds, size):
    session = hpdm.Session(PALPATION, device="sim")
    for _ in range(40):
        session.step()
    session.render(size, size)
    rates = []
    for _ in range(rounds):
        began = time.perf_counter()
        for _ in range(20):
            session.render(size, size)
        rates.append(20 / (time.perf_counter() - began))
    return statistics.median(rates), max(rates)


def overhead_us(rounds):
    """What a call of step() adds to a step in C++: calls against as many steps within one call, in
    turn, of a hand that rests. The difference of the fastest rounds."""
    session = hpdm.Session(PALPATION)
    steps = 200
    called, at_once = [], []

    def call():
        for _ in range(steps):
            session.step()
    call()  # the start
    for _ in range(10 * rounds):
        for work, times in ((call, called), (lambda: session._native.run(steps), at_once)):
            began = time.thread_time()
            work()
            times.append(1e6 * (time.thread_time() - began) / steps)
    return min(called) - min(at_once), min(at_once)


def memory_of(count):
    """Resident memory of a process with `count` palpations in contact, MB; 0: of Python alone."""
    code = f"""
import os, hpdm
def resident():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6
if {count} > 0:
    batch = hpdm.Batch({PALPATION!r}, {count}, threads=1)
    start = batch.command["probe"][0, 2]
    for step in range(40):
        batch.command["probe"][:, 2] = start + 0.001 * step
        batch.step()
    assert batch.force.any(axis=(1, 2)).all()
print(resident())
"""
    return float(subprocess.run([sys.executable, "-c", code], check=True, capture_output=True,
                                text=True).stdout)


MEMORY = "memory of 64 palpations over one"


def memory_row():
    bare, one, many = memory_of(0), memory_of(1), memory_of(64)
    return (MEMORY, f"{many / one:.2f} ({many:.0f} and {one:.0f} MB; Python with the module "
                    f"{bare:.0f} MB)", "<= 1.5")


def line(row):
    return "| " + " | ".join(row) + " |\n"


def replace_memory_row(path):
    with open(path, encoding="utf-8") as file:
        lines = file.readlines()
    at = [i for i, text in enumerate(lines) if text.startswith(f"| {MEMORY} |")]
    if len(at) != 1:
        sys.exit(f"{path}: has no row \"{MEMORY}\"; run the benchmark without --memory")
    lines[at[0]] = line(memory_row())
    with open(path, "w", encoding="utf-8") as file:
        file.writelines(lines)
    print(lines[at[0]], end="")


def batch_share(rounds, threads):
    """Rate of a batch of 64 over that of single sessions in as many threads, in turn."""
    import threading
    count, steps = 64, 10
    scene = hpdm.Scene(PALPATION)
    batch = hpdm.Batch(scene, count, threads=threads)
    singles = [hpdm.Session(scene) for _ in range(threads)]
    start = singles[0].command["probe"][2]
    shares = []
    for step in range(40):
        palpate(batch.command["probe"], start, step)
        batch.step()
        for session in singles:
            palpate(session.command["probe"], start, step)
            session.step()

    def alone(session):
        for step in range(steps * count // threads):
            palpate(session.command["probe"], start, 40 + step % steps)
            session.step()
    for _ in range(rounds):
        began = time.perf_counter()
        for step in range(steps):
            palpate(batch.command["probe"], start, 40 + step)
            batch.step()
        together = time.perf_counter() - began
        workers = [threading.Thread(target=alone, args=(s,)) for s in singles]
        began = time.perf_counter()
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        shares.append((time.perf_counter() - began) / together)
    return statistics.median(shares)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--out", default=os.path.join(os.path.dirname(__file__), "..", "RESULTS.md"))
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--memory", action="store_true")
    options = parser.parse_args()
    if options.memory:
        replace_memory_row(options.out)
        return
    load = os.getloadavg()[0]
    rounds = 2 if options.quick else 9
    (palpation, fastest), touching = palpation_rate(rounds)
    abdomen, abdomen_fastest = abdomen_rate(max(2, rounds // 2))
    small, small_fastest = frame_rates(rounds, 64)
    large, large_fastest = frame_rates(rounds, 256)
    memory = memory_row()
    threads = len(os.sched_getaffinity(0))
    overhead, resting = overhead_us(rounds)
    rows = [
        ("palpation, state observation, 30 Hz actions, one core",
         f"{palpation:.0f} steps/s (fastest round {fastest:.0f}); {100 * touching:.0f} % touch",
         ">= 2,000 (aim 4,000)"),
        ("abdomen with all contacts, state, one core",
         f"{abdomen:.0f} steps/s (fastest round {abdomen_fastest:.0f})", ">= 150"),
        memory,
        (f"rate of a batch of 64 over single sessions, {threads} threads",
         f"{batch_share(max(2, rounds // 2), threads):.2f}", ">= 0.9"),
        ("reset (liver_palpation)", f"{reset_ms(max(1, rounds // 3)):.2f} ms", "<= 1 ms"),
        ("RGB of 64 x 64", f"{small:.0f} frames/s (fastest round {small_fastest:.0f})", ">= 200"),
        ("RGB of 256 x 256", f"{large:.0f} frames/s (fastest round {large_fastest:.0f})", ">= 60"),
        ("overhead of step()", f"{overhead:.2f} us on {resting:.0f} us of a hand that rests",
         "<= 5 us"),
    ]
    text = ("# Results of the Python module\n\n"
            "`PYTHONPATH=build/python tools/python/benchmark/benchmark.py` measures this table. Rates on one core\n"
            "and the reset are by the thread's CPU time, the others by wall time; medians of rounds.\n"
            "What is compared runs in turn. Load of the machine at the start: "
            f"{load:.1f} on {threads} cores; a loaded machine shows lower rates. Peak memory of the benchmark: "
            f"{resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3:.0f} MB.\n\n"
            "| what | measured | target |\n|---|---|---|\n")
    text += "".join(line(row) for row in rows)
    with open(options.out, "w", encoding="utf-8") as file:
        file.write(text)
    print(text)


if __name__ == "__main__":
    main()
