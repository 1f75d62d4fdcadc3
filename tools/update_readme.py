#!/usr/bin/python3
"""Measures what README.md shows, and replaces the tables and the pictures.

Usage, from the repository's root after a build, on a machine that does nothing else:

    tools/update_readme.py [--quick] [--keep] [chart] [bench] [stress] [plan]

Runs `hpdm NAME --out out/NAME` for each of the names (none: all; `plan` on a scene) and puts NAME.md between the lines
`<!-- NAME begin -->` and `<!-- NAME end -->` of README.md, NAME.png, if there is one, into
scenes/pictures. --keep takes the measurements that are there already.
"""

import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
OUT = ROOT / "out"
NAMES = ("chart", "bench", "stress", "plan")
PLANNED = ("scenes/liver_palpation.toml", "--error", "0.08", "--budget-ms", "1")


def replaced(text, name, table):
    begin, end = f"<!-- {name} begin -->", f"<!-- {name} end -->"
    if text.count(begin) != 1 or text.count(end) != 1 or text.index(begin) > text.index(end):
        raise SystemExit(f"README.md: needs one line '{begin}' and after it one '{end}'")
    head, _, rest = text.partition(begin)
    _, _, tail = rest.partition(end)
    return f"{head}{begin}\n{table}{end}{tail}"


def command(name, quick):
    if name == "bench":  # README tells in words of what is left out
        only = ["models", "meshes", "sleep", "costs"]
        return [name, "--out", OUT / name, "--only", *only, *quick]
    if name == "plan":
        return ["plan", *PLANNED, "--out", OUT / "plan/scene.toml", "--chart", OUT / "plan"]
    return [name, "--out", OUT / name, *quick]


def main(arguments):
    options = {each for each in arguments if each.startswith("-")}
    names = [each for each in arguments if each not in options] or NAMES
    unknown = (options - {"--quick", "--keep"}) | (set(names) - set(NAMES))
    if unknown:
        raise SystemExit(f"update_readme.py: {unknown.pop()} is no option and no name\n{__doc__}")
    quick = ["--quick"] if "--quick" in options else []
    if "--keep" not in options:
        for name in names:
            program = ROOT / "build/tools/hpdm"
            subprocess.run([program, *command(name, quick)], cwd=ROOT, check=True)
    readme = ROOT / "README.md"
    text = readme.read_text(encoding="utf-8")
    for name in names:
        text = replaced(text, name, (OUT / name / f"{name}.md").read_text(encoding="utf-8"))
        picture = OUT / name / f"{name}.png"
        if picture.exists():
            shutil.copy(picture, ROOT / "scenes/pictures")
    readme.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
