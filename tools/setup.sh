#!/usr/bin/env bash
# Installs the missing packages of tools/packages.txt, then configures and builds.
# Usage: tools/setup.sh [--install-only | TARGET...]      (no target: everything)
# Idempotent and quiet; the full output is in build/setup.log.
set -euo pipefail
cd "$(dirname "$0")/.."

# --- packages -------------------------------------------------------------------------------------
mapfile -t packages < <(grep -vE '^[[:space:]]*(#|$)' tools/packages.txt)
missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null || true)
  [ "$status" = installed ] || missing+=("$package")
done

mkdir -p build
log=$PWD/build/setup.log
: >"$log"
run() {  # run WHAT COMMAND...: quiet unless it fails
  local what=$1
  shift
  if ! "$@" >>"$log" 2>&1; then
    tail -n 40 "$log" >&2
    echo "setup: $what failed; the full output is in $log" >&2
    exit 1
  fi
}

if [ ${#missing[@]} -gt 0 ]; then
  as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null; then
      echo "setup: missing packages: ${missing[*]}; install them as root, or install sudo" >&2
      exit 3
    fi
    as_root=(sudo)
  fi
  echo "setup: installing ${#missing[@]} packages"
  run "apt-get update" "${as_root[@]}" apt-get update
  run "apt-get install" "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install --yes --no-install-recommends "${missing[@]}"
fi
if [ "${1:-}" = --install-only ]; then exit 0; fi

# --- build ----------------------------------------------------------------------------------------
echo "setup: building"
strict=OFF
if [ -n "${CI:-}" ]; then strict=ON; fi
# A build of everything takes half of the time in units of several files. Who edits sets
# CMAKE_UNITY_BUILD=OFF once (cmake --preset release -DCMAKE_UNITY_BUILD=OFF); it is kept.
unity=()
if [ ! -e build/CMakeCache.txt ]; then unity=(-DCMAKE_UNITY_BUILD=ON); fi
run "cmake" cmake --preset release -DHPDM_WERROR=$strict "${unity[@]}"
targets=()
for target in "$@"; do targets+=(--target "$target"); done
run "the build" cmake --build build "${targets[@]}"
