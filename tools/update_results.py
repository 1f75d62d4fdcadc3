#!/usr/bin/python3
"""Measures the results in the RESULTS.md files and replaces their tables and pictures.

Usage, from the repository's root after a build, on an otherwise idle machine:

    tools/update_results.py [--quick] [--keep] [chart] [cracks] [bench] [stress] [plan] [haptics]
    tools/update_results.py chart --only=uniform,local,adaptive,finite,surface
    tools/update_results.py comparison
    tools/update_results.py haptics:organs,shaft stress:organs

Runs `hpdm NAME --out out/NAME` for each name (default: all; `plan` on a scene). Puts NAME.md
between the lines `<!-- NAME begin -->` and `<!-- NAME end -->` of tools/NAME/RESULTS.md, and
NAME.png, if the command made one, into scenes/pictures. `haptics`, `stress` and `bench` have further
tables, each between lines of its own (TABLES). NAME:TABLE,TABLE measures and replaces only these.
`comparison` runs build/tools/yardstick/hpdm_comparison, which needs CGAL, and only when it is named.
--keep uses the measurements of an earlier run. --only passes groups of models to `hpdm chart`.
"""

import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
OUT = ROOT / "out"
NAMES = ("chart", "cracks", "bench", "stress", "plan", "haptics")
# What hpdm_comparison compares (tests/reference/README.md).
COMPARED = ("liver_press", "liver_lift", "liver_lift_40mm")
HANDS = ["press", "slide", "tap", "grasp_pull", "press_grasp_pull", "slide_press", "slide_friction",
         "slide_press_friction"]
# The tables of a command by the name of their lines: the parts to measure (--only; none: all) and the
# file without ".md". Other commands have one table of their name.
TABLES = {
    "bench": {"bench": (["models", "meshes", "sleep", "costs"], "bench"),
              "organs": (["organs"], "organs")},
    "haptics": {"haptics": (["contacts"], "contacts"), "organs": (["organs"], "organs"),
                "shaft": (["shaft"], "shaft"), "tissue": (["tissue"], "tissue"),
                "force_accuracy": (HANDS, "force_accuracy"), "z_width": (["z-width"], "z_width"),
                "transparency": (["transparency"], "transparency")},
    "stress": {"stress": (["material", "contact", "motion", "haptics", "touch"], "stress"),
               "organs": (["organs"], "organs"), "parts": (["parts"], "parts")},
}
PLANNED = ("scenes/liver_palpation.toml", "--error", "0.08", "--budget-ms", "1")


def replaced(text, path, name, table):
    begin, end = f"<!-- {name} begin -->", f"<!-- {name} end -->"
    if text.count(begin) != 1 or text.count(end) != 1 or text.index(begin) > text.index(end):
        raise SystemExit(f"{path}: needs exactly one line '{begin}', followed by one '{end}'")
    head, _, rest = text.partition(begin)
    _, _, tail = rest.partition(end)
    return f"{head}{begin}\n{table}{end}{tail}"


def command(name, tables, quick, groups):
    if name == "plan":
        return ["plan", *PLANNED, "--out", OUT / "plan/scene.toml", "--chart", OUT / "plan"]
    if name == "cracks":
        return ["chart", "--cracks", "--out", OUT / name, *quick]
    if name == "comparison":
        cases = [f"scenes/cases/{case}.toml" for case in COMPARED]
        return [*cases, "--out", OUT / name, *quick]
    if name == "chart":
        return [name, "--out", OUT / name, *groups, *quick]
    parts = [only for only, _ in tables.values()]
    only = ["--only", *sum(parts, [])] if all(parts) else []
    return [name, "--out", OUT / name, *only, *quick]


def chosen(argument):
    """The command's name and its tables to replace."""
    name, _, wanted = argument.partition(":")
    if name not in (*NAMES, "comparison"):
        raise SystemExit(f"update_results.py: unknown name {name}\n{__doc__}")
    tables = TABLES.get(name, {name: ([], name)})
    if not wanted:
        return name, tables
    unknown = set(wanted.split(",")) - set(tables)
    if unknown:
        raise SystemExit(f"update_results.py: {name} has no table {unknown.pop()}\n{__doc__}")
    return name, {lines: tables[lines] for lines in wanted.split(",")}


def main(arguments):
    options = {each for each in arguments if each.startswith("-")}
    groups = [each for each in options if each.startswith("--only=")]
    unknown = options - {"--quick", "--keep", *groups}
    if unknown:
        raise SystemExit(f"update_results.py: unknown option {unknown.pop()}\n{__doc__}")
    quick = ["--quick"] if "--quick" in options else []
    for argument in [each for each in arguments if each not in options] or NAMES:
        name, tables = chosen(argument)
        if "--keep" not in options:
            program = "yardstick/hpdm_comparison" if name == "comparison" else "hpdm"
            subprocess.run([ROOT / "build/tools" / program, *command(name, tables, quick, groups)], cwd=ROOT, check=True)
        folder = "chart" if name in ("cracks", "comparison") else name
        path = ROOT / "tools" / folder / "RESULTS.md"
        text = path.read_text(encoding="utf-8")
        for lines, (_, table) in tables.items():
            table_text = (OUT / name / f"{table}.md").read_text(encoding="utf-8")
            text = replaced(text, path, lines, table_text)
        path.write_text(text, encoding="utf-8")
        for picture in tables:
            if (OUT / name / f"{picture}.png").exists():
                shutil.copy(OUT / name / f"{picture}.png", ROOT / "scenes/pictures")


if __name__ == "__main__":
    main(sys.argv[1:])
