"""Types of the learning tasks. Shapes and units are in the docstrings of the modules."""

from collections.abc import Iterable, Mapping
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from .. import Batch, Scene, Session

_Observation = NDArray[Any] | dict[str, NDArray[Any]]
_Kind = Literal["state", "rgb", "rgbd"]

class Box:
    low: NDArray[Any]
    high: NDArray[Any]
    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    def __init__(self, low: ArrayLike, high: ArrayLike, shape: Iterable[int],
                 dtype: DTypeLike = ..., seed: int | None = None) -> None: ...
    def seed(self, seed: int | None = None) -> None: ...
    def sample(self) -> NDArray[Any]: ...
    def contains(self, value: object) -> bool: ...
    def __contains__(self, value: object) -> bool: ...

class Dict:
    spaces: dict[str, Box]
    def __init__(self, spaces: Mapping[str, Box]) -> None: ...
    def seed(self, seed: int | None = None) -> None: ...
    def sample(self) -> dict[str, NDArray[Any]]: ...
    def contains(self, value: object) -> bool: ...
    def __contains__(self, value: object) -> bool: ...
    def __getitem__(self, name: str) -> Box: ...

class Task:
    SCENE: ClassVar[str]
    ACTIONS: ClassVar[int]
    organ: ClassVar[str]
    hands: ClassVar[tuple[str, ...]]
    limit: ClassVar[int]
    weights: dict[str, float]
    goal: NDArray[np.float64]
    steps: int
    @classmethod
    def make_scene(cls) -> Scene: ...
    def begin_episode(self, rng: np.random.Generator,
                      options: Mapping[str, Any]) -> dict[str, Any]: ...
    def act_more(self, instrument: int, values: NDArray[np.float64]) -> None: ...
    def extra_state(self) -> ArrayLike: ...
    def judge(self) -> tuple[dict[str, float], bool]: ...
    def tip(self, hand: int = 0) -> NDArray[np.float64]: ...
    def distance(self, hand: int = 0) -> float: ...
    def grasps(self, hand: int, organ: str) -> bool: ...

_Place = tuple[float, float, float]  # m

class Reach(Task):
    RADIUS: ClassVar[float]  # m

class PalpateNodule(Task):
    NODULE: ClassVar[_Place]
    RADIUS: ClassVar[float]  # m
    YOUNG: ClassVar[float]  # Pa

class TissueRetraction(Task):
    GRASP: ClassVar[_Place]
    LIFT: ClassVar[float]  # m

class GraspLiftTouch(Task):
    FUNDUS: ClassVar[_Place]
    LIFT: ClassVar[float]  # m
    TARGET: ClassVar[_Place]
    PHASES: ClassVar[tuple[str, ...]]

class TwoHandManipulation(Task):
    MARKS: ClassVar[tuple[_Place, _Place]]
    RADIUS: ClassVar[float]  # m

class Exercise(Task): ...

class BedDissection(Exercise): ...

class ClipAndCut(Exercise):
    MARKS: ClassVar[tuple[float, float, float]]  # m
    TURN: ClassVar[float]  # rad
    AWAY: ClassVar[float]  # m

class PegTransfer(Exercise): ...

TASKS: dict[str, type[Task]]

class Env:
    metadata: ClassVar[dict[str, Any]]
    render_mode: str | None
    observation: _Kind
    size: tuple[int, int]
    session: Session
    task: Task
    action_space: Box
    observation_space: Box | Dict
    def __init__(self, task: type[Task], observation: _Kind = "state",
                 size: tuple[int, int] = (64, 64), render_mode: Literal["rgb_array"] | None = None,
                 weights: Mapping[str, float] | None = None) -> None: ...
    def reset(self, *, seed: int | None = None,
              options: Mapping[str, Any] | None = None) -> tuple[_Observation, dict[str, Any]]: ...
    def step(self, action: ArrayLike
             ) -> tuple[_Observation, float, bool, bool, dict[str, Any]]: ...
    def render(self) -> NDArray[np.uint8] | None: ...
    def close(self) -> None: ...
    @property
    def unwrapped(self) -> Env: ...

class VectorEnv:
    render_mode: str | None
    num_envs: int
    observation: _Kind
    size: tuple[int, int]
    batch: Batch
    tasks: list[Task]
    single_action_space: Box
    single_observation_space: Box | Dict
    action_space: Box
    observation_space: Box | Dict
    def __init__(self, task: type[Task], count: int, threads: int | None = None,
                 observation: _Kind = "state", size: tuple[int, int] = (64, 64),
                 render_mode: Literal["rgb_array"] | None = None,
                 weights: Mapping[str, float] | None = None) -> None: ...
    def reset(self, *, seed: int | Iterable[int] | None = None,
              options: Mapping[str, Any] | None = None) -> tuple[_Observation, dict[str, Any]]: ...
    def step(self, actions: ArrayLike
             ) -> tuple[_Observation, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_],
                        dict[str, Any]]: ...
    def render(self) -> list[NDArray[np.uint8]] | None: ...
    def close(self) -> None: ...

def make(task: str, **options: Any) -> Env: ...
