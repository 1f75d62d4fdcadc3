"""Learning tasks on HPDM's sessions, with the calls of gymnasium.

gymnasium is not in Debian 12, so the tasks stand on small classes of their own with the same calls:
`reset(seed=, options=)` returns (observation, info), `step(action)` returns (observation, reward,
terminated, truncated, info). The tests check this contract; gymnasium's own checker was not run.

    env = hpdm.gym.make("Reach", observation="state")
    observation, info = env.reset(seed=1)
    observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
"""

from .env import Env
from .exercises import BedDissection, ClipAndCut, Exercise, PegTransfer
from .spaces import Box, Dict
from .task import Task
from .tasks import (TASKS, GraspLiftTouch, PalpateNodule, Reach, TissueRetraction,
                    TwoHandManipulation)
from .vector import VectorEnv


def make(task, **options):
    """Returns the environment of a task by name: a key of TASKS. `options`: those of Env."""
    if task not in TASKS:
        raise KeyError(f"there is no task {task!r}; give one of {', '.join(TASKS)}")
    return Env(TASKS[task], **options)


__all__ = ["BedDissection", "Box", "ClipAndCut", "Dict", "Env", "Exercise", "GraspLiftTouch",
           "PalpateNodule", "PegTransfer", "Reach", "TASKS", "Task", "TissueRetraction",
           "TwoHandManipulation", "VectorEnv", "make"]
