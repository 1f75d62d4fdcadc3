"""What the tasks have in common: the hands, the draws and the reward."""

import collections

import numpy as np

from ..scene import Scene, scene_path
from ..session import Session

FORCE_LIMIT = 3.0   # N: above it a hand is rough
FORCE_FAILS = 8.0   # N: above it the episode fails
MAX_SPEED = 0.1     # m/s along each axis at an action of 1
WARM_UP_STEPS = 20  # the force guard ramps in over half a second


class Slot:
    """The arrays of one session, alone or in a batch."""

    ARRAYS = ("force", "peak_force", "tip", "velocity", "rotation", "jaw", "contact_organ", "contact_kind",
              "depth", "slip", "organ_force", "commands")

    def __init__(self, source, index=None):
        for name in self.ARRAYS:
            array = getattr(source, name)
            setattr(self, name, array if index is None else array[index])
        self._source = source
        self._index = index
        self.organs = source.scene.organs

    def vertices(self, organ):
        """Vertices of an organ, V x 3, m; live."""
        if self._index is None:
            return self._source.organs[organ].vertices
        return self._source.vertices(self._index, organ)

    def exercise(self):
        """The judgement of the scene's exercise, as Session.exercise."""
        if self._index is None:
            return self._source.exercise
        return self._source.exercise(self._index)

    def press(self, instrument, pressed):
        """Presses or releases the pedal of a hand."""
        index = () if self._index is None else (self._index,)
        self._source.press(*index, instrument, pressed)

    def exchange(self, instrument, held):
        """Gives a hand its instrument number `held` once its tip is free."""
        index = () if self._index is None else (self._index,)
        self._source.exchange(*index, instrument, held)

    def load(self, state):
        """Continues from a state."""
        if self._index is None:
            self._source.load(state)
        else:
            self._source.load(self._index, state)


class Starts:
    """States at the start of an episode by stiffness, warmed up: the hands stand, the forces are on.

    A draw of the stiffness takes one of `levels` values, evenly spaced in its logarithm, because each
    new value builds the organ again. They are kept.
    """

    levels = 8

    def __init__(self, scene):
        self._scene = scene
        self._states = {}

    def at(self, organ=None, young=None):
        """Returns the state with this Young's modulus (Pa); None: the scene's."""
        key = (organ, young)
        if key not in self._states:
            session = Session(self._scene, command="tip")
            if young is not None:
                session.organs[organ].set_young(young)
            for _ in range(WARM_UP_STEPS):
                session.step()
            self._states[key] = session.save()
        return self._states[key]

    def draw(self, rng, bounds):
        """Draws one of the levels between two bounds, Pa."""
        low, high = (float(b) for b in bounds)
        if not 0 < low <= high:
            raise ValueError(f"young: give two moduli above 0, the lower first, not {bounds}")
        level = int(rng.integers(self.levels))
        return float(np.exp(np.log(low) + level / (self.levels - 1) * (np.log(high / low))))


