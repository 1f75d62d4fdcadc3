"""A scripted surgeon frees the gallbladder from its bed (scenes/bed_dissection.toml), to the end.

Usage: dissect_bed.py [--quick] [--out FOLDER]

It takes the fundus, lifts it off the liver, burns the layer sample by sample from the fundus to the neck,
lays the gallbladder down and lets go. It sees what a program can see: the places of the layer's samples.
--quick: a hook of 400 W and a third of the bed. --out: records the session, for `hpdm report`.
"""

import argparse

import numpy as np

import hpdm

FUNDUS = np.array([0.008, -0.110, 0.032])  # m, near the surface
GRASP_SPEED, HOOK_SPEED = 0.03, 0.04       # m/s
STEP = 1 / 30                              # s


class Surgeon:
    """Moves grasper and hook of a session; every method runs the session's steps."""

    def __init__(self, session):
        self.session = session
        self.names = session.scene.instruments
        self.targets = {name: session.command[name].copy() for name in self.names}
        organ = session.organs["gallbladder"]
        nearest = np.argmin(np.linalg.norm(organ.rest - FUNDUS, axis=1))
        self.fundus = organ.rest[nearest]
        self.away = self.direction_off_the_liver()

    def direction_off_the_liver(self):
        """Returns the unit vector from the bed to the gallbladder's middle."""
        bed = self.session.attachments[0]
        middle = self.session.organs["gallbladder"].rest.mean(axis=0)
        away = middle - np.average(bed["points"], axis=0, weights=bed["area"])
        return away / np.linalg.norm(away)

    def step(self, count=1):
        for _ in range(count):
            for name in self.names:
                self.session.command[name][:] = self.targets[name]
            self.session.step()

    def over(self):
        return self.session.exercise["ended"]

    def move(self, name, to, speed, jaw=None):
        """Moves a tip in a straight line and there."""
        target = self.targets[name]
        if jaw is not None:
            target[4] = jaw
        way = np.asarray(to) - target[:3]
        count = max(1, int(np.ceil(np.linalg.norm(way) / (speed * STEP))))
        start = target[:3].copy()
        for i in range(1, count + 1):
            target[:3] = start + way * i / count
            self.step()

    def close(self, name, jaw):
        """Closes or opens jaws in a third of a second."""
        start = self.targets[name][4]
        for i in range(1, 11):
            self.targets[name][4] = start + (jaw - start) * i / 10
            self.step()

    def take_fundus(self):
        outward = self.fundus - self.session.organs["gallbladder"].rest.mean(axis=0)
        outward /= np.linalg.norm(outward)
        self.move("grasper", self.fundus + 0.03 * outward, 0.1, jaw=1)
        self.move("grasper", self.fundus + 0.0015 * outward, GRASP_SPEED)
        self.close("grasper", 0)
        self.step(20)

    def lift(self, length):
        """Moves the grasper away from the liver."""
        self.move("grasper", self.targets["grasper"][:3] + length * self.away, GRASP_SPEED)

    def burn(self, part):
        """Burns the layer from the fundus to the neck until that share of its area is freed."""
        session = self.session
        total = session.attachments[0]["area"].sum()
        while not self.over():
            bed = session.attachments[0]
            if bed["freed_area"] >= part * total:
                break
            left = np.flatnonzero(bed["damage"] < 1)
            along = bed["points"][left] @ np.array([0, 1, 0])
            place = bed["points"][left[np.argmin(along)]]
            self.move("hook", place, HOOK_SPEED)
            session.press("hook", True)
            self.step()
            session.press("hook", False)

    def run(self, part=0.93):
        self.take_fundus()
        self.lift(0.012)
        self.step(20)
        self.burn(part)
        self.move("hook", self.targets["hook"][:3] + [0.02, -0.03, 0.02], HOOK_SPEED)
        self.lift(-0.012)
        self.close("grasper", 1)
        self.step(30)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--out")
    options = parser.parse_args()
    scene = hpdm.Scene(hpdm.scene_path("bed_dissection.toml"))
    session = hpdm.Session(scene, command="tip")
    if options.out:
        session.record(options.out)
    surgeon = Surgeon(session)
    surgeon.run()
    if options.out:
        session.end_record()
    print(session.exercise)


if __name__ == "__main__":
    main()
