#!/usr/bin/env bash
# Set-up and every test of the release build, one more at a time than there are cores: some only wait.
# Arguments go to ctest (for example -R Lattice).
set -euo pipefail
cd "$(dirname "$0")/.."
tools/setup.sh
ctest --test-dir build --parallel $(($(nproc) + 1)) --output-on-failure --progress "$@"
