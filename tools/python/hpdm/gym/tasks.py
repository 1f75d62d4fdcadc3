"""The tasks. Names of terms and phases are those of LapGym (ScheiklP/sofa_env, MIT) where they
mean the same. All weights are stated here; those of LapGym are zero until a user sets them."""

import numpy as np

from ..scene import Scene, scene_path
from .exercises import BedDissection, ClipAndCut, PegTransfer
from .task import GENERAL, Task


class Reach(Task):
    """Bring the tip of the probe within 3 mm of a target in the free space before the liver."""

    SCENE = "liver_palpation.toml"
    limit = 150
    weights = {**GENERAL, "distance_to_target": -10.0, "delta_distance_to_target": -50.0}
    RADIUS = 0.003  # m

    def begin_episode(self, rng, options):
        away = rng.uniform(-0.02, 0.02, 3)
        away[2] = abs(away[2])  # not into the liver
        self.goal = self.tip() + away
        self._last = self.distance()
        return {"target": self.goal.tolist()}

    def judge(self):
        distance = self.distance()
        terms = {"distance_to_target": distance, "delta_distance_to_target": distance - self._last}
        self._last = distance
        return terms, distance < self.RADIUS


class PalpateNodule(Task):
    """Find a stiff nodule in the liver by pressing, and rest on it.

    The place of the nodule is not in the state: only the force tells. Done when the tip presses with
    0.1 to 3 N within 8 mm of the nodule's axis for ten steps.
    """

    limit = 600
    weights = {**GENERAL, "distance_to_nodule": -1.0, "presses": 0.02, "on_nodule": 0.2}
    NODULE = (0.015, -0.02, 0.045)  # m
    RADIUS = 0.008                  # m
    YOUNG = 50e3                    # Pa: ten times the liver

    @classmethod
    def make_scene(cls):
        scene = Scene(scene_path("liver_palpation.toml"))
        nodule = f"""
[[organ.region]]
sphere = {{ centre = [{', '.join(map(str, cls.NODULE))}], radius = 0.010 }}
young = {cls.YOUNG}
"""
        return Scene.parse(scene.text + nodule, scene.path)

    def begin_episode(self, rng, options):
        # The hand starts at a random place over the lobe.
        i = self.index[0]
        shift = rng.uniform(-0.02, 0.02, 2)
        self.slot.commands[i, :2] += shift
        self._held = 0
        return {"start_shift": shift.tolist()}

    def extra_state(self):
        i = self.index[0]
        return [float(self.slot.depth[i]), np.linalg.norm(self.slot.force[i])]

    def judge(self):
        force = float(np.linalg.norm(self.slot.force[self.index[0]]))
        away = float(np.linalg.norm(self.tip()[:2] - np.asarray(self.NODULE[:2])))
        presses = 0.1 < force < 3
        on = presses and away < self.RADIUS
        self._held = self._held + 1 if on else 0
        terms = {"distance_to_nodule": away, "presses": float(presses), "on_nodule": float(on)}
        return terms, self._held >= 10


class TissueRetraction(Task):
    """Grasp the liver's edge and lift it to a target. Phases: grasp, retract."""

    SCENE = "two_hands.toml"
    hands = ("grasper",)
    limit = 400
    weights = {**GENERAL, "distance_to_grasping_position": -2.0, "one_time_reward_grasped": 5.0,
               "distance_to_end_position": -5.0, "lost_grasp": -5.0}
    GRASP = (-0.03, -0.01, 0.05)  # m, on the surface
    LIFT = 0.015                  # m

    def begin_episode(self, rng, options):
        self._grasped = False
        self._had = False
        lift = np.array([0.0, 0.0, self.LIFT]) + rng.uniform(-0.003, 0.003, 3)
        self._lift = lift
        self.goal = np.asarray(self.GRASP) + lift
        return {"end_position": self.goal.tolist()}

    def extra_state(self):
        return np.concatenate([self.GRASP, self.goal, [float(self._grasped)]])

    def judge(self):
        grasped = bool(self.grasps(0, self.organ))
        terms = {
            "distance_to_grasping_position":
                0.0 if grasped else float(np.linalg.norm(self.tip() - np.asarray(self.GRASP))),
            "one_time_reward_grasped": float(grasped and not self._had),
            "lost_grasp": float(self._grasped and not grasped),
        }
        self._had = self._had or grasped
        if grasped and not self._grasped:  # the target counts from where the tissue was taken
            self.goal = self.tip() + self._lift
        self._grasped = grasped
        distance = self.distance()
        terms["distance_to_end_position"] = distance if grasped else 0.0
        return terms, grasped and distance < 0.004


