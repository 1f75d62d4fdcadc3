"""Many sessions of one scene that step together."""

import os

from . import _native
from .scene import as_scene
from .session import Closing, Session, _Commands, _index, devices_of, seed_of


class Batch(Closing):
    """Sessions of one scene that share its constant model and step on several threads.

    Results equal those of single sessions bit for bit, whatever the number of threads.

    Args:
        scene: a Scene or a path.
        count: number of sessions.
        threads: how many work; None: one for each core that this process may use.
        device, command: as of Session.
        seeds: one for each session; None: the scene's own.

    Attributes: those of Session with `count` in front: command by name (count x 5), commands
    (count x I x 5), force (count x I x 3), organ_force (count x O x 3) and so on. Live views.
    """

    def __init__(self, scene, count, threads=None, device="command", command="axes", seeds=None):
        if isinstance(count, bool) or not hasattr(count, "__index__"):
            raise TypeError(f"count: give a whole number, not {count!r}")
        if not 1 <= count <= 100_000:
            raise ValueError(f"count: give 1 to 100,000, not {count}")
        scene = as_scene(scene)
        seeds = [0] * count if seeds is None else [seed_of(seed) for seed in seeds]
        if len(seeds) != count:
            raise ValueError(f"seeds: give {count}, one for each session, not {len(seeds)}")
        if threads is None:
            threads = len(os.sched_getaffinity(0))
        native = _native.Batch(scene._model(), devices_of(device), seeds, command, int(threads))
        self.scene = scene
        self._native = native
        #: Computes a step of every session. Without Python's lock.
        self.step = native.step
        self.commands = native.commands()
        self.command = _Commands(scene.instruments, self.commands)
        for name in Session._TOOL_ARRAYS:
            setattr(self, name, native.tool(name))
        self.organ_force = native.organ_forces()
        self.count = count

    @property
    def threads(self):
        """How many threads work."""
        return self._native.threads()

    def __len__(self):
        return self.count

    def reset(self, seeds=None, which=None):
        """Returns all sessions, or those numbered in `which`, to their start.

        `seeds`: one for each of them; None: the scene's own.
        """
        which = list(range(self.count)) if which is None else [int(i) for i in which]
        seeds = [0] * len(which) if seeds is None else [seed_of(seed) for seed in seeds]
        self._native.reset(which, seeds)

    def save(self, index):
        """Returns the state of one session."""
        return self._native.save(int(index))

    def load(self, index, state):
        """One session continues from a state of the same scene."""
        self._native.load(int(index), state)

    def vertices(self, index, organ):
        """Returns the vertices of one session's organ, V x 3, m: a live view."""
        return self._native.vertices(int(index), _index(self.scene.organs, organ, "organ"))

    def exercise(self, index):
        """The judgement of one session's exercise, as Session.exercise."""
        return self._native.exercise(int(index))

    def exchange(self, index, instrument, held):
        """Gives a hand of one session another instrument, as Session.exchange()."""
        self._native.exchange(
            int(index), _index(self.scene.instruments, instrument, "instrument"), int(held))

    def press(self, index, instrument, pressed=True):
        """Presses or releases the pedal of a hand of one session, as Session.press()."""
        self._native.press(
            int(index), _index(self.scene.instruments, instrument, "instrument"), bool(pressed))

    def time(self, index):
        """Virtual time of one session, s."""
        return self._native.time(int(index))

    def render(self, index, width=640, height=480, depth=False, organs=False):
        """Draws one session, as Session.render()."""
        arrays = self._native.render(int(index), int(width), int(height), bool(depth),
                                     bool(organs))
        return arrays if depth or organs else arrays["rgb"]

    def __repr__(self):
        return f"<hpdm.Batch of {self.count} x {self.scene.name!r}>"
