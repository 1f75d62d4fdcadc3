#!/usr/bin/env bash
# Sets up the release build and runs every test. One test more than there are cores runs at a time, since
# some only wait. Arguments are passed to ctest (for example -R Lattice). With CI set, a skipped test that
# tests/may_skip.txt does not name fails the run.
set -euo pipefail
cd "$(dirname "$0")/.."
tools/setup.sh
log=build/tests.log
rc=0
ctest --test-dir build --parallel $(($(nproc) + 1)) --output-on-failure --progress \
  --output-log "$log" "$@" || rc=$?

# ctest ends with a list of the tests that did not run: "  12 - Suite.Name (Skipped)".
conditions=always
if [ ! -d ../shared/data ]; then conditions='always|no-shared-data'; fi
allowed=$(awk -v conditions="^($conditions)\$" '!/^#/ && $2 ~ conditions { print $1 }' tests/may_skip.txt)
skipped=$(sed -nE 's/^[[:space:]]*[0-9]+ - (.*) \(Skipped\).*/\1/p' "$log" | sort -u)
unexpected=$(comm -23 <(echo "$skipped") <(echo "$allowed" | sort -u))
if [ -n "$unexpected" ]; then
  echo "test: skipped, but not named in tests/may_skip.txt:" $unexpected >&2
  if [ -n "${CI:-}" ]; then exit 1; fi
fi
exit "$rc"