class GraspLiftTouch(Task):
    """Grasp the gallbladder's fundus, lift it, and touch the liver beneath with the probe.

    Phases: grasp, lift, touch. The probe stands for LapGym's cauter.
    """

    SCENE = "abdomen_on_springs.toml"
    organ = "gallbladder"
    hands = ("grasper", "probe")
    limit = 600
    weights = {**GENERAL, "distance_gripper_gallbladder": -1.0, "gallbladder_is_grasped": 0.02,
               "lost_grasp_on_gallbladder": -5.0, "phase_change": 5.0,
               "distance_cauter_target": -2.0, "force_on_gallbladder": -0.01}
    FUNDUS = (0.008, -0.110, 0.032)   # m
    LIFT = 0.008                      # m
    TARGET = (0.035, -0.062, 0.045)   # m, the quadrate lobe
    PHASES = ("grasp", "lift", "touch")

    def begin_episode(self, rng, options):
        self._phase = 0
        self._grasped = False
        self._lifted_from = 0.0
        self.goal = np.asarray(self.TARGET) + rng.uniform(-0.003, 0.003, 3)
        return {"target": self.goal.tolist()}

    def extra_state(self):
        return np.concatenate([self.FUNDUS, self.goal, [float(self._phase)]])

    def judge(self):
        grasped = bool(self.grasps(0, "gallbladder"))
        before = self._phase
        if self._phase == 0 and grasped:
            self._phase, self._lifted_from = 1, float(self.tip(0)[2])
        lifted = float(self.tip(0)[2]) - self._lifted_from
        if self._phase == 1 and grasped and lifted > self.LIFT:
            self._phase = 2
        if self._phase > 0 and not grasped:
            self._phase = 0
        organ = self.slot.organs.index("gallbladder")
        terms = {
            "distance_gripper_gallbladder":
                0.0 if grasped else float(np.linalg.norm(self.tip(0) - np.asarray(self.FUNDUS))),
            "gallbladder_is_grasped": float(grasped),
            "lost_grasp_on_gallbladder": float(self._grasped and not grasped),
            "phase_change": float(self._phase > before),
            "distance_cauter_target": self.distance(1),
            "force_on_gallbladder": float(np.linalg.norm(self.slot.organ_force[organ])),
        }
        self._grasped = grasped
        touches = self.slot.contact_kind[self.index[1]] == 1 and self.distance(1) < 0.010
        return terms, self._phase == 2 and bool(touches)


class TwoHandManipulation(Task):
    """Press and pull the liver with two hands until two marks on it are at their targets.

    The marks are vertices near the hands' places. Done when both are within 2 mm.
    """

    SCENE = "two_hands.toml"
    hands = ("probe", "grasper")
    limit = 600
    weights = {**GENERAL, "sum_distance_markers_to_target": -20.0, "sum_markers_at_target": 0.1}
    MARKS = ((0.015, -0.005, 0.057), (-0.03, -0.01, 0.05))  # m, at rest
    RADIUS = 0.002                                          # m

    def __init__(self, slot, scene, weights):
        super().__init__(slot, scene, weights)
        rest = np.array(slot.vertices(self.organ))
        self._vertices = [int(np.argmin(((rest - mark) ** 2).sum(axis=1))) for mark in self.MARKS]
        self._rest = rest[self._vertices]

    def begin_episode(self, rng, options):
        moves = np.array([[0, 0, -0.006], [0, 0, 0.006]]) + rng.uniform(-0.002, 0.002, (2, 3))
        self.goals = self._rest + moves
        return {"targets": self.goals.tolist()}

    def _marks(self):
        return self.slot.vertices(self.organ)[self._vertices]

    def extra_state(self):
        return np.concatenate([self._marks().ravel(), self.goals.ravel()])

    def judge(self):
        distances = np.linalg.norm(self._marks() - self.goals, axis=1)
        at = distances < self.RADIUS
        terms = {"sum_distance_markers_to_target": float(distances.sum()),
                 "sum_markers_at_target": float(at.sum())}
        return terms, bool(at.all())


TASKS = {task.__name__: task for task in (Reach, PalpateNodule, TissueRetraction, GraspLiftTouch,
                                          TwoHandManipulation, BedDissection, ClipAndCut,
                                          PegTransfer)}
