"""Exercises in sessions: a scripted surgeon to the end, and scripted errors with a near miss beside each."""

import json
import os
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import hpdm

sys.path.insert(0, os.environ["HPDM_EXAMPLES"])
import dissect_bed  # noqa: E402


def coarse_scene():
    """Returns the exercise on coarse lattices, with a strong hook and a small part of the bed to free."""
    scene = hpdm.Scene(hpdm.scene_path("bed_dissection.toml"))
    for organ in scene.organs:
        scene[f"organ.{organ}.lattice.cells"] = [4, 4, 4]
    scene["organ.liver.lattice.local_functions"] = 0
    scene["instrument.hook.power"] = 400.0
    scene["exercise.step[2].area"] = 1e-4
    return scene


class Trainee(dissect_bed.Surgeon):
    """A surgeon who also does what is wrong."""

    def press_on(self, organ, place, depth):
        """Presses the hook on an organ's surface near a place, along its shaft. Returns its way in."""
        rest = self.session.organs[organ].rest
        point = rest[np.argmin(np.linalg.norm(rest - place, axis=1))]
        trocar = np.array([self.session.scene["instrument.hook.trocar"]]).ravel()
        inward = (point - trocar) / np.linalg.norm(point - trocar)
        self.move("hook", point - 0.02 * inward, 0.2)
        self.move("hook", point + (depth - 0.0015) * inward, 0.02)
        return inward

    def burn_for(self, seconds):
        self.session.press("hook", True)
        self.step(round(30 * seconds))
        self.session.press("hook", False)
        self.step(3)

    def press_until(self, organ, place, limit):
        """Presses deeper until the force passes the limit, or 4.2 N without one; returns the largest."""
        inward = self.press_on(organ, place, 0.001)
        peak = 0.0
        while peak < (limit or 4.2) and self.session.time < 30:
            self.targets["hook"][:3] += 0.0002 * inward
            self.step()
            peak = max(peak, np.linalg.norm(self.session.organ_force[0]))
        self.targets["hook"][:3] -= 0.01 * inward
        self.step(5)
        return peak


class ExerciseTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scene = coarse_scene()
        session = hpdm.Session(cls.scene, command="tip")
        cls.start = session.save()
        surgeon = dissect_bed.Surgeon(session)
        surgeon.take_fundus()
        surgeon.lift(0.010)
        cls.lifted, cls.targets = session.save(), surgeon.targets

    def surgeon(self, lifted=False):
        """Returns a surgeon at the start, or one that holds the fundus lifted."""
        session = hpdm.Session(self.scene, command="tip")
        surgeon = Trainee(session)
        if lifted:
            session.load(self.lifted)
            surgeon.targets = {name: target.copy() for name, target in self.targets.items()}
        return surgeon

    def errors(self, surgeon):
        return [error["name"] for error in surgeon.session.exercise["errors"]]

    def test_a_scripted_surgeon_does_all_steps_without_an_error(self):
        surgeon = self.surgeon()
        surgeon.run(part=1.1e-4 / surgeon.session.attachments[0]["area"].sum())
        exercise = surgeon.session.exercise
        self.assertEqual(self.errors(surgeon), [])
        self.assertTrue(exercise["passed"])
        self.assertEqual(len(exercise["step_times"]), 4)
        self.assertTrue(np.all(np.diff(exercise["step_times"]) > 0))
        self.assertEqual(exercise["score"], 100)  # before the target time
        bed = surgeon.session.attachments[0]
        self.assertGreater(bed["burnt_area"], 0.9 * bed["freed_area"])
        names = [name for _, _, name, _ in surgeon.session.events()]
        self.assertEqual(names.count("exercise.step"), 4)
        self.assertEqual(names.count("exercise.end"), 1)

    def test_two_runs_and_the_record_have_the_same_score(self):
        outcomes = []
        with tempfile.TemporaryDirectory() as folder:
            surgeon = self.surgeon()
            surgeon.session.close()
            scene_file = os.path.join(folder, "scene.toml")
            self.scene.write(scene_file)
            for out in (os.path.join(folder, "a"), os.path.join(folder, "b")):
                session = hpdm.Session(hpdm.Scene(scene_file), command="tip")
                session.record(out)
                surgeon = dissect_bed.Surgeon(session)
                surgeon.run(part=0.8e-4 / session.attachments[0]["area"].sum())
                session.end_record()
                outcomes.append(session.exercise)
            self.assertEqual(outcomes[0]["step_times"], outcomes[1]["step_times"])
            done = subprocess.run([os.environ["HPDM_PROGRAM"], "report", "--json",
                                   os.path.join(folder, "a")],
                                  check=True, capture_output=True, text=True)
            report = json.loads(done.stdout)["exercise"]
        self.assertEqual(report["score"], outcomes[0]["score"])
        self.assertEqual([step["done_s"] for step in report["steps"]][:2],
                         outcomes[0]["step_times"][:2])

    def test_a_hook_on_the_wall_is_a_burn_after_its_time(self):
        for seconds, errors in ((0.2, []), (0.45, ["burn of the gallbladder's wall"])):
            surgeon = self.surgeon()
            surgeon.press_on("gallbladder", [0.0225, -0.085, 0.010], 0.002)
            surgeon.burn_for(seconds)
            self.assertEqual(self.errors(surgeon), errors, seconds)

    def test_a_hook_on_the_liver_is_a_burn_after_its_time(self):
        for seconds, errors in ((0.2, []), (0.45, ["burn of the liver"])):
            surgeon = self.surgeon()
            surgeon.press_on("liver", [0.035, -0.062, 0.045], 0.003)
            surgeon.burn_for(seconds)
            self.assertEqual(self.errors(surgeon), errors, seconds)

    def test_a_hook_in_the_air_is_an_error_after_its_time(self):
        for seconds, errors in ((0.4, []), (0.6, ["hook energised away from tissue"])):
            surgeon = self.surgeon()
            surgeon.step(5)
            surgeon.burn_for(seconds)
            self.assertEqual(self.errors(surgeon), errors, seconds)

    def test_jaws_that_open_far_from_the_tissues_place_drop_it(self):
        for lower, errors in ((0.009, []), (0, ["the gallbladder was dropped"])):
            surgeon = self.surgeon(lifted=True)
            surgeon.lift(0.006)
            surgeon.lift(-lower)
            surgeon.step(15)
            surgeon.close("grasper", 1)
            surgeon.step(5)
            self.assertEqual([name for name in self.errors(surgeon) if "torn" not in name], errors)

    def test_a_press_above_the_limit_is_an_error(self):
        for limit, errors in ((None, ["more than 4 N on tissue"]), (3.9, [])):
            surgeon = self.surgeon()
            peak = surgeon.press_until("liver", [0.035, -0.062, 0.045], limit)
            self.assertEqual(self.errors(surgeon), errors, peak)

    def test_a_strong_pull_tears_and_a_light_one_does_not(self):
        for length, torn in ((0.002, False), (0.030, True)):
            surgeon = self.surgeon(lifted=True)
            surgeon.lift(length)
            surgeon.step(30)
            self.assertEqual("the bed was torn" in self.errors(surgeon), torn, length)


if __name__ == "__main__":
    unittest.main()
