"""The exceptions of this package."""

import re

_PLACE = re.compile(r"^(?P<file>.*?):(?P<line>\d+):(?P<column>\d+): (?P<key>[^:]+): ")


class InputError(ValueError):
    """A scene, mesh, trace or log has a fault. One line: file, place, fault, remedy.

    Attributes:
        file: path of the faulty file, or None if the message names no place.
        line, column: place in it, counted from 1, or None.
        key: the scene's key, such as "organ[0].material.young", or None.
    """

    def __init__(self, message):
        super().__init__(message)
        place = _PLACE.match(message)
        self.file = place["file"] if place else None
        self.line = int(place["line"]) if place else None
        self.column = int(place["column"]) if place else None
        self.key = place["key"] if place else None


class MachineError(RuntimeError):
    """The machine lacks something that was asked for, such as OpenGL. One line with the remedy."""