class Task:
    """One episode of a task in one session. Subclasses give the scene and the rules.

    Class attributes:
        SCENE: the file among HPDM's scenes.
        organ: the tissue that is handled; its stiffness can be drawn.
        hands: the instruments that act.
        weights: the reward is the sum of weight x term. Terms are per step.
        limit: steps after which an episode is truncated, at 30 a second.
    """

    SCENE = "liver_palpation.toml"
    organ = "liver"
    hands = ("probe",)
    limit = 300
    weights = {"time_step_cost": -0.01, "excessive_force": -0.1, "successful_task": 10.0,
               "failed_task": -10.0}

    @classmethod
    def make_scene(cls):
        """Returns the Scene of the task."""
        return Scene(scene_path(cls.SCENE))

    _shared = {}  # scene and starts by the scene's name and the function that makes it

    @classmethod
    def shared(cls):
        """Returns the scene and the starts, built once for all environments of the process."""
        key = cls.SCENE, cls.make_scene.__func__
        if key not in Task._shared:
            scene = cls.make_scene()
            Task._shared[key] = scene, Starts(scene)
        return Task._shared[key]

    def __init__(self, slot, scene, weights):
        self.slot = slot
        self.scene = scene
        self.weights = weights
        self.index = [scene.instruments.index(hand) for hand in self.hands]
        self.goal = np.zeros(3)

    # --- the rules of a subclass ---

    def begin_episode(self, rng, options):
        """Draws the episode's goal. Returns the draws."""
        return {}

    def act_more(self, instrument, values):
        """Takes what an action has for a hand beyond the first four numbers."""

    def extra_state(self):
        """Returns numbers of the task's own for the observation."""
        return self.goal

    def judge(self):
        """Returns (terms, success) after a step."""
        raise NotImplementedError

    # --- common ---

    ACTIONS = 4  # numbers of an action for each hand: three velocities and the jaw come first
    HAND_STATE = 11

    def begin(self, rng, starts, options):
        """Starts an episode. Returns the draws for `info`."""
        young = None
        if "young" in options:
            young = starts.draw(rng, options["young"])
        self.slot.load(starts.at(self.organ if young is not None else None, young))
        draws = {"young": young, "seed": options.get("seed")}
        reach = float(options.get("pose", 0.0))
        offsets = rng.uniform(-reach, reach, (len(self.index), 3))
        draws["pose"] = offsets.tolist()
        for i, offset in zip(self.index, offsets):
            self.slot.commands[i, :3] += offset
        low, high = (int(d) for d in np.broadcast_to(options.get("delay", 0), 2))
        if not 0 <= low <= high:
            raise ValueError(f"delay: give steps, 0 or more, not {options['delay']}")
        draws["delay"] = int(rng.integers(low, high, endpoint=True))
        self.pending = collections.deque(
            [np.zeros(self.ACTIONS * len(self.index)) for _ in range(draws["delay"])])
        self.steps = 0
        draws.update(self.begin_episode(rng, options))
        return draws

    def act(self, action):
        """Sets the commands of the next step from an action in -1..1."""
        self.pending.append(np.asarray(action, dtype=float))
        action = np.clip(self.pending.popleft(), -1, 1).reshape(len(self.index), self.ACTIONS)
        stride = MAX_SPEED / 30
        for i, hand in zip(self.index, action):
            self.slot.commands[i, :3] += stride * hand[:3]
            # The command stays near the tool, so that the border of the workspace holds no way.
            away = self.slot.commands[i, :3] - self.slot.tip[i]
            self.slot.commands[i, :3] = self.slot.tip[i] + np.clip(away, -0.02, 0.02)
            self.slot.commands[i, 4] = np.clip(self.slot.commands[i, 4] + 0.1 * hand[3], 0, 1)
            self.act_more(i, hand[4:])

    def observe(self):
        """Returns the state: of each hand tip, velocity, force, jaw and contact; then the task's."""
        parts = []
        for i in self.index:
            parts += [self.slot.tip[i], self.slot.velocity[i], self.slot.force[i],
                      [self.slot.jaw[i], float(self.slot.contact_kind[i])]]
        parts.append(self.extra_state())
        return np.concatenate(parts).astype(np.float32)

    def evaluate(self):
        """Returns (reward, terminated, truncated, info) after a step."""
        self.steps += 1
        terms, success = self.judge()
        force = max(float(self.slot.peak_force[i]) for i in self.index)
        failed = force > FORCE_FAILS
        terms["time_step_cost"] = 1.0
        terms["excessive_force"] = max(0.0, force - FORCE_LIMIT)
        terms["successful_task"] = float(success)
        terms["failed_task"] = float(failed)
        reward = sum(self.weights.get(name, 0.0) * value for name, value in terms.items())
        terminated = bool(success or failed)
        truncated = bool(not terminated and self.steps >= self.limit)
        info = {"terms": terms, "successful_task": bool(success), "force": force}
        return float(reward), terminated, truncated, info

    def tip(self, hand=0):
        """Position of a hand's tip, m."""
        return self.slot.tip[self.index[hand]]

    def distance(self, hand=0):
        """Distance of a hand's tip from the goal, m."""
        return float(np.linalg.norm(self.tip(hand) - self.goal))

    def grasps(self, hand, organ):
        """True if a hand holds tissue of the organ."""
        i = self.index[hand]
        return (self.slot.contact_kind[i] == 2
                and self.slot.organs[self.slot.contact_organ[i]] == organ)


GENERAL = Task.weights  # of the terms that all tasks have
