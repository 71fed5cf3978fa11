#!/usr/bin/env bash
# The Slurm scripts of farm/slurm under a real Slurm, all of it on this machine: three pictures of five shards each (path, bdpt and
# mlt), whose tasks are stopped, killed and requeued while they render, must merge to the pixels of a single run.
#
#   ETENDUE=path   the binary [default: target/release/etendue]
#   KEEP=1         keep the folder with all logs
#
# Needs slurmctld, slurmd, the Slurm clients and munged; and root, as slurmd does. Starts daemons of its own, with their own ports and
# state, and ends them.
set -euo pipefail
cd "$(dirname "$0")/../.."

etendue=$(realpath "${ETENDUE:-target/release/etendue}")
scene=$PWD/scenes/cornell-box/scene.gltf
PATH=$PATH:/usr/sbin:/sbin
say() { printf '[%3d s] %s\n' "$SECONDS" "$*"; }
fail() { printf 'FAILED: %s\n' "$*" >&2; exit 1; }
[ -x "$etendue" ] || fail "there is no $etendue: make build, or set ETENDUE"
for tool in munged slurmctld slurmd sbatch scontrol scancel sinfo python3; do
  command -v "$tool" >/dev/null || fail "there is no $tool: apt-get install --no-install-recommends munge slurmctld slurmd slurm-client python3"
done
[ "$(id -u)" = 0 ] || fail "slurmd needs root"

dir=$(mktemp -d "${TMPDIR:-/tmp}/etendue-slurm.XXXXXX")
daemons=()

