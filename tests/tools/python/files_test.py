"""Scenes, pictures, logs, static solutions and drivers."""

import os
import subprocess
import tempfile
import time
import unittest

import numpy as np

import hpdm

CASES = os.path.join(os.path.dirname(hpdm.scene_path("x")), "cases")


class FilesTest(unittest.TestCase):
    def test_keys_are_read_and_set(self):
        scene = hpdm.Scene(hpdm.scene_path("two_hands.toml"))
        self.assertEqual(scene["organ.liver.material.young"], 5000)
        scene["organ[0].material.young"] = 3000.5
        scene["organ.liver.material.density"] = 1000          # a new key
        scene["timing.patch_delay_ticks"] = 20
        scene["instrument.grasper.device.max_force"] = 4.0    # a new table
        scene["organ.liver.support[0].box_fraction.min"] = [0.0, 0.6, 0.0]
        scene["laparoscope.field_of_view_deg"] = 70.0
        self.assertEqual(scene["organ.liver.material.young"], 3000.5)
        self.assertEqual(scene["instrument.grasper.device.max_force"], 4.0)
        self.assertEqual(scene["organ.liver.support[0].box_fraction.min"], [0, 0.6, 0])
        self.assertIn("# Pa", scene.text)  # comments stay
        with self.assertRaises(KeyError):
            scene["organ.liver.material.prony"]
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "edited.toml")
            scene.write(path)
            again = hpdm.Scene(path)
            self.assertEqual(again["organ.liver.material.young"], 3000.5)
            self.assertEqual(again.organs, scene.organs)

    def test_a_picture_has_depth_organs_and_a_camera(self):
        session = hpdm.Session(hpdm.scene_path("liver_palpation.toml"))
        session.step()
        shown = session.render(160, 120, depth=True, organs=True)
        self.assertEqual((shown["rgb"].shape, shown["rgb"].dtype), ((120, 160, 3), np.uint8))
        np.testing.assert_array_equal(shown["rgb"], session.render(160, 120))
        liver = shown["organs"] == 0
        self.assertGreater(liver.mean(), 0.1)
        self.assertTrue(np.isfinite(shown["depth"][liver]).all())
        # Pixels of the organ, put into the world by depth and camera, lie on its surface.
        camera = session.camera(160, 120)
        rows, columns = np.nonzero(liver)
        K = camera["intrinsics"]
        z = shown["depth"][rows, columns]
        rays = np.stack([(columns + 0.5 - K[0, 2]) / K[0, 0], (rows + 0.5 - K[1, 2]) / K[1, 1],
                         np.ones(len(z))])
        points = camera["pose"][:3, :3] @ (rays * z) + camera["pose"][:3, 3:]
        organ = session.organs["liver"]
        corners = organ.vertices[organ.triangles]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        centres = corners.mean(axis=1)
        picked = np.random.default_rng(1).choice(len(z), 200)
        for p in points[:, picked].T:
            near = np.argsort(((centres - p) ** 2).sum(axis=1))[:8]
            off = np.abs(((p - centres[near]) * normals[near]).sum(axis=1)).min()
            self.assertLess(off, 3e-4)  # m: triangles are 3 mm long
        # The instrument hides the organ: it has neither its depth nor its number.
        self.assertTrue((shown["organs"] == -1).any())

    def test_a_load_is_solved(self):
        solved = hpdm.solve(os.path.join(CASES, "liver_press.toml"))
        load, moved = solved["load_forces"][0], solved["load_displacements"][0]
        self.assertEqual(solved["organ"], "liver")
        self.assertAlmostEqual(solved["compliance"] * load @ load / (load @ moved), 1)
        self.assertLess(solved["residual"], 1e-6)
        scene = hpdm.Scene(os.path.join(CASES, "liver_press.toml"))
        young = scene["organ[0].material.young"]
        scene["organ[0].material.young"] = 2.0 * young
        stiffer = hpdm.solve(scene)
        self.assertAlmostEqual(solved["compliance"] / stiffer["compliance"], 2, delta=1e-6)

    def test_a_log_has_columns(self):
        with tempfile.TemporaryDirectory() as folder:
            out = os.path.join(folder, "session")
            subprocess.run([os.environ["HPDM_PROGRAM"], "run", hpdm.scene_path("two_hands.toml"),
                            "--headless", "--clock", "lockstep", "--no-pictures", "--seconds",
                            "0.5", "--out", out], check=True, capture_output=True)
            log = hpdm.Log(os.path.join(out, "session.lcmlog"))
        self.assertLessEqual({"HPDM_FORCE", "HPDM_TOOL", "HPDM_CONTACT", "HPDM_EVENT"}, set(log))
        force = log["HPDM_FORCE"]
        self.assertEqual(force["tick"].dtype, np.int64)
        np.testing.assert_array_equal(force["tick"], np.arange(500))
        self.assertEqual(force["tools[1].force[2]"].dtype, np.float64)
        self.assertEqual(len(force["log_time_us"]), 500)
        self.assertIn("session.start", log["HPDM_EVENT"]["name"])
        with self.assertRaisesRegex(hpdm.InputError, "nowhere"):
            hpdm.Log("nowhere.lcmlog")

    def test_a_driver_moves_a_session(self):
        os.environ["LCM_DEFAULT_URL"] = f"udpm://239.255.76.{os.getpid() % 200 + 20}:7697?ttl=0"
        with tempfile.TemporaryDirectory() as folder:
            out = os.path.join(folder, "session")
            run = subprocess.Popen([os.environ["HPDM_PROGRAM"], "run",
                                    hpdm.scene_path("liver_palpation.toml"), "--headless",
                                    "--no-pictures", "--device", "lcm", "--seconds", "1.5", "--out",
                                    out], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            driver = hpdm.Driver()
            felt = 0.0
            while run.poll() is None:
                driver.publish([0, 0, 0.16, 0, 1])
                felt = max(felt, np.abs(driver.effort()).max())
                time.sleep(0.001)
            self.assertEqual(run.returncode, 0)
            tool = hpdm.Log(out)["HPDM_TOOL"]
        insertion = tool["tools[0].joints[2]"]
        self.assertGreater(np.count_nonzero(np.abs(insertion - 0.16) < 1e-3), 100)
        self.assertGreater(felt, 0)


if __name__ == "__main__":
    unittest.main()
