#!/usr/bin/env bash
# Reports every session below a folder with GNU parallel and puts them into a table.
#
#     tools/report/report_parallel.sh FOLDER TABLE.sqlite [JOBS]
#
# HPDM names the program (hpdm in PATH unless given), SESSION_SECONDS the patience with one session
# (600). Further machines: PARALLEL="--sshloginfile machines.txt --workdir $PWD/FOLDER", with FOLDER
# at the same place on all of them.
set -euo pipefail
folder=$1
table=$(realpath --canonicalize-missing -- "$2")
hpdm=$(realpath -- "$(command -v -- "${HPDM:-hpdm}")")

cd -- "$folder"
# One line of JSON a session; a session that fails tells so in its line, and parallel goes on.
find . -name session.lcmlog -type f -printf '%h\0' |
  parallel --null --jobs "${3:-100%}" --timeout "${SESSION_SECONDS:-600}" \
    --joblog "$table.joblog" "$hpdm" report --json-line -- '{}' > "$table.jsonl" || true
"$hpdm" report --collect "$table.jsonl" --out "$table"
