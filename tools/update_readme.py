#!/usr/bin/python3
"""Measures what README.md shows of speed and accuracy, and replaces the tables and the picture.

Usage, from the repository's root after a build, on a machine that does nothing else:

    tools/update_readme.py [--quick] [--keep]

Runs `hpdm chart` and `hpdm bench` into out/ and puts chart.md and bench.md between the lines
`<!-- NAME begin -->` and `<!-- NAME end -->` of README.md, chart.png into scenes/pictures. --keep
takes the measurements that are there already.
"""

import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
OUT = ROOT / "out"


def replaced(text, name, table):
    begin, end = f"<!-- {name} begin -->", f"<!-- {name} end -->"
    if text.count(begin) != 1 or text.count(end) != 1 or text.index(begin) > text.index(end):
        raise SystemExit(f"README.md: needs one line '{begin}' and after it one '{end}'")
    head, _, rest = text.partition(begin)
    _, _, tail = rest.partition(end)
    return f"{head}{begin}\n{table}{end}{tail}"


def main(arguments):
    unknown = set(arguments) - {"--quick", "--keep"}
    if unknown:
        raise SystemExit(f"update_readme.py: {unknown.pop()} is not an option\n{__doc__}")
    quick = ["--quick"] if "--quick" in arguments else []
    if "--keep" not in arguments:
        for command in ("chart", "bench"):
            program = [ROOT / "build/tools/hpdm", command, "--out", OUT / command, *quick]
            subprocess.run(program, cwd=ROOT, check=True)
    readme = ROOT / "README.md"
    text = readme.read_text(encoding="utf-8")
    for name in ("chart", "bench"):
        table = (OUT / name / f"{name}.md").read_text(encoding="utf-8")
        text = replaced(text, name, table)
    readme.write_text(text, encoding="utf-8")
    shutil.copy(OUT / "chart/chart.png", ROOT / "scenes/pictures/chart.png")


if __name__ == "__main__":
    main(sys.argv[1:])
