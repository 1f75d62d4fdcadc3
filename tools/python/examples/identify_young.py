"""Finds the liver's Young's modulus from a recorded press by least squares.

The record is a motion of the tip and the force on the hand. Here a session with a hidden modulus
makes it, with noise of 2 mN. Usage: identify_young.py
"""

import numpy as np

import hpdm

HIDDEN = 7300.0  # Pa


def forces_of(session, motion):
    """Plays the motion (insertion, m, of each step) and returns the forces, N."""
    session.reset()
    forces = []
    for insertion in motion:
        session.command["probe"][2] = insertion
        session.step()
        forces.append(session.mean_force[0].copy())
    return np.array(forces)


session = hpdm.Session(hpdm.scene_path("liver_palpation.toml"))
start = session.command["probe"][2]
motion = start + np.concatenate([np.full(20, 0.0), np.linspace(0, 0.042, 40)])
liver = session.organs["liver"]

liver.set_young(HIDDEN)
measured = forces_of(session, motion)
measured += np.random.default_rng(1).normal(0, 0.002, measured.shape)

young = 4000.0  # the first guess
for _ in range(3):  # Gauss-Newton on ln E
    change = 0.02
    liver.set_young(young)
    forces = forces_of(session, motion)
    liver.set_young(young * np.exp(change))
    slope = (forces_of(session, motion) - forces) / change
    young *= np.exp(np.vdot(slope, measured - forces) / np.vdot(slope, slope))
    print(f"E = {young:.0f} Pa")
print(f"hidden {HIDDEN:.0f} Pa, found {young:.0f} Pa")
assert abs(young / HIDDEN - 1) < 0.02
