"""The contract of the learning tasks, which gymnasium's checker would test."""

import unittest

import numpy as np

import hpdm.gym
from hpdm.gym import TASKS, BedDissection, Env, Reach, VectorEnv


def run(env, seed, steps, options=None):
    """Plays random actions; returns observations, rewards and ends."""
    random = np.random.default_rng(seed)
    played = []
    observation, info = env.reset(seed=seed, options=options)
    played.append((observation, info["draws"]))
    for _ in range(steps):
        action = random.uniform(-1, 1, env.action_space.shape).astype(np.float32)
        result = env.step(action)
        played.append(result)
        if result[2] or result[3]:
            break
    return played


class GymTest(unittest.TestCase):
    def test_every_task_keeps_the_contract(self):
        for name, task in TASKS.items():
            with self.subTest(name):
                env = hpdm.gym.make(name)
                self.assertIs(type(env), Env)
                options = {"pose": 0.002, "delay": (0, 2)}
                first, again = run(env, 3, 12, options), run(env, 3, 12, options)
                other = run(env, 4, 12, options)
                self.assertEqual(first[0][1], again[0][1])
                self.assertNotEqual(first[0][1], other[0][1])
                for a, b in zip(first, again):
                    self.assertEqual(a[0].tobytes(), b[0].tobytes())
                    self.assertEqual(a[1], b[1])
                for observation, *_ in first:
                    self.assertIn(observation, env.observation_space)
                    self.assertEqual(observation.dtype, np.float32)
                for _, reward, terminated, truncated, info in first[1:]:
                    self.assertIs(type(reward), float)
                    self.assertIs(type(terminated), bool)
                    self.assertIs(type(truncated), bool)
                    self.assertFalse(terminated and truncated)
                    terms = sum(env.task.weights.get(term, 0) * value
                                for term, value in info["terms"].items())
                    self.assertAlmostEqual(reward, terms)
                self.assertLessEqual(set(env.task.weights), set(first[-1][4]["terms"]))
                self.assertIn(env.action_space.sample(), env.action_space)
                self.assertIn(env.observation_space.sample(), env.observation_space)
                env.close()

    def test_an_episode_ends_once(self):
        class Short(Reach):
            limit = 3
        env = Env(Short)
        with self.assertRaisesRegex(RuntimeError, "reset"):
            env.step(np.zeros(4, np.float32))
        env.reset(seed=1)
        env.task.goal = np.array([9.0, 9.0, 9.0])
        ends = [env.step(np.zeros(4, np.float32))[2:4] for _ in range(3)]
        self.assertEqual(ends, [(False, False), (False, False), (False, True)])
        with self.assertRaisesRegex(RuntimeError, "reset"):
            env.step(np.zeros(4, np.float32))
        env.reset(seed=1)
        env.task.goal = env.task.tip().copy()
        self.assertEqual(env.step(np.zeros(4, np.float32))[2:4], (True, False))

    def test_refuses_what_is_wrong(self):
        env = hpdm.gym.make("Reach")
        env.reset(seed=1)
        for action in (np.zeros(3, np.float32), np.full(4, 2.0), np.full(4, np.nan)):
            with self.assertRaisesRegex(ValueError, "action"):
                env.step(action)
        with self.assertRaisesRegex(ValueError, "options"):
            env.reset(options={"colour": 1})
        with self.assertRaisesRegex(ValueError, "observation"):
            Env(Reach, observation="sound")
        with self.assertRaisesRegex(ValueError, "render_mode"):
            Env(Reach, render_mode="human")
        with self.assertRaisesRegex(KeyError, "Reach"):
            hpdm.gym.make("Suture")

    def test_pictures_are_observations(self):
        for observation in ("rgb", "rgbd"):
            env = Env(Reach, observation=observation, size=(48, 32), render_mode="rgb_array")
            shown, _ = env.reset(seed=1)
            self.assertIn(shown, env.observation_space)
            rgb = shown if observation == "rgb" else shown["rgb"]
            self.assertEqual((rgb.shape, rgb.dtype), ((32, 48, 3), np.uint8))
            self.assertGreater(int(rgb.max()), 50)
        self.assertEqual(env.render().shape, (480, 640, 3))

    def test_a_softer_organ_is_a_draw(self):
        env = hpdm.gym.make("TissueRetraction")
        levels, env._starts.levels = env._starts.levels, 2
        env.reset(seed=1, options={"young": (2000, 4000)})
        _, info = env.reset(seed=2, options={"young": (2000, 4000)})
        self.assertIn(round(info["draws"]["young"]), (2000, 4000))
        self.assertEqual(env.reset(seed=2, options={})[1]["draws"]["young"], None)
        env._starts.levels = levels

    def test_a_vector_equals_single_environments(self):
        class Short(Reach):
            limit = 4
        vector = VectorEnv(Short, 3, threads=2)
        observations, info = vector.reset(seed=5)
        self.assertIn(observations, vector.observation_space)
        singles = [Env(Short) for _ in range(3)]
        for i, env in enumerate(singles):
            alone, own = env.reset(seed=5 + i)
            self.assertEqual(alone.tobytes(), observations[i].tobytes())
            self.assertEqual(own["draws"]["target"], info["draws"][i]["target"])
        random = np.random.default_rng(1)
        for step in range(6):
            actions = random.uniform(-1, 1, vector.action_space.shape).astype(np.float32)
            observations, rewards, terminated, truncated, info = vector.step(actions)
            for i, env in enumerate(singles):
                alone, reward, ended, cut, _ = env.step(actions[i])
                self.assertEqual((reward, ended, cut), (rewards[i], terminated[i], truncated[i]))
                if ended or cut:
                    self.assertEqual(alone.tobytes(), info["final_observation"][i].tobytes())
                    alone, _ = env.reset()
                self.assertEqual(alone.tobytes(), observations[i].tobytes())
            self.assertEqual(bool(truncated.any()), step == 3)

    def test_an_exercise_counts_what_its_scene_calls_an_error(self):
        env, vector = hpdm.gym.make("BedDissection"), VectorEnv(BedDissection, 2, threads=2)
        env.reset(seed=1)
        vector.reset(seed=1)
        burns = np.zeros(env.action_space.shape, np.float32).reshape(2, -1)
        burns[:, -1] = -1
        burns[1, -1] = 1  # the hook's pedal, in the air: 2 points after half a second
        points, rewards = [], []
        for _ in range(24):
            *_, rewards_of, _, _, info = vector.step([burns.ravel(), -np.abs(burns.ravel())])
            _, reward, _, _, own = env.step(burns.ravel())
            self.assertEqual(reward, rewards_of[0])
            points.append(own["terms"]["error_points"])
            rewards.append(rewards_of[1] - rewards_of[0])
        self.assertEqual(sum(points), 2)
        self.assertEqual(points[:14], [0] * 14)
        self.assertAlmostEqual(sum(rewards), 0.2 * 2)
        self.assertIn("away from tissue", env.session.exercise["errors"][0]["name"])

    def test_clip_and_cut_is_done_by_a_script_and_not_at_random(self):
        env = hpdm.gym.make("ClipAndCut")
        surgeon = ClippingSurgeon(env)
        self.assertTrue(surgeon.operate(seed=1))
        exercise = env.session.exercise
        self.assertEqual((exercise["step"], exercise["errors"]), (2, []))
        played = run(env, 1, surgeon.actions)
        self.assertEqual(len(played), surgeon.actions + 1, "as many random actions end nothing")
        self.assertEqual(env.session.exercise["step"], 0)

    def test_a_peg_transfer_is_done_by_a_script_and_not_at_random(self):
        env = hpdm.gym.make("PegTransfer")
        actions, success = transfer_ring(env)
        self.assertTrue(success)
        self.assertEqual(env.session.exercise["errors"], [])
        middle = env.session.organs["ring"].vertices.mean(axis=0)
        self.assertLess(np.linalg.norm(middle[:2] - [0.025, 0]), 0.006, "around the right peg")
        self.assertLess(middle[2], 0.004, "and on the board")
        run(env, 1, actions)
        self.assertFalse(env.session.exercise["passed"])

    def test_a_ring_that_is_let_go_in_the_air_is_lost(self):
        env = hpdm.gym.make("PegTransfer")
        for height, lost in ((0.030, ["the ring was lost"]), (0.0072, [])):
            transfer_ring(env, lower_to=height)
            self.assertEqual([error["name"] for error in env.session.exercise["errors"]], lost)


