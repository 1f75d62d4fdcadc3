"""Steps sixteen palpations together with random actions, and prints their rate.

Usage: random_batch.py [COUNT] [STEPS]
"""

import sys
import time

import numpy as np

import hpdm

count = int(sys.argv[1]) if len(sys.argv) > 1 else 16
steps = int(sys.argv[2]) if len(sys.argv) > 2 else 60
random = np.random.default_rng(1)

with hpdm.Batch(hpdm.scene_path("liver_palpation.toml"), count, command="tip") as batch:
    command = batch.command["probe"]                  # count x 5
    began = time.perf_counter()
    for _ in range(steps):
        command[:, :3] += random.normal(0, 0.002, (count, 3))
        command[:, 2] -= 0.0005                       # towards the liver
        batch.step()
    seconds = time.perf_counter() - began
    force = np.linalg.norm(batch.force[:, 0], axis=1)
    print(f"{count * steps / seconds:.0f} steps/s on {batch.threads} threads; "
          f"{np.count_nonzero(force)} of {count} touch, up to {force.max():.2f} N")
