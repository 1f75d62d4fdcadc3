#!/usr/bin/env bash
# Builds the fuzz targets (tests/fuzz; clang) and runs each for SECONDS, two at a time. Starts
# from the seeds, earlier findings, and the inputs that earlier runs kept in build-asan/fuzz/corpus.
# Usage: tools/fuzz.sh [SECONDS [TARGET...]]      (20 seconds; no target: all)
# Exit 1 if an input breaks a reader; its name and base64 bytes are printed. After the fix, add it to
# tests/fuzz/findings/TARGET, where fuzz_memory_tests replays it in every build.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:-20}
shift || true
cmake --preset asan >/dev/null
cmake --build build-asan --target fuzz | tail -n 1

# Temporary files of the targets, which a crash leaves behind. In memory they are 100 times as fast.
scratch=$(mktemp --directory --tmpdir=/dev/shm 2>/dev/null || mktemp --directory)
trap 'rm -rf "$scratch"' EXIT
export seconds TMPDIR=$scratch ASAN_OPTIONS=quarantine_size_mb=32

fuzz() {
  local target=$1 seeds=tests/fuzz/corpus/$1 found=tests/fuzz/findings/$1 input rc=0
  local kept=build-asan/fuzz/corpus/$1 broken=build-asan/fuzz/broken/$1 log=build-asan/fuzz/$1.log
  local dictionary=tests/fuzz/dictionaries/$1.dict folders=("$kept" "$seeds") options=()
  if [ -d "$found" ]; then folders+=("$found"); fi
  if [ -f "$dictionary" ]; then options+=(-dict="$dictionary"); fi
  rm -rf "$broken"
  mkdir -p "$kept" "$broken"
  # No reader may need more than 64 MB at once, or more than seconds, for 4 kB of input.
  "build-asan/tests/fuzz/fuzz_$target" -max_total_time="$seconds" -max_len=4096 -timeout=20 \
    -malloc_limit_mb=64 -rss_limit_mb=1024 -artifact_prefix="$broken/" -print_final_stats=1 \
    "${options[@]}" "${folders[@]}" >"$log" 2>&1 || rc=$?
  awk -v target="$target" '/ cov: / { covered = $4 } /number_of_executed_units/ { runs = $2 }
    END { printf "%-10s %9d inputs, %5d branches\n", target, runs, covered }' "$log"
  if [ "$rc" -eq 0 ]; then return 0; fi
  grep -E -m 4 'what\(\)|ERROR|SUMMARY|runtime error' "$log" || tail -n 5 "$log"
  for input in "$broken"/*; do
    echo "fuzz: $input breaks $target; run build-asan/tests/fuzz/fuzz_$target on it. Its bytes:"
    base64 "$input"
  done
  return 1
}
export -f fuzz

targets=("$@")
if [ ${#targets[@]} -eq 0 ]; then
  mapfile -t targets < <(cd tests/fuzz/corpus && printf '%s\n' *)
fi
if ! printf '%s\n' "${targets[@]}" |
  xargs -P 2 -I {} bash -euo pipefail -c 'fuzz {}'; then
  exit 1
fi
