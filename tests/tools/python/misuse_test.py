"""Mistakes: one clear exception each, never a crash."""

import os
import threading
import unittest

import numpy as np

import hpdm

SCENE = hpdm.Scene(hpdm.scene_path("two_hands.toml"))


class MisuseTest(unittest.TestCase):
    def setUp(self):
        self.session = hpdm.Session(SCENE)

    def assert_fails(self, kind, words, call):
        with self.assertRaises(kind) as failed:
            call()
        self.assertIn(words, str(failed.exception))
        self.assertNotIn("\n", str(failed.exception))

    def test_wrong_scenes(self):
        self.assert_fails(TypeError, "path", lambda: hpdm.Scene(3))
        self.assert_fails(hpdm.InputError, "nowhere.toml", lambda: hpdm.Scene("nowhere.toml"))
        with self.assertRaises(hpdm.InputError) as failed:
            hpdm.Scene.parse(SCENE.text.replace("young = 5000", "young = -5"), SCENE.path)
        error = failed.exception
        self.assertEqual(error.file, SCENE.path)
        self.assertEqual(error.key, "organ[0].material.young")
        line = [i for i, text in enumerate(SCENE.text.split("\n"), 1) if "young =" in text][0]
        self.assertEqual(error.line, line)

    def test_a_cut_has_no_session(self):
        cut = ("\n[[cut]]\norgan = \"liver\"\n"
               "strip = [[[0, 0, -0.1], [0, 0, 0.1]], [[0.02, 0, -0.1], [0.02, 0, 0.1]]]\n")
        scene = hpdm.Scene.parse(SCENE.text + cut, SCENE.path)
        self.assert_fails(hpdm.InputError, "only hpdm solve", lambda: hpdm.Session(scene))

    def test_wrong_keys(self):
        scene = hpdm.Scene(SCENE.path)

        def set_key(key, value):
            scene[key] = value
        for key, value, words in (("organ.spleen.material.young", 1, "spleen"),
                                  ("organ.liver.material.yuong", 1.0, "did you mean young"),
                                  ("organ.liver.material.young", -1.0, "above 0"),
                                  ("organ.liver.material.young", "soft", "young"),
                                  ("organ.liver.material", 1, "is a table"),
                                  ("organ.liver.material.young.x", 1, "no further keys")):
            self.assert_fails(hpdm.InputError, words, lambda k=key, v=value: set_key(k, v))
        self.assert_fails(ValueError, "finite",
                          lambda: set_key("organ.liver.material.young", float("nan")))
        self.assert_fails(TypeError, "dict", lambda: set_key("timing.haptic_hz", {}))
        self.assertEqual(scene.text, SCENE.text)
        self.assert_fails(KeyError, "organ.liver.x", lambda: scene["organ.liver.x"])

    def test_wrong_names(self):
        self.assert_fails(KeyError, "probe, grasper", lambda: self.session.command["scalpel"])
        self.assert_fails(KeyError, "liver", lambda: self.session.organs["spleen"])
        self.assert_fails(KeyError, "probe", lambda: self.session.exchange("scalpel", 0))
        self.assert_fails(IndexError, "it has 3", lambda: self.session.exchange("probe", 3))
        self.assert_fails(hpdm.InputError, "unknown device",
                          lambda: hpdm.Session(SCENE, device="joystick"))
        self.assert_fails(hpdm.InputError, "real clock", lambda: hpdm.Session(SCENE, device="lcm"))
        self.assert_fails(hpdm.InputError, "window", lambda: hpdm.Session(SCENE, device="mouse"))
        self.assert_fails(ValueError, "tip", lambda: hpdm.Session(SCENE, command="voice"))

    def test_wrong_commands(self):
        with self.assertRaises(ValueError):
            self.session.command["probe"][:] = [1, 2]
        with self.assertRaises(ValueError):
            self.session.command["probe"] = np.zeros((2, 5))
        with self.assertRaises(ValueError):
            self.session.command["probe"] = "left"
        with self.assertRaises((TypeError, ValueError)):
            self.session.force[0, 0] = 1  # read only
        for value in (float("nan"), float("inf")):
            session = hpdm.Session(SCENE)
            session.command["grasper"][1] = value
            self.assert_fails(ValueError, 'command["grasper"]', session.step)
            session.command["grasper"][1] = 0
            session.step()
            self.assertTrue(np.isfinite(session.tip).all())

    def test_wrong_numbers(self):
        liver = self.session.organs["liver"]
        for young in (0, -1, float("nan"), 1e13):
            self.assert_fails(ValueError, "young", lambda y=young: liver.set_young(y))
        self.assert_fails(ValueError, "seed", lambda: self.session.reset(-1))
        self.assert_fails(TypeError, "seed", lambda: self.session.reset(1.5))
        self.assert_fails(TypeError, "count", lambda: hpdm.Batch(SCENE, 2.5))
        self.assert_fails(ValueError, "count", lambda: hpdm.Batch(SCENE, 0))
        self.assert_fails(ValueError, "threads", lambda: hpdm.Batch(SCENE, 2, threads=0))
        self.assert_fails(ValueError, "seeds", lambda: hpdm.Batch(SCENE, 2, seeds=[1]))
        self.assert_fails(ValueError, "pixels", lambda: self.session.render(4, 4))
        with self.assertRaises(TypeError):
            self.session.load("state")

    def test_a_state_of_another_scene(self):
        other = hpdm.Session(hpdm.scene_path("liver_palpation.toml")).save()
        self.assert_fails(ValueError, "another scene", lambda: self.session.load(other))
        with hpdm.Batch(SCENE, 2, threads=1) as batch:
            self.assert_fails(ValueError, "another scene", lambda: batch.load(0, other))
            self.assert_fails(IndexError, "has 2", lambda: batch.save(2))
            self.assert_fails(IndexError, "has 2", lambda: batch.reset(which=[-1]))

    def test_use_after_close(self):
        vertices = self.session.organs["liver"].vertices
        self.session.close()
        for call in (self.session.step, self.session.reset, self.session.save, self.session.render,
                     self.session.clone, lambda: self.session.time,
                     lambda: self.session.organs["liver"].vertices):
            self.assert_fails(RuntimeError, "closed", call)
        self.session.close()  # closed already
        self.assertTrue(np.isfinite(vertices).all())
        batch = hpdm.Batch(SCENE, 2, threads=2)
        force = batch.force
        batch.close()
        self.assert_fails(RuntimeError, "closed", batch.step)
        self.assertFalse(force.any())

    def test_two_threads_on_one_session(self):
        session = hpdm.Session(SCENE, device="sim")
        failures = []

        def work():
            for _ in range(300):
                try:
                    session.step()
                except RuntimeError as error:
                    failures.append(str(error))
        threads = [threading.Thread(target=work) for _ in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertTrue(failures)
        self.assertEqual(len(set(failures)), 1)
        self.assertIn("another thread", failures[0])
        self.assertEqual(session.steps, 900 - len(failures))

    def test_a_forked_child_has_no_threads(self):
        batch = hpdm.Batch(SCENE, 4, threads=2)
        batch.step()
        session = hpdm.Session(SCENE)
        session.render(64, 64)
        child = os.fork()
        if child == 0:
            code = 1
            try:
                told = 0
                for call in (batch.step, lambda: session.render(64, 64)):
                    try:
                        call()
                    except RuntimeError as error:
                        told += "spawn" in str(error)
                session.step()  # has no threads
                code = 0 if told == 2 else 2
                del batch, session
            finally:
                os._exit(code)
        self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), 0)
        batch.step()
        batch.close()


if __name__ == "__main__":
    unittest.main()
