"""Many episodes of one task on a batch."""

import numpy as np

from ..batch import Batch
from .env import check_arguments, picture_of, spaces_of
from .spaces import Box, Dict
from .task import Slot


def batched(space, count):
    """Returns the space of `count` members of a space, stacked."""
    if isinstance(space, Dict):
        return Dict({name: batched(one, count) for name, one in space.spaces.items()})
    return Box(space.low, space.high, (count, *space.shape), space.dtype)


class VectorEnv:
    """`count` episodes of a task that step together; one that ends starts again in the same step.

    Arguments as of Env, and `threads` as of Batch. Observations, rewards and ends have `count` in
    front. In the step that ends an episode the observation is the next one's first, and
    `info["final_observation"][i]` and `info["final_info"][i]` are those of the end.
    """

    def __init__(self, task, count, threads=None, observation="state", size=(64, 64),
                 render_mode=None, weights=None):
        check_arguments(observation, render_mode)
        self.render_mode = render_mode
        self.num_envs = count
        self.observation = observation
        self.size = tuple(int(side) for side in size)
        scene, self._starts = task.shared()
        self.batch = Batch(scene, count, threads=threads, command="tip")
        self._options = {}
        weights = {**task.weights, **(weights or {})}
        self.tasks = [task(Slot(self.batch, i), scene, weights) for i in range(count)]
        self._randoms = [np.random.default_rng() for _ in range(count)]
        for one, random in zip(self.tasks, self._randoms):
            one.begin(random, self._starts, {})
        self.single_action_space, self.single_observation_space = spaces_of(
            self.tasks[0], scene, observation, self.size)
        self.action_space = batched(self.single_action_space, count)
        self.observation_space = batched(self.single_observation_space, count)

    def _observe(self, i):
        if self.observation == "state":
            return self.tasks[i].observe()
        return picture_of(self.batch, self.observation, self.size, (i,))

    def _stack(self, observations):
        if self.observation == "rgbd":
            return {name: np.stack([one[name] for one in observations]) for name in ("rgb", "depth")}
        return np.stack(observations)

    def _begin(self, i):
        return self.tasks[i].begin(self._randoms[i], self._starts, self._options)

    def reset(self, *, seed=None, options=None):
        """Starts all episodes. `seed`: a number (episode i gets seed + i) or one for each."""
        options = dict(options or {})
        check_arguments(self.observation, self.render_mode, options)
        seed = options.pop("seed", None) if seed is None else seed
        self._options = options
        if seed is not None:
            seeds = range(seed, seed + self.num_envs) if np.ndim(seed) == 0 else seed
            self._randoms = [np.random.default_rng(int(s)) for s in seeds]
        draws = [self._begin(i) for i in range(self.num_envs)]
        return self._stack([self._observe(i) for i in range(self.num_envs)]), {"draws": draws}

    def step(self, actions):
        """Acts in all of them. Returns (observations, rewards, terminated, truncated, info)."""
        actions = np.asarray(actions, dtype=np.float32)
        if actions not in self.action_space:
            raise ValueError(f"actions: give finite numbers in -1..1, shape {self.action_space.shape}")
        for task, action in zip(self.tasks, actions):
            task.act(action)
        self.batch.step()
        results = [task.evaluate() for task in self.tasks]
        rewards, terminated, truncated = (
            np.array([result[k] for result in results]) for k in range(3))
        info = {"terms": [result[3]["terms"] for result in results],
                "final_observation": [None] * self.num_envs, "final_info": [None] * self.num_envs,
                "draws": [None] * self.num_envs}
        observations = [self._observe(i) for i in range(self.num_envs)]
        for i in np.flatnonzero(terminated | truncated):
            info["final_observation"][i] = observations[i]
            info["final_info"][i] = results[i][3]
            info["draws"][i] = self._begin(i)
            observations[i] = self._observe(i)
        return self._stack(observations), rewards, terminated, truncated, info

    def render(self):
        """Returns a picture of each episode, or None without a render mode."""
        if self.render_mode != "rgb_array":
            return None
        return [self.batch.render(i) for i in range(self.num_envs)]

    def close(self):
        """Ends the batch."""
        self.batch.close()
