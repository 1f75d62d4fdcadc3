#!/usr/bin/env bash
# Checks the sources with cppcheck, without the false alarms in tools/cppcheck.txt, and with clang-tidy,
# with the checks in .clang-tidy. Exit 1 if either reports a fault.
# Usage: tools/lint.sh [--quick | FILE_OR_FOLDER...]      (no argument: everything, about an hour)
#   --quick   cppcheck over everything, clang-tidy only over the parsers of untrusted input
set -euo pipefail
cd "$(dirname "$0")/.."

folders=(engine haptics lcmtypes render scenes tests tools)
# Sources that parse files, messages and requests, or check paths.
foreign=(
  engine/mesh/files/mesh_file.cc engine/mesh/files/mesh_file_obj.cc
  engine/mesh/files/mesh_file_ply.cc engine/mesh/files/mesh_file_stl.cc
  engine/tissue/tissue_cache.cc
  haptics/device/trace_file.cc
  lcmtypes/live/device_link.cc lcmtypes/live/network.cc lcmtypes/log/log.cc lcmtypes/wire/codec.cc
  lcmtypes/wire/mesh_codec.cc lcmtypes/wire/message_schema.cc lcmtypes/wire/message_schema_parser.cc
  lcmtypes/wire/message_walk.cc
  render/image/image_file.cc
  scenes/loader/file_hash.cc scenes/loader/scene_files.cc scenes/loader/table_reader.cc
  scenes/loader/toml_document.cc
  tools/log/log_export.cc tools/session/session_folder.cc tools/session/session_path.cc
  tools/shared/child_process.cc tools/shared/staged_file.cc tools/spy/dashboard/request_origin.cc
  tools/spy/dashboard/request_server.cc
)

to_check=("${folders[@]}")  # by cppcheck
to_tidy=("${folders[@]}")
if [ "${1:-}" = --quick ]; then
  to_tidy=("${foreign[@]}")
elif [ $# -gt 0 ]; then
  to_check=("$@")
  to_tidy=("$@")
fi
# clang-tidy cannot read GCC's precompiled headers.
cmake --preset release -B build-lint -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON >/dev/null
cmake --build build-lint --target hpdm_lcm_headers >/dev/null

failed=0
echo "lint: cppcheck"
cppcheck -j2 --quiet --language=c++ --std=c++20 --library=googletest \
  --enable=warning,performance,portability --suppressions-list=tools/cppcheck.txt \
  --template='{file}:{line}: {message} [{id}]' --error-exitcode=1 -I. "${to_check[@]}" || failed=1

# Selects files of the compile database: those named, and those below a named folder.
mapfile -t sources < <(
  python3 - "${to_tidy[@]}" <<'PYTHON'
import json, os, sys
wanted = [os.path.normpath(name) for name in sys.argv[1:]]
with open("build-lint/compile_commands.json") as file:
    files = {os.path.relpath(entry["file"]) for entry in json.load(file)}
for name in sorted(files):
    if any(name == w or name.startswith(w + "/") for w in wanted):
        print(name)
PYTHON
)
echo "lint: clang-tidy over ${#sources[@]} files"
if [ ${#sources[@]} -gt 0 ]; then
  # clang does not know all of GCC's warning options.
  printf '%s\0' "${sources[@]}" |
    xargs -0 -P2 -n1 clang-tidy -p build-lint --quiet --extra-arg=-Wno-unknown-warning-option \
      2> >(grep -vE '^[0-9]+ warnings?( and [0-9]+ errors?)? generated|^Suppressed|^Use -' >&2) ||
    failed=1
fi
exit $failed
