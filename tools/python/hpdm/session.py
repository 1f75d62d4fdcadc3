"""One session: steps, live arrays, pictures, states."""

import os

import numpy as np

from . import _native
from .scene import as_scene


#: What Session.save() returns; `time`: its virtual time, s.
State = _native.State


def devices_of(device):
    """Returns the list of devices from one or several."""
    names = [device] if isinstance(device, str) else list(device)
    for name in names:
        if not isinstance(name, str):
            raise TypeError(f"device: give strings, not {type(name).__name__}")
    return names


def seed_of(seed):
    """Returns a seed as a number of 32 bits; None: 0, the scene's own."""
    if seed is None:
        return 0
    if isinstance(seed, (bool, float)) or not hasattr(seed, "__index__"):
        raise TypeError(f"seed: give a whole number, not {seed!r}")
    seed = seed.__index__()
    if not 0 <= seed < 2**32:
        raise ValueError(f"seed: give 0 to 2^32 - 1, not {seed}")
    return seed


class _Names(dict):
    """A dictionary by name whose KeyError lists the names."""

    def __init__(self, kind, items):
        super().__init__(items)
        self._kind = kind

    def __missing__(self, name):
        raise KeyError(f"there is no {self._kind} {name!r}; the scene has {', '.join(self) or 'none'}")


class Organ:
    """One organ of a session. Arrays are live: a step changes them, nothing is copied.

    Attributes:
        name: the scene's name.
        vertices: V x 3, m, world axes, deformed, without the offset of breathing; read only.
        displacements: V x 3, m: vertices less those at rest; read only.
        control_points: n x 3, m: displacements of the control points; read only.
        force: 3, N: of all instruments on the organ in the last tick; read only.
        rest: V x 3, m: vertices at rest (a copy).
        triangles: F x 3 vertex numbers (a copy).
    """

    def __init__(self, session, index, name, force):
        self._session = session
        self._index = index
        self.name = name
        self.force = force

    @property
    def vertices(self):
        return self._session._native.organ(self._index, "vertices")

    @property
    def displacements(self):
        return self._session._native.organ(self._index, "displacements")

    @property
    def control_points(self):
        return self._session._native.organ(self._index, "control_points")

    @property
    def rest(self):
        return self._session._native.organ(self._index, "rest")

    @property
    def triangles(self):
        return self._session._native.organ(self._index, "triangles")

    def set_young(self, young, seed=0):
        """Gives the organ another Young's modulus (Pa) and returns the session to its start.

        Builds the organ again, which takes as long as at the start. Regions keep theirs. The result
        equals a new session of a scene with this value bit for bit.
        """
        self._session._native.set_young(self._index, float(young), seed_of(seed))

    def __repr__(self):
        return f"<hpdm organ {self.name!r}>"


class Closing:
    """Frees what it holds at close() and at the end of `with`."""

    def close(self):
        """Frees it. Later calls raise RuntimeError; arrays keep what they show."""
        self._native.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


