#!/usr/bin/env bash
#SBATCH --job-name=hpdm-report
#SBATCH --array=0-99
#SBATCH --cpus-per-task=1
#SBATCH --mem=1G
#SBATCH --time=04:00:00
#
# Reports every session below a folder as a Slurm array: each task takes every hundredth session and
# writes one file of lines.
#
#     sbatch --export=ALL,SESSIONS=/data/sessions,LINE_FILES=/data/lines tools/report/report_slurm.sh
#     hpdm report --collect /data/lines/*.jsonl --out /data/sessions.sqlite     # when all have ended
#     hpdm report --all /data/sessions --out /data/sessions.sqlite              # what is missing
#
# HPDM names the program (hpdm in PATH unless given), SESSION_SECONDS the patience with one session.
set -euo pipefail
hpdm=$(realpath -- "$(command -v -- "${HPDM:-hpdm}")")
mkdir -p -- "$LINE_FILES"
lines=$(realpath -- "$LINE_FILES")/$SLURM_ARRAY_TASK_ID.jsonl

cd -- "$SESSIONS"
mapfile -d '' -t folders < <(find . -name session.lcmlog -type f -printf '%h\0' | sort --zero-terminated)
: > "$lines.part"
for ((i = SLURM_ARRAY_TASK_ID - ${SLURM_ARRAY_TASK_MIN:-0}; i < ${#folders[@]};
      i += ${SLURM_ARRAY_TASK_COUNT:-100})); do
  # A session that fails tells so in its line.
  timeout "${SESSION_SECONDS:-600}" "$hpdm" report --json-line -- "${folders[i]}" \
    >> "$lines.part" || true
done
mv -- "$lines.part" "$lines"
