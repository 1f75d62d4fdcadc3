#!/usr/bin/env bash
# Set-up and main job on a fresh Debian 12: a simulated trainee palpates a liver for ten seconds,
# without a display. Ends with the summary, a picture and a session log in out/demo.
set -euo pipefail
cd "$(dirname "$0")/.."
tools/setup.sh hpdm
out=out/demo
rm -rf "$out"
build/tools/hpdm run scenes/liver_palpation.toml --headless --seconds 10 --out "$out" "$@"