class Session(Closing):
    """A session in virtual time, step by step, with the same bits in every run.

    Args:
        scene: a Scene or a path.
        device: what moves the instruments: "command" (this program), "sim" (the scene's simulated
            hand), "trace:FILE" (a recorded motion), or "NAME=..." for one instrument; or a list.
        seed: of the simulated hands; 0: the scene's own.
        command: how commands are given. "axes": pitch, yaw (rad), insertion (m), roll (rad), jaw
            (0 closed .. 1 open). "tip": x, y, z of the tip (m), roll (rad), jaw.

    Attributes, by instrument in the scene's order (I instruments). All are live views of the last
    tick and read only but for `command`; world axes:
        command: dict by name of arrays (5): where the next step moves the instrument. It goes there
            at constant speed in the time of the step. Joints beyond the workspace are clamped.
        commands: the same as one array, I x 5.
        force: I x 3, N: on the hand. mean_force: I x 3, N, and peak_force: I, N: over the step.
        tip: I x 3, m. velocity: I x 3, m/s. rotation: I x 4, quaternion x, y, z, w of the tool.
        joints: I x 5, the device's axes. jaw: I, 0..1.
        contact_organ: I, index in `scene.organs`, or -1. contact_kind: I, 0 none, 1 press, 2 grasp.
        depth: I, m: of a press. slip: I, m: of held tissue through the jaws.
        organ_force: O x 3, N: of all instruments on each organ.
        organs: dict by name of Organ.

    It publishes nothing and writes no file unless record() asks for it. One thread at a time: another one gets RuntimeError.
    """

    _TOOL_ARRAYS = ("force", "mean_force", "peak_force", "tip", "velocity", "rotation", "joints",
                    "jaw", "contact_organ", "contact_kind", "depth", "slip")

    def __init__(self, scene, device="command", seed=0, command="axes"):
        scene = as_scene(scene)
        native = _native.Session(scene._model(), devices_of(device), seed_of(seed), command)
        self._take(scene, native)

    def _take(self, scene, native):
        self.scene = scene
        self._native = native
        #: Computes one deformation step and the haptic ticks of its period. Without Python's lock.
        self.step = native.step
        self.commands = native.commands()
        self.command = _Commands(scene.instruments, self.commands)
        for name in self._TOOL_ARRAYS:
            setattr(self, name, native.tool(name))
        self.organ_force = native.organ_forces()
        self.organs = _Names("organ", {
            name: Organ(self, i, name, self.organ_force[i])
            for i, name in enumerate(scene.organs)})

    @property
    def time(self):
        """Virtual time since the start, s."""
        return self._native.time()

    @property
    def steps(self):
        """Number of steps since the start."""
        return self._native.steps()

    @property
    def flags(self):
        """Faults of the last step, or-ed (StepFlag in engine/snapshots.h); 0: none."""
        return self._native.flags()

    @property
    def tick_forces(self):
        """Force on each hand in each tick of the last step, N: ticks x I x 3 (a copy)."""
        return self._native.tick_forces()

    @property
    def attachments(self):
        """The scene's attachments after the last step, a list of dicts in its order (copies):

        "a", "b": the organs' names; "load": 3, N, force of the layer on b; "damage": M, 0 whole .. 1
        torn, of its samples, "area": M, m^2, and "points": M x 3, m, their places between the organs; "freed_area": m^2, and of it
        "burnt_area" and "cut_area"; "dissipated": J.
        """
        return self._native.attachments()

    @property
    def exercise(self):
        """The judgement of the scene's exercise after the last step, a dict (copies); or None:

        "step": number of steps done of "steps"; "progress": of the present one, 0..1; "step_times":
        s; "errors": list of dicts with "name", "points", "time" (s), "step", "hand", "organ" and "duct"
        (index or -1), "place" (3, m) and "force" (N); "time": s; "score": 0..100; "ended"; "passed".
        """
        return self._native.exercise()

    def events(self):
        """Returns the events since the last call: (time in s, severity, name, text)."""
        return self._native.events()

    def reset(self, seed=0):
        """Returns to the start, as a new session with this seed does, bit for bit."""
        self._native.reset(seed_of(seed))

    def save(self):
        """Returns the state. A session that loads it continues from it bit for bit."""
        return self._native.save()

    def load(self, state):
        """Continues from a state of save(), of this or another session of the scene."""
        self._native.load(state)

    def clone(self):
        """Returns a session in the same state, with arrays of its own."""
        copy = Session.__new__(Session)
        copy._take(self.scene, _native.Session(self._native.save()))
        return copy

    def record(self, folder, live=False):
        """Records the session in a new folder from its start on, as `hpdm run` does.

        `hpdm log`, `hpdm replay`, `hpdm report` and Log read the folder. `live` publishes every
        message over LCM too. Call it before the first step or after reset(); end_record(), reset(),
        load(), set_young() and close() end the record. Raises InputError if the folder cannot be
        written or if set_young() was used, and MachineError without a network.
        """
        self._native.record(os.fspath(folder), bool(live))

    def end_record(self):
        """Completes the record. Raises MachineError if something is missing in it."""
        self._native.end_record()

    def exchange(self, instrument, held):
        """Gives a hand its instrument number `held` (0: the first) once its tip is free."""
        self._native.exchange(_index(self.scene.instruments, instrument, "instrument"), int(held))

    def press(self, instrument, pressed=True):
        """Presses or releases the pedal of a hand from the next step on: an energised hook burns."""
        self._native.press(_index(self.scene.instruments, instrument, "instrument"), bool(pressed))

    def render(self, width=640, height=480, depth=False, organs=False):
        """Draws the last step through the scene's laparoscope.

        Returns the picture, height x width x 3, uint8. With `depth` or `organs` returns a dict of
        arrays: "rgb"; "depth", float32, m along the viewing axis, infinite where nothing is drawn;
        "organs", int32, the index of each pixel's organ or -1. Depth and organs are those of the
        undistorted picture. Raises MachineError without OpenGL.
        """
        arrays = self._native.render(int(width), int(height), bool(depth), bool(organs))
        return arrays if depth or organs else arrays["rgb"]

    def camera(self, width=640, height=480):
        """Returns the camera of render(), a dict:

        "pose": 4 x 4, from the camera (x to the right, y down, z along the view) to the world, m;
        "intrinsics": 3 x 3, px; "circle_radius": of the picture, px; "distortion": k of the lens
        (scenes/README.md).
        """
        return self.scene._model().camera(int(width), int(height))

    def __repr__(self):
        return f"<hpdm.Session of {self.scene.name!r}>"


class _Commands(_Names):
    """Views of the commands by instrument; assignment writes into them."""

    def __init__(self, names, array):
        super().__init__("instrument", {name: array[..., i, :] for i, name in enumerate(names)})

    def __setitem__(self, name, value):
        np.copyto(self[name], np.asarray(value, dtype=float), casting="same_kind")


def _index(names, name, kind):
    """Returns the place of a name; KeyError lists the names."""
    if name not in names:
        raise KeyError(f"there is no {kind} {name!r}; the scene has {', '.join(names) or 'none'}")
    return names.index(name)
