#!/bin/sh
#SBATCH --job-name=adumbra
#SBATCH --nodes=1
#SBATCH --ntasks=1
#SBATCH --requeue
#SBATCH --open-mode=append
# Written by `adumbra plan --export slurm`. Submit the whole bake (an array of tiles, then the link):
#   sh THIS [--wait] [sbatch options: --partition=render --time=2:00:00 --cpus-per-task=8 ...]
# --wait: come back when the link has ended, with its exit code. Safe to submit again: what is done is skipped.
program=@PROGRAM@
plan=@PLAN@
cache=@CACHE@
output=@OUTPUT@
shards=${ADUMBRA_SHARDS:-@SHARDS@}
tries=${ADUMBRA_TRIES:-5}
wait=${ADUMBRA_RETRY_WAIT:-30}
requeues=${ADUMBRA_REQUEUES:-3}

again() { # again COMMAND...: run it; while it says "try again later" (75), up to $tries times
  try=1
  while :; do
    rc=0
    "$@" || rc=$?
    if [ "$rc" -ne 75 ] || [ "$try" -ge "$tries" ]; then return "$rc"; fi
    echo "try again later ($try of $tries)" >&2
    try=$((try + 1))
    sleep "$wait"
  done
}

rc=0
case ${1-} in
adumbra-tile)
  again "$program" tile --plan "$plan" --cache "$cache" --shard "$SLURM_ARRAY_TASK_ID/$2"@THREADS@ || rc=$?
  job=${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID
  ;;
adumbra-link)
  again "$program" link --plan "$plan" --cache "$cache" -o "$output"@THREADS@ || rc=$?
  job=$SLURM_JOB_ID
  ;;
*) job= ;;
esac
if [ -n "$job" ]; then
  # Still "try again later": give the node back and come again (Slurm waits two minutes), a few times.
  if [ "$rc" -eq 75 ] && [ "${SLURM_RESTART_COUNT:-0}" -lt "$requeues" ] && scontrol requeue "$job"; then sleep 60; fi
  exit "$rc"
fi

# On the machine that submits: this very file is the script of both jobs.
set -eu
case $0 in */*) self=$0 ;; *) self=./$0 ;; esac
hold=
if [ "${1-}" = --wait ]; then hold=1; shift; fi
tile=$(sbatch --parsable --array="0-$((shards - 1))" --output=adumbra-tile-%A_%a.log "$@" "$self" adumbra-tile "$shards")
tile=${tile%%;*}
echo "tile: job $tile, $shards shards"
link=$(sbatch --parsable ${hold:+--wait} --dependency="afterok:$tile" --kill-on-invalid-dep=yes \
  --output=adumbra-link-%j.log "$@" "$self" adumbra-link) && rc=0 || rc=$?
link=${link%%;*}
echo "link: job $link"
# sbatch --wait says 0 of a link that was cancelled because a tile failed: ask for its state too.
if [ -n "$hold" ] && [ "$rc" -eq 0 ]; then
  scontrol --oneliner show job "$link" | grep -q ' JobState=COMPLETED ' || { echo "link: did not run to its end: a tile failed" >&2; rc=1; }
fi
exit "$rc"