def transfer_ring(env, lower_to=0.0072):
    """Solves PegTransfer by way points. Returns the number of actions and the success."""
    env.reset(seed=1)
    front = np.array([-0.025, -0.011, 0])  # of the ring, whose upper side is 4.8 mm high
    over = front + [0.050, 0, 0]
    script = [(front + [0, 0, 0.040], 0), (front + [0, 0, 0.0066], 0), (None, -1),
              (front + [0, 0, 0.034], 0), (over + [0, 0, 0.034], 0), (over + [0, 0, lower_to], 0),
              (None, 0), (None, 1), (over + [0, 0, 0.040], 0)]
    actions = 0
    for to, jaw in script:
        for i in range(20 if to is None else 200):
            action = np.zeros(5, np.float32)
            action[3] = jaw
            if to is not None:
                away = to - env.task.tip()
                if np.linalg.norm(away) < 3e-4:
                    break
                action[:3] = np.clip(10 * away / 0.1, -0.3, 0.3)
            *_, terminated, truncated, info = env.step(action)
            actions += 1
            if terminated or truncated:
                return actions, info["successful_task"]
    return actions, False


class ClippingSurgeon:
    """Solves ClipAndCut by its observations: the jaws go across each mark and close."""

    PORT = np.array([0.132, -0.154, 0.061])  # m
    PAST = 0.004                             # m: the tip beyond the middle of the duct

    def __init__(self, env):
        self.env = env
        self.actions = 0

    def act(self, velocity, jaw=0.0, turn=0.0):
        action = np.zeros(7, np.float32)
        action[:3] = np.clip(np.asarray(velocity) / 0.1, -1, 1)
        action[3], action[5], action[6] = jaw, turn, self.held
        self.state, _, terminated, truncated, self.info = self.env.step(action)
        self.actions += 1
        return terminated or truncated

    def turn_for(self, tangent):
        """Returns the angle (rad) by which the jaws' axis, the tool's y, is off the duct."""
        x, y, z, w = self.state[-22:-18]
        x_axis = np.array([1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)])
        y_axis = np.array([2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)])
        angle = np.arctan2(-tangent @ x_axis, tangent @ y_axis)
        return (angle + np.pi / 2) % np.pi - np.pi / 2  # either side of the jaws

    def move(self, to, tangent, speed):
        for _ in range(400):
            away = to - self.state[:3]
            turn = self.turn_for(tangent)
            if np.linalg.norm(away) < 4e-4 and abs(turn) < 0.02:
                return
            velocity = 10 * away
            length = max(np.linalg.norm(velocity), 1e-9)
            self.act(velocity * min(1, speed / length), turn=np.clip(5 * turn, -1, 1))

    def close_on(self, place, tangent):
        back = (self.PORT - place) / np.linalg.norm(self.PORT - place)
        tip = place - self.PAST * back
        self.move(tip + 0.04 * back, tangent, 0.1)
        self.move(tip, tangent, 0.05)
        for jaw in [-1] * 12 + [0] * 3:
            if self.act(np.zeros(3), jaw=jaw):
                return
        self.move(tip + 0.05 * back, tangent, 0.1)
        for jaw in [1] * 12:
            self.act(np.zeros(3), jaw=jaw)

    def operate(self, seed):
        self.held = -1.0
        self.state, _ = self.env.reset(seed=seed)
        marks = self.state[-18:].reshape(3, 2, 3).astype(float)
        for place, tangent in marks[:2]:
            self.close_on(place, tangent)
        self.held = 1.0
        self.close_on(*marks[2])
        return self.info["successful_task"]


if __name__ == "__main__":
    unittest.main()
