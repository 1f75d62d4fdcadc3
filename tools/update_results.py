#!/usr/bin/python3
"""Measures the results in the RESULTS.md files and replaces their tables and pictures.

Usage, from the repository's root after a build, on an otherwise idle machine:

    tools/update_results.py [--quick] [--keep] [chart] [bench] [stress] [plan] [haptics]

Runs `hpdm NAME --out out/NAME` for each name (default: all; `plan` on a scene, of `haptics` the
contacts, tissue, z-width and transparency). Puts NAME.md between the lines `<!-- NAME begin -->` and
`<!-- NAME end -->` of tools/NAME/RESULTS.md, and NAME.png, if the command made one, into
scenes/pictures. Of `haptics`, contacts.md comes between those lines, and tissue.md,
z_width.md and transparency.md between lines of their own. --keep uses the measurements of an earlier run.
"""

import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
OUT = ROOT / "out"
NAMES = ("chart", "bench", "stress", "plan", "haptics")
# Tables by the name of their lines, where they are not one table of the command's name.
TABLES = {
    "haptics": {
        "haptics": "contacts",
        "tissue": "tissue",
        "z_width": "z_width",
        "transparency": "transparency",
    }
}
PLANNED = ("scenes/liver_palpation.toml", "--error", "0.08", "--budget-ms", "1")


def replaced(text, path, name, table):
    begin, end = f"<!-- {name} begin -->", f"<!-- {name} end -->"
    if text.count(begin) != 1 or text.count(end) != 1 or text.index(begin) > text.index(end):
        raise SystemExit(f"{path}: needs exactly one line '{begin}', followed by one '{end}'")
    head, _, rest = text.partition(begin)
    _, _, tail = rest.partition(end)
    return f"{head}{begin}\n{table}{end}{tail}"


def command(name, quick):
    if name == "bench":  # RESULTS.md describes the other parts in words
        only = ["models", "meshes", "sleep", "costs"]
        return [name, "--out", OUT / name, "--only", *only, *quick]
    if name == "haptics":  # the other parts' pictures and words are edited by hand
        only = ["contacts", "tissue", "z-width", "transparency"]
        return [name, "--out", OUT / name, "--only", *only, *quick]
    if name == "plan":
        return ["plan", *PLANNED, "--out", OUT / "plan/scene.toml", "--chart", OUT / "plan"]
    return [name, "--out", OUT / name, *quick]


def main(arguments):
    options = {each for each in arguments if each.startswith("-")}
    names = [each for each in arguments if each not in options] or NAMES
    unknown = (options - {"--quick", "--keep"}) | (set(names) - set(NAMES))
    if unknown:
        raise SystemExit(f"update_results.py: unknown option or name {unknown.pop()}\n{__doc__}")
    quick = ["--quick"] if "--quick" in options else []
    for name in names:
        if "--keep" not in options:
            subprocess.run([ROOT / "build/tools/hpdm", *command(name, quick)], cwd=ROOT, check=True)
        path = ROOT / "tools" / name / "RESULTS.md"
        tables = TABLES.get(name, {name: name})
        text = path.read_text(encoding="utf-8")
        for lines, table in tables.items():
            table_text = (OUT / name / f"{table}.md").read_text(encoding="utf-8")
            text = replaced(text, path, lines, table_text)
        path.write_text(text, encoding="utf-8")
        for picture in tables:
            if (OUT / name / f"{picture}.png").exists():
                shutil.copy(OUT / name / f"{picture}.png", ROOT / "scenes/pictures")


if __name__ == "__main__":
    main(sys.argv[1:])
