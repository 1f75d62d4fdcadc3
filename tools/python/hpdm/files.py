"""Logs, static solutions, plans and drivers."""

import os

from . import _native
from .scene import Scene, as_scene


class Log(dict):
    """A session's log: a dict by channel of dicts by value of columns, one row for each message.

        log = hpdm.Log("out/demo")              # a session's folder or its session.lcmlog
        log["HPDM_FORCE"]["tools[0].force[2]"]  # numpy array

    Whole numbers are int64, others float64 with NaN where a message lacks the value; texts are
    lists. "log_time_us" is the log's time stamp, us.

    Raises:
        InputError: if it cannot be read. Damaged stretches and unreadable messages are left out.
    """

    def __init__(self, path):
        path = os.fspath(path)
        if os.path.isdir(path):
            path = os.path.join(path, "session.lcmlog")
        super().__init__(_native.read_log(path))
        self.path = path


def solve(scene):
    """Solves a scene's static loads, as `hpdm solve`.

    Returns a dict: "organ"; "vertices" and "displacements", V x 3, m; "load_forces" (N) and
    "load_displacements" (m), one row for each load; "compliance" of the first load, m/N;
    "residual"; "share" of the loads that was reached, 1 but for laws that stop carrying.
    """
    return _native.solve(as_scene(scene)._native)


def plan(scene, error, budget_ms, seconds=0.0, out=""):
    """Finds the cheapest models that meet an error and a time, as `hpdm plan`.

    Args:
        error: relative L2 error of the surface's motion, such as 0.08.
        budget_ms: of a deformation step on this machine, ms.
        seconds: limit of the search; 0: none.
        out: where the new scene will be written; relative names are made for its folder.

    Returns a dict: "meets_both"; "of_error" and "of_budget", each with "error" and "step_ms", or
    empty; "remarks"; and "scene", a Scene, if both are met.
    """
    result = _native.plan(as_scene(scene)._native, float(error), float(budget_ms),
                          float(seconds), os.fspath(out))
    if "scene" in result:
        result["scene"] = Scene._of(result["scene"])
    return result


class Driver:
    """A device for a session that runs elsewhere with `hpdm run SCENE --device lcm`.

    Publishes readings and takes the answers over LCM (LCM_DEFAULT_URL), without LCM's Python.
    The contract is in haptics/device/README.md: publish at about 1 kHz; a device that is silent for
    50 ms loses its force.

    Args:
        instrument: number of the instrument in the scene.

    Raises:
        MachineError: if the network cannot be opened.
    """

    def __init__(self, instrument=0):
        self._native = _native.Driver(int(instrument))

    def publish(self, joints, pedal=False):
        """Sends pitch, yaw (rad), insertion (m), roll (rad) and jaw (0..1), read now.

        `pedal`: the device's button is pressed.
        """
        self._native.publish([float(value) for value in joints], bool(pedal))

    def effort(self):
        """Returns the newest effort: pitch, yaw (N m), insertion (N). Zero after 50 ms of silence."""
        return self._native.effort()
