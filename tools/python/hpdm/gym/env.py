"""One environment: a task on a session."""

import numpy as np

from ..session import Session
from .spaces import Box, Dict
from .task import Slot, Task

OBSERVATIONS = ("state", "rgb", "rgbd")
FAR = 2.0  # m: nothing is drawn beyond


def spaces_of(task, scene, observation, size):
    """Returns the action space and the observation space of a task."""
    action = Box(-1.0, 1.0, (task.ACTIONS * len(task.index),))
    width, height = size
    rgb = Box(0, 255, (height, width, 3), np.uint8)
    if observation == "state":
        return action, Box(-np.inf, np.inf, task.observe().shape)
    if observation == "rgb":
        return action, rgb
    return action, Dict({"rgb": rgb, "depth": Box(0.0, FAR, (height, width))})


def picture_of(source, observation, size, index=()):
    """Returns the observation "rgb" or "rgbd" of a session or of one in a batch."""
    width, height = size
    if observation == "rgb":
        return source.render(*index, width, height)
    arrays = source.render(*index, width, height, depth=True)
    return {"rgb": arrays["rgb"], "depth": np.minimum(arrays["depth"], np.float32(FAR))}


def check_arguments(observation, render_mode, options=None):
    """Refuses unknown observations, render modes and options."""
    if observation not in OBSERVATIONS:
        raise ValueError(f"observation: give one of {', '.join(OBSERVATIONS)}, not {observation!r}")
    if render_mode not in (None, "rgb_array"):
        raise ValueError(f"render_mode: give \"rgb_array\" or None, not {render_mode!r}")
    unknown = set(options or {}) - {"young", "pose", "delay", "seed"}
    if unknown:
        raise ValueError(f"options: {', '.join(sorted(unknown))} unknown; "
                         "give young, pose, delay or seed")


class Env:
    """A task as an environment, at 30 actions a second.

    Args:
        task: a Task class, such as hpdm.gym.Reach.
        observation: "state" (float32), "rgb" (uint8, height x width x 3) or "rgbd" (dict of "rgb"
            and "depth", float32, m).
        size: width and height of pictures, px.
        render_mode: "rgb_array" or None.
        weights: of terms, in place of the task's.

    An action has four numbers in -1..1 for each hand: velocities along the world's axes in units of
    0.1 m/s, and the jaw's opening speed. `info["terms"]` has the reward's terms, `info["draws"]` of
    reset() what was drawn.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 30}

    def __init__(self, task, observation="state", size=(64, 64), render_mode=None, weights=None):
        check_arguments(observation, render_mode)
        self.render_mode = render_mode
        self.observation = observation
        self.size = tuple(int(side) for side in size)
        scene, self._starts = task.shared()
        self.session = Session(scene, command="tip")
        self.task = task(Slot(self.session), scene, {**task.weights, **(weights or {})})
        self._random = np.random.default_rng()
        self.task.begin(self._random, self._starts, {})
        self.action_space, self.observation_space = spaces_of(
            self.task, scene, observation, self.size)
        self._running = False

    def _observe(self):
        if self.observation == "state":
            return self.task.observe()
        return picture_of(self.session, self.observation, self.size)

    def reset(self, *, seed=None, options=None):
        """Starts an episode. Returns (observation, info).

        Args:
            seed: of the draws; None continues with the last one's.
            options: "young": (low, high) Pa of the handled organ, one of eight values; "pose": m, the
                hands start up to this far along each axis from their place; "delay": steps between
                an action and its effect, a number or (low, high); "seed": like `seed`.
        """
        options = dict(options or {})
        check_arguments(self.observation, self.render_mode, options)
        seed = options.get("seed") if seed is None else seed
        if seed is not None:
            self._random = np.random.default_rng(seed)
            options["seed"] = seed
        draws = self.task.begin(self._random, self._starts, options)
        self._running = True
        return self._observe(), {"draws": draws}

    def step(self, action):
        """Acts for 1/30 s. Returns (observation, reward, terminated, truncated, info)."""
        if not self._running:
            raise RuntimeError("the episode has ended; call reset()")
        action = np.asarray(action, dtype=np.float32)
        if action not in self.action_space:
            raise ValueError(f"action: give {self.action_space.shape[0]} finite numbers in -1..1")
        self.task.act(action)
        self.session.step()
        reward, terminated, truncated, info = self.task.evaluate()
        self._running = not (terminated or truncated)
        return self._observe(), reward, terminated, truncated, info

    def render(self):
        """Returns a picture of 640 x 480, or None without a render mode."""
        return self.session.render() if self.render_mode == "rgb_array" else None

    def close(self):
        """Frees the session."""
        self.session.close()

    @property
    def unwrapped(self):
        """This environment."""
        return self
