#!/usr/bin/env bash
# Set-up and every test of the release build. Arguments go to ctest (for example -R Lattice).
set -euo pipefail
cd "$(dirname "$0")/.."
tools/setup.sh
ctest --test-dir build --parallel 2 --output-on-failure --progress "$@"