# --- always clean up ----------------------------------------------------------------------------------------------
finish() {
  local code=$? log i
  trap - EXIT INT TERM
  set +e
  if [ "$code" != 0 ]; then
    echo "--- jobs"; timeout 10 scontrol show job 2>&1 | grep -E 'JobId|JobState|Restarts|ExitCode'
    for log in "$dir"/*.films/*.log "$dir"/submit-*.txt; do [ -f "$log" ] && { echo "--- $log"; tail -n 30 "$log"; }; done
    for log in munged slurmctld slurmd; do echo "--- $log"; tail -n 40 "$dir/$log".{out,log} 2>/dev/null; done
  fi
  timeout 10 scancel --user="$(id -un)" 2>/dev/null
  for _ in {1..75}; do [ -z "$(timeout 5 squeue --noheader 2>/dev/null)" ] && break; sleep 0.2; done # until its processes have ended
  # Last the one that was started first: the others talk through it.
  for ((i = ${#daemons[@]} - 1; i >= 0; i--)); do stop "${daemons[i]}"; done
  if [ -n "${KEEP:-}" ]; then echo "kept: $dir"; else rm -rf "$dir"; fi
  exit "$code"
}
stop() {
  kill -TERM "$1" 2>/dev/null || return 0
  for _ in {1..50}; do kill -0 "$1" 2>/dev/null || return 0; sleep 0.1; done
  kill -KILL "$1" 2>/dev/null
}
trap finish EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

# --- a cluster of one node ----------------------------------------------------------------------------------------
port=$((20000 + $$ % 10000))
node=$(hostname -s) me=$(id -un)
chmod 755 "$dir"
mkdir "$dir/state" "$dir/spool"
head -c 1024 /dev/urandom >"$dir/munge.key"
chmod 400 "$dir/munge.key"
cat >"$dir/slurm.conf" <<CONF
ClusterName=etendue-test
SlurmctldHost=$node(127.0.0.1)
SlurmUser=$me
SlurmdUser=$me
SlurmctldPort=$port
SlurmdPort=$((port + 1))
# cred_expire is also how long a requeued job waits before it may start again; two minutes unless said.
AuthInfo=socket=$dir/munge.socket,cred_expire=5
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool
SlurmctldPidFile=$dir/slurmctld.pid
SlurmdPidFile=$dir/slurmd.pid
SlurmctldLogFile=$dir/slurmctld.log
SlurmdLogFile=$dir/slurmd.log
ProctrackType=proctrack/linuxproc
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/builtin
SchedulerParameters=sched_interval=1,batch_sched_delay=0
SlurmdParameters=config_overrides
MpiDefault=none
ReturnToService=2
MinJobAge=3600
KillWait=10
NodeName=$node NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
# Later versions ask for cgroups although nothing here uses them; earlier ones do not know how to do without.
version=$(slurmd -V | sed 's/[^0-9]*\([0-9]*\.[0-9]*\).*/\1/')
if [ "$(printf '%s\n' 24.05 "$version" | sort -V | head -n 1)" = 24.05 ]; then echo CgroupPlugin=disabled >"$dir/cgroup.conf"; fi
export SLURM_CONF=$dir/slurm.conf
unset "${!SBATCH_@}" "${!SLURM_ARRAY_@}"

munged --foreground --force --socket="$dir/munge.socket" --key-file="$dir/munge.key" --pid-file="$dir/munged.pid" \
  --log-file="$dir/munged.log" --seed-file="$dir/munged.seed" >"$dir/munged.out" 2>&1 &
daemons+=($!)
for _ in {1..100}; do [ -S "$dir/munge.socket" ] && break; sleep 0.1; done
slurmctld -D -f "$SLURM_CONF" >"$dir/slurmctld.out" 2>&1 &
daemons+=($!)
slurmd -D -f "$SLURM_CONF" >"$dir/slurmd.out" 2>&1 &
daemons+=($!)
for _ in {1..150}; do
  [ "$(timeout 5 sinfo --noheader --format=%t 2>/dev/null)" = idle ] && break
  for pid in "${daemons[@]}"; do kill -0 "$pid" 2>/dev/null || { cat "$dir"/*.out; fail "a daemon of Slurm ended"; }; done
  sleep 0.2
done
[ "$(sinfo --noheader --format=%t)" = idle ] || fail "the node is $(sinfo --noheader --format=%t) and not idle"
say "Slurm $version runs"

# --- helpers ------------------------------------------------------------------------------------------------------
hash_of() { python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))["pixel_hash"])' "$1"; }
field() { scontrol --oneliner show job "$1" | grep -oE "(^| )$2=[^ ]*" | head -n 1 | cut -d= -f2; } # JOB NAME
state() { field "$1" JobState; }
# wait_for SECONDS WHAT COMMAND…: until the command succeeds
wait_for() {
  local until=$((SECONDS + $1)) what=$2
  shift 2
  until "$@"; do [ "$SECONDS" -lt "$until" ] || fail "in vain waited for: $what"; sleep 0.2; done
}
ended() { [[ $(state "$1") =~ ^(COMPLETED|FAILED|CANCELLED|TIMEOUT|NODE_FAIL|OUT_OF_MEMORY)$ ]]; }
# submit NAME SCENE SHARDS [option]…: sets array and merge
submit() {
  local name=$1
  shift
  farm/slurm/submit.sh "$1" "$2" "$dir/$name.exr" --report "$dir/$name.json" "${@:3}" >"$dir/submit-$name.txt"
  read -r array merge < <(sed -E 's/shards: job ([0-9]+), merge: job ([0-9]+),.*/\1 \2/' "$dir/submit-$name.txt")
}
export ETENDUE=$etendue ETENDUE_SBATCH='--cpus-per-task=1 --nice=0'
single() { nice "$etendue" render "$scene" "${@:2}" --quiet --output "$dir/single-$1.exr" --report "$dir/single-$1.json" >/dev/null; }

# --- tasks are hit while they render ------------------------------------------------------------------------------
methods=(path bdpt mlt)
declare -A spp=([path]=4096 [bdpt]=1024 [mlt]=1024) arrays=() merges=() hit=()
options() { printf '%s\n' --size 64x64 --method "$1" --spp "${spp[$1]}"; }
for method in "${methods[@]}"; do
  mapfile -t picture < <(options "$method")
  submit "$method" "$scene" 5 "${picture[@]}"
  arrays[$method]=$array merges[$method]=$merge
done
say "3 × 5 shards submitted"

# rendering METHOD TASK N: has the Nth start of the task reached the picture (from then on signals are heard)?
rendering() { [ -f "$dir/$1.films/$2.log" ] && [ "$(grep -c '^etendue: rendering' "$dir/$1.films/$2.log")" -ge "$3" ]; }
process() { sed -n 's/.* process \([0-9]*\)$/\1/p' "$dir/$1.films/$2.log" | tail -n 1; }
# scancel of 22.05 is told "try again later" about tasks of arrays although the signal was sent, and sends it again after 5 s.
usr1() { timeout 2 scancel --signal=USR1 --batch "$1" || [ $? = 124 ]; }
hits=0 wanted=12
strike() { # METHOD TASK N COMMAND…: once, and in the middle
  local key=$1.$2.$3
  [ -z "${hit[$key]:-}" ] && rendering "$1" "$2" "$3" || return 0
  sleep 0.4
  "${@:4}" || fail "could not do to task $2 of $1: ${*:4}"
  hit[$key]=1 hits=$((hits + 1))
  say "$1, task $2, start $3: ${*:4}"
}
until_=$((SECONDS + 240))
while [ "$hits" -lt "$wanted" ]; do
  [ "$SECONDS" -lt "$until_" ] || fail "only $hits of $wanted tasks could be hit: ${!hit[*]}"
  for method in "${methods[@]}"; do
    job=${arrays[$method]}
    strike "$method" 1 1 usr1 "${job}_1" # as before the time limit: film saved, requeued, resumed …
    if rendering "$method" 1 2; then strike "$method" 1 2 kill -KILL "$(process "$method" 1)"; fi # … and killed, the film stays
    if rendering "$method" 2 1; then strike "$method" 2 1 kill -KILL "$(process "$method" 2)"; fi # killed with nothing saved
    strike "$method" 3 1 scontrol requeue "${job}_3" # requeued from outside, as preemption does
  done
  sleep 0.1
done

# --- what it must have come to ------------------------------------------------------------------------------------
for method in "${methods[@]}"; do
  mapfile -t picture < <(options "$method")
  single "$method" "${picture[@]}"
done
say "single runs done"
has() { grep -q -- "$3" "$dir/$1.films/$2.log" || fail "the log of task $2 of $1 lacks: $3"; }
for method in "${methods[@]}"; do
  wait_for 200 "merge of $method" ended "${merges[$method]}"
  [ "$(state "${merges[$method]}")" = COMPLETED ] || fail "the merge of $method ended as $(state "${merges[$method]}")"
  has "$method" 1 "stopped by a signal after"
  has "$method" 1 "back into the queue"
  has "$method" 1 "samples per pixel so far"
  has "$method" 1 "killed by signal 9: back into the queue"
  has "$method" 2 "killed by signal 9: back into the queue"
  has "$method" 3 "stopped by Slurm, exit code 75"
  has "$method" 3 "samples per pixel so far"
  for task in 1:2 2:1 3:1 0:0 4:0; do
    restarts=$(field "${arrays[$method]}_${task%:*}" Restarts)
    [ "$restarts" = "${task#*:}" ] || fail "task ${task%:*} of $method was restarted $restarts times, not ${task#*:}"
  done
  want=$(hash_of "$dir/single-$method.json") got=$(hash_of "$dir/$method.json")
  [ "$want" = "$got" ] || fail "$method: the merged picture has the hash $got, a single run $want"
  say "$method: $got, as in a single run"
done

# --- again, and another picture -----------------------------------------------------------------------------------
mapfile -t picture < <(options path)
rm "$dir/path.json"
submit path "$scene" 5 "${picture[@]}"
wait_for 60 "merge after a second submission" ended "$merge"
[ "$(state "$merge")" = COMPLETED ] || fail "the second merge ended as $(state "$merge")"
for task in 0 1 2 3 4; do has path "$task" "is complete"; done
[ "$(hash_of "$dir/path.json")" = "$(hash_of "$dir/single-path.json")" ] || fail "the second merge has other pixels"
say "submitted again: every shard ended at once"
if (submit path "$scene" 5 --size 64x64 --spp 8) 2>"$dir/refused.txt"; then fail "films of another picture were taken"; fi
grep -q "holds another picture" "$dir/refused.txt" || fail "not refused but: $(cat "$dir/refused.txt")"

# --- a scene that is invalid is not tried again -------------------------------------------------------------------
echo '{"asset": 1' >"$dir/broken.gltf"
submit broken "$dir/broken.gltf" 2 --size 8x8 --spp 4
wait_for 60 "the end of a merge that cannot be" ended "$merge"
[ "$(state "$merge")" = CANCELLED ] || fail "the merge of a broken scene ended as $(state "$merge")"
for task in 0 1; do
  wait_for 30 "a broken task" ended "${array}_$task"
  [ "$(state "${array}_$task") $(field "${array}_$task" ExitCode) $(field "${array}_$task" Restarts)" = "FAILED 3:0 0" ] ||
    fail "a task with a broken scene: $(scontrol --oneliner show job "${array}_$task")"
done
say "an invalid scene: exit code 3, tried once, merge cancelled"
say "slurm.sh: all is well"
