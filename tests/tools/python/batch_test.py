"""Batches: bit for bit the same as single sessions, whatever the number of threads."""

import os
import subprocess
import sys
import unittest

import numpy as np

import hpdm

SCENE = hpdm.Scene(hpdm.scene_path("two_hands.toml"))
NAMES = hpdm.Session._TOOL_ARRAYS + ("organ_force", "commands")


def commands_at(step, count):
    """Commands that differ from session to session: count x 2 x 5 of changes."""
    random = np.random.default_rng(step)
    changes = random.normal(0, 0.002, (count, 2, 5))
    changes[:, :, 2] -= 0.0015  # m, towards the liver
    changes[:, :, 3] = 0
    changes[:, :, 4] = random.uniform(-0.2, 0.1, (count, 2))
    return changes


def run(batch, steps):
    shown = []
    for step in range(steps):
        batch.commands += commands_at(step, batch.count)
        np.clip(batch.commands[..., 4], 0, 1, out=batch.commands[..., 4])
        batch.step()
        shown.append([getattr(batch, name).copy() for name in NAMES])
    return shown


class BatchTest(unittest.TestCase):
    def test_equals_single_sessions_on_any_number_of_threads(self):
        count, steps = 5, 30
        singles = []
        for i in range(count):
            session = hpdm.Session(SCENE, command="tip")
            shown = []
            for step in range(steps):
                session.commands += commands_at(step, count)[i]
                np.clip(session.commands[:, 4], 0, 1, out=session.commands[:, 4])
                session.step()
                shown.append([getattr(session, name).copy() for name in NAMES])
            singles.append((shown, session.organs["liver"].vertices.copy()))
        self.assertTrue(any(shown[-1][0].any() for shown, _ in singles))  # a hand feels something
        for threads in (1, 2, 4):
            with hpdm.Batch(SCENE, count, threads=threads, command="tip") as batch:
                self.assertEqual(batch.threads, threads)
                for step, arrays in enumerate(run(batch, steps)):
                    for name, array in zip(NAMES, arrays):
                        for i in range(count):
                            single = singles[i][0][step][NAMES.index(name)]
                            self.assertEqual(array[i].tobytes(), single.tobytes(), name)
                for i in range(count):
                    self.assertEqual(batch.vertices(i, "liver").tobytes(),
                                     singles[i][1].tobytes())

    def test_resets_and_loads_one_of_them(self):
        with hpdm.Batch(SCENE, 3, threads=2, device="sim", seeds=[1, 2, 3]) as batch:
            for _ in range(36):
                batch.step()
            state, forces = batch.save(1), batch.force.copy()
            self.assertTrue(forces.any())
            batch.reset(which=[1], seeds=[9])
            self.assertFalse(batch.force[1].any())
            np.testing.assert_array_equal(batch.force[[0, 2]], forces[[0, 2]])
            np.testing.assert_allclose([batch.time(0), batch.time(1)], [1.2, 0], rtol=1e-12)
            batch.load(1, state)
            np.testing.assert_array_equal(batch.force, forces)
            batch.step()
            session = hpdm.Session(SCENE, device="sim", seed=2)
            for _ in range(37):
                session.step()
            self.assertEqual(batch.force[1].tobytes(), session.force.tobytes())

    @unittest.skipIf("asan" in os.environ.get("LD_PRELOAD", ""), "it reserves memory of its own")
    def test_a_further_session_takes_little_memory(self):
        code = """
import os, sys, hpdm
batch = hpdm.Batch(hpdm.scene_path("liver_palpation.toml"), int(sys.argv[1]), threads=1)
start = batch.command["probe"][0, 2]
for step in range(36):
    batch.command["probe"][:, 2] = start + 0.001 * step
    batch.step()
assert batch.force.any()
with open("/proc/self/statm") as file:
    print(int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6)
"""
        one, many = (float(subprocess.run([sys.executable, "-c", code, count], check=True,
                                          capture_output=True, text=True).stdout)
                     for count in ("1", "33"))
        # MB; whole copies take 9
        self.assertLess((many - one) / 32, 2.5)

    def test_shapes(self):
        with hpdm.Batch(SCENE, 4, threads=1) as batch:
            shapes = {"force": (4, 2, 3), "tip": (4, 2, 3), "jaw": (4, 2), "joints": (4, 2, 5),
                      "contact_organ": (4, 2), "organ_force": (4, 1, 3), "commands": (4, 2, 5)}
            for name, shape in shapes.items():
                self.assertEqual(getattr(batch, name).shape, shape, name)
            self.assertEqual(batch.command["probe"].shape, (4, 5))
            batch.commands[2, 0, 0] = float("nan")
            with self.assertRaisesRegex(ValueError, "not finite"):
                batch.step()


if __name__ == "__main__":
    unittest.main()
