"""Sessions: the same bits as `hpdm run`, after a reset, a load and in a clone."""

import os
import subprocess
import tempfile
import unittest
from unittest import mock

import numpy as np

import hpdm

PRESS = hpdm.scene_path("two_hands.toml")


def program(*arguments):
    """Runs the program hpdm, which must succeed."""
    subprocess.run([os.environ["HPDM_PROGRAM"], *arguments], check=True, capture_output=True)


def arrays(session):
    """Everything that a session shows."""
    shown = [getattr(session, name).copy() for name in session._TOOL_ARRAYS]
    shown += [session.organ_force.copy(), session.tick_forces]
    for organ in session.organs.values():
        shown += [organ.vertices.copy(), organ.control_points.copy(), organ.force.copy()]
    return shown


def steps(session, count):
    """Steps and returns what each step shows."""
    shown = []
    for _ in range(count):
        session.step()
        shown += arrays(session)
    return shown


class SessionTest(unittest.TestCase):
    def assert_same_bits(self, first, second):
        self.assertEqual(len(first), len(second))
        for a, b in zip(first, second):
            self.assertEqual(a.tobytes(), b.tobytes())

    def assert_continues(self, scene, before, after, **options):
        """A clone and a loaded session continue bit for bit, and both touch something."""
        session = hpdm.Session(scene, **options)
        steps(session, before)
        state, clone = session.save(), session.clone()
        shown = steps(session, after)
        forces = shown[::len(arrays(session))]
        self.assertTrue(any(force.any() for force in forces))
        self.assert_same_bits(shown, steps(clone, after))
        session.load(state)
        self.assert_same_bits(shown, steps(session, after))

    def test_has_the_bits_of_a_lockstep_session_of_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            out, own = os.path.join(folder, "session"), os.path.join(folder, "own")
            program("run", PRESS, "--headless", "--clock", "lockstep", "--no-pictures",
                    "--seconds", "2", "--out", out)
            log = hpdm.Log(out)["HPDM_FORCE"]
            session = hpdm.Session(PRESS, device="sim")
            session.record(own)
            forces = []
            for _ in range(60):
                session.step()
                forces.append(session.tick_forces)
            session.close()
            self.assert_recorded_as(out, own)
        forces = np.concatenate(forces)
        self.assertEqual(len(forces), 2000)
        self.assertGreater(np.abs(forces[:, 0]).max(), 0.05)  # N: it presses
        for tool in range(2):
            for axis in range(3):
                logged = log[f"tools[{tool}].force[{axis}]"][:2000]
                self.assertEqual(logged.tobytes(), forces[:, tool, axis].tobytes())

    def assert_recorded_as(self, program_folder, own_folder):
        """The same log, of which the program makes the same forces."""
        logs = []
        for folder in (program_folder, own_folder):
            with open(os.path.join(folder, "session.lcmlog"), "rb") as file:
                logs.append(file.read())
        self.assertEqual(*logs)
        program("log", "check", own_folder)
        program("replay", own_folder)

    def test_a_record_begins_at_the_start_and_ends_where_the_course_does(self):
        session = hpdm.Session(PRESS)
        with tempfile.TemporaryDirectory() as folder:
            first, second = os.path.join(folder, "first"), os.path.join(folder, "second")
            session.step()
            with self.assertRaisesRegex(RuntimeError, "begins at the start"):
                session.record(first)
            session.reset()
            session.record(first)
            with self.assertRaisesRegex(RuntimeError, "recorded already"):
                session.record(second)
            steps(session, 3)
            session.reset()  # ends the record
            steps(session, 5)
            self.assertEqual(len(hpdm.Log(first)["HPDM_FORCE"]["tick"]), 100)
            session.reset()
            with self.assertRaisesRegex(hpdm.InputError, "already has a session"):
                session.record(first)
            session.organs["liver"].set_young(4000)
            with self.assertRaisesRegex(hpdm.InputError, "replay would not know it"):
                session.record(second)

    def test_a_record_without_its_network_leaves_nothing(self):
        session = hpdm.Session(PRESS)
        with tempfile.TemporaryDirectory() as folder, \
                mock.patch.dict(os.environ, LCM_DEFAULT_URL="garbage://"):
            new, own = os.path.join(folder, "new"), os.path.join(folder, "own")
            os.mkdir(own)
            for path in (new, own):
                with self.assertRaisesRegex(hpdm.InputError, "LCM_DEFAULT_URL"):
                    session.record(path, live=True)
            self.assertEqual((os.listdir(folder), os.listdir(own)), (["own"], []))
            session.record(new)  # neither the session nor the folder's name is taken
            steps(session, 3)
            session.close()
            self.assertEqual(len(hpdm.Log(new)["HPDM_FORCE"]["tick"]), 100)

    def test_a_reset_is_a_new_session_with_that_seed(self):
        session = hpdm.Session(PRESS, device="sim")
        first = steps(session, 30)
        session.reset(seed=7)
        again = steps(session, 30)
        new = steps(hpdm.Session(hpdm.Scene(PRESS), device="sim", seed=7), 30)
        self.assert_same_bits(again, new)
        self.assertTrue(any(a.tobytes() != b.tobytes() for a, b in zip(first, again)))

    def test_continues_under_hands_that_press_and_pull(self):
        self.assert_continues(PRESS, 40, 30, device="sim")

    def test_continues_with_organs_that_touch_each_other(self):
        self.assert_continues(hpdm.scene_path("abdomen_on_springs.toml"), 45, 12, device="sim")

    def test_continues_in_finite_strain_and_with_memory(self):
        scene = hpdm.Scene(PRESS)
        scene["organ.liver.lattice.cells"] = [3, 3, 3]
        scene["organ.liver.energy.strain"] = "finite"
        self.assert_continues(scene, 36, 4, device="sim")
        scene["organ.liver.energy.strain"] = "adaptive"
        prony = "\n[[organ.material.prony]]\nshare = 0.4\ntime = 0.3\n"
        self.assert_continues(hpdm.Scene.parse(scene.text + prony, scene.path), 36, 10,
                              device="sim")
        # Elastic supports of viscoelastic tissue refer to the relaxation.
        text = hpdm.Scene(PRESS).text.replace("fixed = true", "stiffness = 3e7") + prony
        self.assert_continues(hpdm.Scene.parse(text, PRESS), 40, 20, device="sim")

    def test_continues_with_other_models_of_tissue(self):
        scene = hpdm.Scene(hpdm.scene_path("liver_palpation.toml"))
        text = scene.text.replace("liver_5000", "liver_1332")
        head, tail = text.split("  [organ.lattice]")
        support = tail[tail.index("  [[organ.support]]"):]
        for model in ("continuum", "mass_spring"):
            material = "  [organ.material]\n  young = 5000\n"
            text = head + f'model = "{model}"\n' + material + support
            self.assert_continues(hpdm.Scene.parse(text, scene.path), 36, 5, device="sim")

    def test_a_modulus_that_is_set_is_that_of_a_new_session(self):
        session = hpdm.Session(PRESS, device="sim")
        steps(session, 35)
        session.organs["liver"].set_young(8123.0)
        scene = hpdm.Scene(PRESS)
        scene["organ.liver.material.young"] = 8123.0
        shown = steps(session, 40)
        self.assert_same_bits(shown, steps(hpdm.Session(scene, device="sim"), 40))
        session.reset()
        self.assert_same_bits(shown, steps(session, 40))

    def test_arrays_are_live_and_stay_in_place(self):
        session = hpdm.Session(PRESS, device="sim")
        liver = session.organs["liver"]
        vertices, moved, force = liver.vertices, liver.displacements, session.force
        self.assertEqual(vertices.dtype, np.float64)
        self.assertEqual(vertices.shape, liver.rest.shape)
        self.assertFalse(vertices.flags.writeable)
        steps(session, 40)
        state = session.save()
        self.assertGreater(np.abs(moved).max(), 1e-3)
        np.testing.assert_array_equal(moved, vertices - liver.rest)
        session.reset()
        self.assertFalse(moved.any())
        session.load(state)
        self.assertGreater(np.abs(moved).max(), 1e-3)
        self.assertTrue(np.shares_memory(vertices, liver.vertices))
        self.assertTrue(force.any())
        del session, liver
        self.assertTrue(np.isfinite(vertices).all() and force.any())  # they keep the memory

    def test_a_command_is_reached_at_the_end_of_the_step(self):
        session = hpdm.Session(PRESS, command="tip")
        goal = session.tip[0] + [0.001, -0.002, 0.003]
        session.command["probe"][:3] = goal
        session.step()
        np.testing.assert_allclose(session.tip[0], goal, atol=1e-12)  # round-off of the kinematics
        np.testing.assert_allclose(session.velocity[1], 0, atol=1e-12)
        axes = hpdm.Session(PRESS)
        axes.command["probe"] = session.joints[0]
        axes.step()
        np.testing.assert_allclose(axes.tip[0], goal, atol=1e-12)
        axes.command["probe"][2] = 9  # m: beyond the workspace
        axes.step()
        self.assertLess(axes.joints[0, 2], 0.31)

    def test_the_force_on_the_organ_is_that_on_the_hand(self):
        session = hpdm.Session(hpdm.scene_path("liver_palpation.toml"))
        start = session.command["probe"][2]
        for _ in range(40):
            session.command["probe"][2] = start + 0.04
            session.step()
        # A hand that stands: no friction in the trocar, no damping, full authority.
        np.testing.assert_allclose(session.organs["liver"].force, -session.force[0], atol=1e-9)
        self.assertGreater(np.linalg.norm(session.force), 0.1)
        self.assertEqual((session.contact_organ[0], session.contact_kind[0]), (0, 1))
        self.assertGreater(session.depth[0], 0.005)

    def test_says_nothing_and_writes_nothing(self):
        with tempfile.TemporaryDirectory() as folder:
            code = ("import hpdm\n"
                    "session = hpdm.Session(hpdm.scene_path('two_hands.toml'), device='sim')\n"
                    "[session.step() for _ in range(30)]")
            done = subprocess.run([os.sys.executable, "-c", code], cwd=folder, check=True,
                                  capture_output=True, text=True)
            self.assertEqual((done.stdout, done.stderr, os.listdir(folder)), ("", "", []))

    def test_an_attachment_tears_and_a_clone_tears_it_alike(self):
        scene = hpdm.Scene(hpdm.scene_path("gallbladder_bed.toml"))
        for organ in scene.organs:
            scene[f"organ.{organ}.lattice.cells"] = [4, 4, 4]
        scene["organ.liver.lattice.local_functions"] = 0
        scene["attachment[0].strength"] = 1000.0
        scene["attachment[0].toughness"] = 1.0
        session = hpdm.Session(scene, device="sim")
        session.step()
        bed = session.attachments[0]
        self.assertEqual((bed["a"], bed["b"], bed["freed_area"]), ("gallbladder", "liver", 0))
        self.assertEqual(bed["damage"].max(), 0)
        steps(session, 120)
        before, clone = session.attachments[0], session.clone()
        self.assertGreater(before["damage"].max(), 0)
        steps(session, 20)
        steps(clone, 20)
        torn, alike = session.attachments[0], clone.attachments[0]
        self.assertTrue((torn["damage"] >= before["damage"]).all())
        self.assert_same_bits([torn["damage"], torn["load"]], [alike["damage"], alike["load"]])
        self.assertAlmostEqual(torn["freed_area"], torn["area"][torn["damage"] == 1].sum(), 12)
        bound = (1 + 1e-12) * (torn["area"] * torn["damage"]).sum()  # 1 J/m^2
        self.assertLessEqual(torn["dissipated"], bound)

    def test_reports_events(self):
        session = hpdm.Session(PRESS)
        session.exchange("probe", 1)
        steps(session, 2)
        events = session.events()
        self.assertEqual([name for _, _, name, _ in events], ["instrument.exchanged"])
        self.assertEqual(session.events(), [])


if __name__ == "__main__":
    unittest.main()
