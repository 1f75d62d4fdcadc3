#!/usr/bin/env bash
# Sets up HPDM on a fresh Debian 12 and runs its main job: a simulated trainee palpates a liver for ten
# seconds, without a display. Leaves the summary, a picture and a session log in out/demo.
set -euo pipefail
cd "$(dirname "$0")/.."
tools/setup.sh hpdm hpdm_example_driver
out=out/demo
rm -rf "$out"
build/tools/hpdm run scenes/liver_palpation.toml --headless --seconds 10 --out "$out" "$@"
