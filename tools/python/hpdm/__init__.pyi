"""Types of the package. Shapes and units are in the docstrings of the modules."""

import os
from collections.abc import Iterable, Sequence
from typing import Any, Literal, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import gym as gym

Reals = NDArray[np.float64]
Whole = NDArray[np.int32]
Picture = NDArray[np.uint8]
Path = str | os.PathLike[str]
Command = Literal["axes", "tip"]

__version__: str

class InputError(ValueError):
    file: str | None
    line: int | None
    column: int | None
    key: str | None

class MachineError(RuntimeError): ...

class State:
    time: float

class Scene:
    path: str
    text: str
    name: str
    organs: list[str]
    instruments: list[str]
    remarks: list[str]
    def __init__(self, path: Path) -> None: ...
    @classmethod
    def parse(cls, text: str, path: Path) -> Scene: ...
    def __setitem__(self, key: str, value: bool | int | float | str | Sequence[Any]) -> None: ...
    def __getitem__(self, key: str) -> Any: ...
    def write(self, path: Path) -> None: ...

class Organ:
    name: str
    force: Reals
    vertices: Reals
    displacements: Reals
    control_points: Reals
    rest: Reals
    triangles: Whole
    def set_young(self, young: float, seed: int = 0) -> None: ...

class _Shown:
    scene: Scene
    commands: Reals
    force: Reals
    mean_force: Reals
    peak_force: Reals
    tip: Reals
    velocity: Reals
    rotation: Reals
    joints: Reals
    jaw: Reals
    contact_organ: Whole
    contact_kind: Whole
    depth: Reals
    slip: Reals
    organ_force: Reals
    def step(self) -> None: ...
    def close(self) -> None: ...

class _Commands(dict[str, Reals]):
    def __setitem__(self, name: str, value: ArrayLike) -> None: ...

class Session(_Shown):
    command: _Commands
    organs: dict[str, Organ]
    time: float
    steps: int
    flags: int
    tick_forces: Reals
    def __init__(self, scene: Scene | Path, device: str | Iterable[str] = "command", seed: int = 0,
                 command: Command = "axes") -> None: ...
    def reset(self, seed: int | None = 0) -> None: ...
    def save(self) -> State: ...
    def load(self, state: State) -> None: ...
    def clone(self) -> Session: ...
    def events(self) -> list[tuple[float, str, str, str]]: ...
    def exchange(self, instrument: str, held: int) -> None: ...
    @overload
    def render(self, width: int = 640, height: int = 480) -> Picture: ...
    @overload
    def render(self, width: int = 640, height: int = 480, depth: bool = False,
               organs: bool = False) -> dict[str, NDArray[Any]] | Picture: ...
    def camera(self, width: int = 640, height: int = 480) -> dict[str, Any]: ...
    def __enter__(self) -> Session: ...
    def __exit__(self, *_: object) -> None: ...

class Batch(_Shown):
    command: _Commands
    count: int
    threads: int
    def __init__(self, scene: Scene | Path, count: int, threads: int | None = None,
                 device: str | Iterable[str] = "command", command: Command = "axes",
                 seeds: Iterable[int] | None = None) -> None: ...
    def __len__(self) -> int: ...
    def reset(self, seeds: Iterable[int] | None = None,
              which: Iterable[int] | None = None) -> None: ...
    def save(self, index: int) -> State: ...
    def load(self, index: int, state: State) -> None: ...
    def vertices(self, index: int, organ: str) -> Reals: ...
    def time(self, index: int) -> float: ...
    def render(self, index: int, width: int = 640, height: int = 480, depth: bool = False,
               organs: bool = False) -> dict[str, NDArray[Any]] | Picture: ...
    def __enter__(self) -> Batch: ...
    def __exit__(self, *_: object) -> None: ...

class Log(dict[str, dict[str, Any]]):
    path: str
    def __init__(self, path: Path) -> None: ...

class Driver:
    def __init__(self, instrument: int = 0) -> None: ...
    def publish(self, joints: Sequence[float]) -> None: ...
    def effort(self) -> tuple[float, float, float]: ...

def scene_path(name: str) -> str: ...
def solve(scene: Scene | Path) -> dict[str, Any]: ...
def plan(scene: Scene | Path, error: float, budget_ms: float, seconds: float = 0.0,
         out: Path = "") -> dict[str, Any]: ...
