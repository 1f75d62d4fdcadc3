"""Tasks that a scene's own [exercise] judges (scenes/README.md)."""

import numpy as np

from .task import GENERAL, Task


def along_curve(path, arc):
    """Returns the point and the unit tangent at an arc length of a duct's axis at rest.

    The axis is Catmull and Rom's centripetal curve through the points of `path` (m), as in
    engine/duct/duct_model.cc.
    """
    points = np.asarray(path, dtype=float)
    points = np.vstack([2 * points[0] - points[1], points, 2 * points[-1] - points[-2]])
    curve = []
    for p in (points[i:i + 4] for i in range(len(points) - 3)):
        t = np.concatenate([[0], np.cumsum(np.sqrt(np.linalg.norm(np.diff(p, axis=0), axis=1)))])
        for u in np.linspace(t[1], t[2], 64, endpoint=False):
            level = list(p)
            for spans in (((0, 1), (1, 2), (2, 3)), ((0, 2), (1, 3)), ((1, 2),)):  # Barry, Goldman
                level = [((t[b] - u) * level[i] + (u - t[a]) * level[i + 1]) / (t[b] - t[a])
                         for i, (a, b) in enumerate(spans)]
            curve.append(level[0])
    curve = np.vstack([curve, points[-2]])
    ways = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
    i = min(int(np.searchsorted(ways, arc, side="right")), len(ways) - 1)
    tangent = (curve[i] - curve[i - 1]) / (ways[i] - ways[i - 1])
    return curve[i - 1] + (arc - ways[i - 1]) * tangent, tangent


class Exercise(Task):
    """A scene's own exercise: its steps, errors and end judge the episode (scenes/README.md).

    An action has a fifth number for each hand: its pedal is pressed above 0. The state has the number
    of steps done and how far the present one is. A subclass names the scene and the hands.
    """

    ACTIONS = 5
    weights = {**GENERAL, "progress": 5.0, "error_points": -0.2}

    def begin_episode(self, rng, options):
        for instrument in self.hands:
            self.slot.press(instrument, False)
        self._last = self.slot.exercise()
        return {}

    def act_more(self, instrument, values):
        self.slot.press(self.scene.instruments[instrument], bool(values[0] > 0))

    def extra_state(self):
        return [float(self._last["step"]), self._last["progress"]]

    def judge(self):
        last, now = self._last, self.slot.exercise()
        self._last = now
        terms = {"progress": (now["step"] + now["progress"]) - (last["step"] + last["progress"]),
                 "error_points": sum(error["points"] for error in now["errors"][len(last["errors"]):])}
        return terms, now["passed"]


class BedDissection(Exercise):
    """Lift the gallbladder off the liver with the grasper and burn the bed with the hook."""

    SCENE = "bed_dissection.toml"
    organ = "gallbladder"
    hands = ("grasper", "hook")
    limit = 9000  # the scene's 300 s


class ClipAndCut(Exercise):
    """Put two clips on the cystic duct and cut it between them, with one hand.

    An action has seven numbers: velocities, jaw, pedal (unused), the jaws' turning speed in units of
    2 rad/s, and the instrument: scissors above 0, else the clip applier. The hand changes its instrument
    where its tip is free, at least 30 mm from the duct. The state also has the tool's rotation, the
    instrument, and place and tangent of three marks on the duct at rest: two for clips, one for the cut.
    """

    SCENE = "clip_and_cut.toml"
    organ = "gallbladder"
    hands = ("clip applier",)
    limit = 5400  # the scene's 180 s
    ACTIONS = 7
    MARKS = (0.024, 0.0175, 0.02075)  # m along the duct from the gallbladder
    TURN = 2 / 30                     # rad a step
    AWAY = 0.030                      # m

    def __init__(self, slot, scene, weights):
        super().__init__(slot, scene, weights)
        path = scene["duct[0].path"]
        self._marks = [along_curve(path, arc) for arc in self.MARKS]

    def begin_episode(self, rng, options):
        self._held = 0
        self.slot.exchange(self.hands[0], 0)
        return super().begin_episode(rng, options)

    def act_more(self, instrument, values):
        super().act_more(instrument, values)
        self.slot.commands[instrument, 3] += self.TURN * values[1]
        held = int(values[2] > 0)
        away = min(np.linalg.norm(self.tip() - place) for place, _ in self._marks)
        if held != self._held and away > self.AWAY:
            self._held = held
            self.slot.exchange(self.hands[0], held)

    def extra_state(self):
        marks = np.concatenate([value for mark in self._marks for value in mark])
        return np.concatenate([super().extra_state(), [float(self._held)],
                               self.slot.rotation[self.index[0]], marks])


class PegTransfer(Exercise):
    """Carry a ring from one peg over to another with a grasper. The state also has the ring's middle."""

    SCENE = "peg_transfer.toml"
    organ = "ring"
    hands = ("grasper",)
    limit = 9000  # the scene's 300 s

    def extra_state(self):
        return np.concatenate([super().extra_state(), self.slot.vertices(self.organ).mean(axis=0)])
