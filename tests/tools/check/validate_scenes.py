"""Checks scene files by a JSON Schema, with python3-jsonschema.

    validate_scenes.py SCHEMA SCENE...

Prints one line for each scene, "NAME: accepted" or "NAME: refused at PLACE: FAULT". Exits with 2 if
the schema itself is wrong.
"""

import json
import pathlib
import sys
import tomllib

import jsonschema


def main():
    schema = json.loads(pathlib.Path(sys.argv[1]).read_text())
    try:
        jsonschema.Draft7Validator.check_schema(schema)
    except jsonschema.SchemaError as fault:
        print(fault.message, file=sys.stderr)
        return 2
    validator = jsonschema.Draft7Validator(schema)
    for path in map(pathlib.Path, sys.argv[2:]):
        faults = list(validator.iter_errors(tomllib.loads(path.read_text())))
        verdict = "accepted"
        if faults:
            place = ".".join(str(step) for step in faults[0].absolute_path) or "scene"
            verdict = f"refused at {place}: {faults[0].message}"
        print(f"{path.name}: {verdict}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
