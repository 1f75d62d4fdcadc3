"""Scenes: files, edits by key, and the models that sessions share."""

import json
import math
import os
import tomllib

from . import _native

SCENES = os.path.join(os.path.dirname(__file__), "scenes")


def scene_path(name):
    """Returns the path of a scene that comes with HPDM, such as "liver_palpation.toml"."""
    return os.path.join(SCENES, name)


def _toml(value):
    """Returns a value as TOML text."""
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError(f"a scene has finite numbers only, not {value}")
    if hasattr(value, "tolist"):  # numpy
        value = value.tolist()
    if isinstance(value, (bool, int, float, str, list, tuple)):
        return json.dumps(value, ensure_ascii=False, allow_nan=False)
    raise TypeError(f"a scene's value is a bool, number, string or list, not {type(value).__name__}")


class Scene:
    """A scene file (scenes/README.md).

    Args:
        path: the file; see scene_path() for those that come with HPDM.

    Raises:
        InputError: with file, line and key of the first fault.

    A key is read and set by its path, tables by name or number; a set value is checked at once:

        scene["organ.liver.material.young"] = 3000.0     # Pa
        scene["timing.haptic_hz"]
    """

    def __init__(self, path):
        if not isinstance(path, (str, os.PathLike)):
            raise TypeError(f"Scene takes a path, not {type(path).__name__}")
        self._native = _native.Scene(os.fspath(path))
        self._built = None

    @classmethod
    def parse(cls, text, path):
        """Returns the scene of a text, as if it stood in the file `path` (for relative names)."""
        return cls._of(_native.Scene.parse(text, os.fspath(path)))

    @classmethod
    def _of(cls, native):
        scene = cls.__new__(cls)
        scene._native = native
        scene._built = None
        return scene

    @property
    def path(self):
        """Path as it was given."""
        return self._native.path

    @property
    def text(self):
        """The file's text with all edits."""
        return self._native.text

    @property
    def name(self):
        """The scene's title."""
        return self._native.name

    @property
    def organs(self):
        """Names of the organs, in the file's order."""
        return self._native.organs

    @property
    def instruments(self):
        """Names of the instruments, in the file's order."""
        return self._native.instruments

    def __setitem__(self, key, value):
        self._native = self._native.with_key(key, _toml(value))
        self._built = None

    def __getitem__(self, key):
        """Returns the value as the text has it. KeyError if it leaves the key to its default."""
        node = tomllib.loads(self.text)
        for part in key.replace("[", ".").replace("]", "").split("."):
            if isinstance(node, list):
                named = [e for e in node if isinstance(e, dict) and e.get("name") == part]
                if part.isdigit() and int(part) < len(node):
                    named = [node[int(part)]]
                if not named:
                    raise KeyError(key)
                node = named[0]
            elif isinstance(node, dict) and part in node:
                node = node[part]
            else:
                raise KeyError(key)
        return node

    def write(self, path):
        """Writes the scene to a file; relative names still name the same files from there."""
        text = self._native.moved(os.path.dirname(os.path.abspath(path)))
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)

    def _model(self):
        """The constant model. Built once; all sessions of this scene share it."""
        if self._built is None:
            self._built = _native.Model(self._native)
        return self._built

    @property
    def remarks(self):
        """What `hpdm check` remarks about it: repairs of meshes and probable mistakes."""
        return list(self._model().remarks)

    def __repr__(self):
        return f"<hpdm.Scene {self.name!r}: {', '.join(self.organs)}>"


def as_scene(scene):
    """Returns a Scene from a Scene or a path."""
    return scene if isinstance(scene, Scene) else Scene(scene)
