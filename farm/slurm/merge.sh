#!/usr/bin/env bash
# Makes the picture of the films of all shards: a Slurm job that depends on the array job of shard.sh. submit.sh submits it. By hand:
#
#   sbatch --dependency=afterok:ARRAY_JOB merge.sh FILMS SHARDS OUT.exr [option of `etendue merge`]…
#
#   ETENDUE=path         the binary [default: etendue]
#   ETENDUE_RETRIES=3    how often it is tried again after exit codes 4 and 33, or if it was killed
#
#SBATCH --job-name=etendue-merge
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --time=1:00:00
#SBATCH --requeue
#SBATCH --open-mode=append
set -uo pipefail

say() { printf 'merge.sh: %s\n' "$*" >&2; }
[ $# -ge 3 ] || { say "usage: merge.sh FILMS SHARDS OUT.exr [option of etendue merge]…"; exit 2; }
films=$1 shards=$2 out=$3
shift 3
list=()
for ((i = 0; i < shards; i++)); do list+=("$films/$i-of-$shards.film"); done

code=0
"${ETENDUE:-etendue}" merge "${list[@]}" --output "$out" "$@" || code=$?
case $code in
  4 | 33 | 137)
    if [ "${SLURM_RESTART_COUNT:-0}" -lt "${ETENDUE_RETRIES:-3}" ]; then
      say "exit code $code: back into the queue"
      scontrol requeue "$SLURM_JOB_ID"
    fi
    ;;
esac
exit "$code"
