"""HPDM from Python: sessions of laparoscopic surgery with soft organs that are felt.

    import hpdm
    session = hpdm.Session(hpdm.scene_path("liver_palpation.toml"))
    session.command["probe"][2] += 0.02    # m, further in
    session.step()                         # 1/30 s of virtual time
    print(session.force)                   # N

The tutorial is tools/python/README.md. Units are SI.
"""

from .batch import Batch
from .errors import InputError, MachineError
from .files import Driver, Log, plan, solve
from .scene import Scene, scene_path
from .session import Organ, Session, State

__version__ = "0.2.0"
__all__ = ["Batch", "Driver", "InputError", "Log", "MachineError", "Organ", "Scene", "Session",
           "State", "plan", "scene_path", "solve"]
