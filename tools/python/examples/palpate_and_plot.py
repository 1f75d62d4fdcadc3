"""Presses the liver 20 mm deep and back, and plots the force over time.

Usage: palpate_and_plot.py [PICTURE.png]
"""

import sys

import matplotlib
import numpy as np

import hpdm

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

session = hpdm.Session(hpdm.scene_path("liver_palpation.toml"))
start = session.command["probe"][2]                # insertion, m
forces = []                                        # N, one for each millisecond
for step in range(120):                            # 4 s
    depth = 0.025 * (1 - np.cos(2 * np.pi * step / 120))
    session.command["probe"][2] = start + depth    # up to 20 mm below the surface
    session.step()
    forces.append(session.tick_forces[:, 0])
forces = np.linalg.norm(np.concatenate(forces), axis=1)
print(f"peak force {forces.max():.2f} N")

plt.plot(np.arange(len(forces)) / 1000, forces)
plt.xlabel("time (s)")
plt.ylabel("force on the hand (N)")
plt.savefig(sys.argv[1] if len(sys.argv) > 1 else "palpation.png")
