#!/usr/bin/env bash
# One shard of a picture: a task of a Slurm array job. submit.sh submits it. By hand, for five shards:
#
#   sbatch --array=0-4 shard.sh SCENE FILMS [option of `etendue render`]…
#
# FILMS is a folder that all nodes see. A shard is rendered into FILMS/I-of-N.part.film, which is renamed to FILMS/I-of-N.film once
# it is complete. So a task can be started as often as one likes: it begins, goes on, or ends at once.
#
#   USR1 (Slurm sends it 90 s before the time limit) saves the film and requeues the task.
#   TERM (scancel, preemption, scontrol requeue) saves the film too; whether the task runs again is up to Slurm.
#
#   ETENDUE=path         the binary [default: etendue]
#   ETENDUE_SHARDS=N     the number of shards [default: that of the array's tasks]; set it to run a single one again
#   ETENDUE_RETRIES=3    how often a shard is tried again after a failure that may pass: exit codes 4 and 33, killed, or stopped while
#                        the scene was loading
#
#SBATCH --job-name=etendue-shard
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=4
#SBATCH --time=1:00:00
#SBATCH --signal=B:USR1@90
#SBATCH --requeue
#SBATCH --open-mode=append
set -uo pipefail

say() { printf 'shard.sh: %s\n' "$*" >&2; }
die() { say "$*"; exit 2; }

[ $# -ge 2 ] || die "usage: sbatch --array=0-LAST shard.sh SCENE FILMS [option of etendue render]…"
[ -n "${SLURM_ARRAY_TASK_ID:-}" ] || die "this is a task of an array job: sbatch --array=0-LAST"
etendue=${ETENDUE:-etendue}
scene=$1 films=$2
shift 2
shard=$SLURM_ARRAY_TASK_ID shards=${ETENDUE_SHARDS:-$SLURM_ARRAY_TASK_COUNT}
[ "$shard" -lt "$shards" ] || die "there is no shard $shard of $shards: they are counted from 0"
task=${SLURM_ARRAY_JOB_ID}_$shard
film=$films/$shard-of-$shards.film part=$films/$shard-of-$shards.part.film tries=$films/$shard-of-$shards.tries

if [ -e "$film" ]; then say "shard $shard of $shards is complete"; exit 0; fi

# Puts this task back into the queue. It is done while the task still runs: had it ended with another exit code than 0, the merge
# job that waits for it would never start. Slurm then ends this script with TERM.
requeue() {
  say "$1: back into the queue"
  scontrol requeue "$task" && exit 75
  say "scontrol could not requeue $task"
  exit "$code"
}
# The same, a few times only.
try_again() {
  printf '%s %s: %s\n' "$(date -u +%FT%TZ)" "${SLURMD_NODENAME:-?}" "$1" >>"$tries"
  if [ "$(wc -l <"$tries")" -gt "${ETENDUE_RETRIES:-3}" ]; then
    say "$1, and tried often enough ($tries): giving up"
    exit "$code"
  fi
  requeue "$1"
}

# --- signals ------------------------------------------------------------------------------------------------------
pid='' interrupted='' asked='' told='' code=75
tell() { if [ -n "$pid" ] && [ -z "$told" ]; then told=1; kill -TERM "$pid" 2>/dev/null; fi; } # once: a second TERM kills
# Only this shell hears USR1, so it is passed on.
# shellcheck disable=SC2317
on_usr1() { interrupted=1; asked=${asked:-USR1}; tell; }
# Slurm sends TERM to all processes of the task: étendue has it already.
# shellcheck disable=SC2317
on_term() { interrupted=1 asked=TERM told=1; }
trap on_usr1 USR1
trap on_term TERM

# --- render -------------------------------------------------------------------------------------------------------
if [ -e "$part" ]; then
  options=() # what `resume` takes of the options; the film knows the others
  while [ $# -gt 0 ]; do
    case $1 in
      --strict | --fail-on-nonfinite | -q | --quiet | -j?* | --threads=* | --progress=* | --status=*) options+=("$1") ;;
      -j | --threads | --progress | --status) options+=("${@:1:2}"); shift ;;
    esac
    shift
  done
  command=("$etendue" resume "$part" --scene "$scene" --output "$part" ${options[@]+"${options[@]}"})
else
  command=("$etendue" render "$scene" --shard "$shard/$shards" --output "$part" "$@")
fi
case $asked in
  USR1) requeue "stopped before the start" ;;
  TERM) exit 75 ;;
esac
before=$(stat -c %y "$part" 2>/dev/null)
"${command[@]}" &
pid=$!
[ -z "$asked" ] || tell
say "shard $shard of $shards on ${SLURMD_NODENAME:-?}, try $((${SLURM_RESTART_COUNT:-0} + 1)), process $pid"
code=0
wait "$pid" || code=$?
while [ -n "$interrupted" ]; do # a trapped signal ends `wait`, étendue has not ended yet
  interrupted='' code=0
  wait "$pid" || code=$?
done
pid=''

# --- what next ----------------------------------------------------------------------------------------------------
if [ "$code" = 0 ]; then
  mv -f "$part" "$film" || { code=4; try_again "$film cannot be written"; }
  rm -f "$tries"
  exit 0
fi
if [ "$asked" = TERM ]; then # cancelled, preempted or requeued: Slurm knows what comes next
  say "stopped by Slurm, exit code $code"
  exit "$code"
fi
if [ "$code" = 75 ] && [ "$(stat -c %y "$part" 2>/dev/null)" != "$before" ]; then requeue "stopped, the film is saved"; fi
case $code in
  75) try_again "stopped before the first sample" ;; # while the scene was loading: with this time limit, perhaps for ever
  4) try_again "output cannot be written" ;;
  33) try_again "out of memory" ;;
  1[3-9][0-9]) try_again "killed by signal $((code - 128))" ;;
  *) say "failed with exit code $code: no use in trying again"; exit "$code" ;;
esac
