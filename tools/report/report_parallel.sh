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
if [[ $(parallel --version 2> /dev/null) != "GNU parallel"* ]]; then
  echo "report_parallel.sh: GNU parallel is not in PATH; install it (package parallel)" >&2
  exit 3
fi

cd -- "$folder"
# One line of JSON a session; a session that fails tells so in its line, and parallel goes on. It
# exits with the number of failed jobs, 101 for more than a hundred; beyond that it failed itself.
status=0
find . -name session.lcmlog -type f -printf '%h\0' |
  parallel --null --jobs "${3:-100%}" --timeout "${SESSION_SECONDS:-600}" \
    --joblog "$table.joblog" "$hpdm" report --json-line -- '{}' > "$table.jsonl" || status=$?
if ((status > 101)); then
  echo "report_parallel.sh: GNU parallel ended with code $status; no table is made" >&2
  exit "$status"
fi
"$hpdm" report --collect "$table.jsonl" --out "$table"
