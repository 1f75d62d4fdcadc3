#!/usr/bin/env bash
#SBATCH --job-name=hpdm-report
#SBATCH --array=0-99
#SBATCH --cpus-per-task=1
#SBATCH --mem=1G
#SBATCH --time=04:00:00
#
# Reports every session below a folder as a Slurm array: task i of TASKS (100) takes the sessions i,
# i + TASKS, ... and writes one file of lines. Another number of tasks is named twice, --array=0-9 and
# TASKS=10; --array=3,7 alone does those two again, with the same sessions.
#
#     sbatch --export=ALL,SESSIONS=/data/sessions,LINE_FILES=/data/lines tools/report/report_slurm.sh
#     hpdm report --collect /data/lines/*.jsonl --out /data/sessions.sqlite     # when all have ended
#     hpdm report --all /data/sessions --out /data/sessions.sqlite              # what is missing
#
# HPDM names the program (hpdm in PATH unless given), SESSION_SECONDS the patience with one session.
set -euo pipefail
tasks=${TASKS:-100}
if ((SLURM_ARRAY_TASK_ID >= tasks)); then
  echo "report_slurm.sh: task $SLURM_ARRAY_TASK_ID of $tasks; give TASKS=<number of tasks>" >&2
  exit 2
fi
hpdm=$(realpath -- "$(command -v -- "${HPDM:-hpdm}")")
mkdir -p -- "$LINE_FILES"
lines=$(realpath -- "$LINE_FILES")/$SLURM_ARRAY_TASK_ID.jsonl

cd -- "$SESSIONS"
mapfile -d '' -t folders < <(find . -name session.lcmlog -type f -printf '%h\0' | sort --zero-terminated)
: > "$lines.part"
for ((i = SLURM_ARRAY_TASK_ID; i < ${#folders[@]}; i += tasks)); do
  # A session that fails tells so in its line.
  timeout "${SESSION_SECONDS:-600}" "$hpdm" report --json-line -- "${folders[i]}" \
    >> "$lines.part" || true
done
mv -- "$lines.part" "$lines"
