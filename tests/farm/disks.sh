#!/usr/bin/env bash
# Disks and clocks that fail under a render: a disk that is full at the end, one that becomes read-only on the way, a clock that jumps by
# years. The exit code is the right one, the old image whole, no sample lost, and what is gone on with has the pixels of a single run.
# Needs root (it mounts small disks in a namespace of its own), unshare(1) and faketime(1).
#
#   ETENDUE=path   the binary [default: target/release/etendue]
#   KEEP=1         keep the folder with all logs
set -euo pipefail
cd "$(dirname "$0")/../.."

say() { printf '[%3d s] %s\n' "$SECONDS" "$*"; }
fail() { printf 'FAILED: %s\n' "$*" >&2; exit 1; }
[ "$(id -u)" = 0 ] || fail "mounting needs root"
command -v faketime >/dev/null || fail "there is no faketime: apt-get install faketime"
if [ -z "${OWN_MOUNTS:-}" ]; then exec env OWN_MOUNTS=1 unshare --mount --propagation private "$0"; fi

etendue=$(realpath "${ETENDUE:-target/release/etendue}")
scene=$PWD/scenes/cornell-box/scene.gltf
[ -x "$etendue" ] || fail "there is no $etendue: make build, or set ETENDUE"
dir=$(mktemp -d "${TMPDIR:-/tmp}/etendue-disks.XXXXXX")
running=''
finish() {
  local code=$? log
  trap - EXIT INT TERM
  set +e
  [ -z "$running" ] || kill -KILL "$running" 2>/dev/null
  if [ "$code" != 0 ]; then for log in "$dir"/*.log; do echo "--- $log"; tail -n 20 "$log"; done; fi
  umount "$dir/disk" 2>/dev/null
  if [ -n "${KEEP:-}" ]; then echo "kept: $dir"; else rm -rf "$dir"; fi
  exit "$code"
}
trap finish EXIT
trap 'exit 130' INT
trap 'exit 143' TERM
mkdir "$dir/disk"
cd "$dir"
picture=(render "$scene" --size 128x128 --progress none)
hash_of() { python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))["pixel_hash"])' "$1"; }
single() { # NAME OPTIONS...
  local name=$1
  shift
  "$etendue" "${picture[@]}" "$@" --quiet -o "single-$name.exr" --report "single-$name.json" >/dev/null
}
same() { # NAME: a report of that name and a single run
  [ "$(hash_of "$1.json")" = "$(hash_of "single-$1.json")" ] || fail "$1: other pixels than in a single run"
  say "$1: $(hash_of "$1.json"), as in a single run"
}
start() { # LOG OPTIONS...: runs in the background, and waits until it renders
  local log=$1
  shift
  "$etendue" "${picture[@]}" "$@" >"$log" 2>&1 &
  running=$!
  for _ in {1..100}; do grep -qs 'etendue: rendering' "$log" && return; sleep 0.05; done
  fail "$log: it does not begin"
}
ends() { # CODE LOG
  local code=0
  wait "$running" || code=$?
  running=''
  [ "$code" = "$1" ] || fail "$2: exit code $code, not $1"
}
go_on() { # NAME LOG: as the error says
  local how
  how=$(sed -n 's/.*nothing is lost: etendue //p' "$2")
  [ -n "$how" ] || fail "$2: it does not say how to go on"
  # shellcheck disable=SC2086
  "$etendue" $how --quiet --report "$1.json" >/dev/null || fail "$2: it does not go on"
}

# --- a disk that is full -------------------------------------------------------------------------------------------
mount -t tmpfs -o size=1m none disk
echo old >disk/x.exr
head -c 900000 /dev/zero >disk/filler
start full.log --spp 256 --checkpoint 200ms -o disk/x.exr
ends 4 full.log
grep -q 'No space left' full.log || fail "it does not say why"
[ "$(cat disk/x.exr)" = old ] || fail "the old image is not whole"
[ "$(find disk -type f | sort | tr '\n' ' ')" = 'disk/filler disk/x.exr ' ] || fail "something else is on the full disk"
rm disk/filler
go_on full full.log
single full --spp 256
same full
umount disk

# --- a disk that becomes read-only ---------------------------------------------------------------------------------
mount -t tmpfs -o size=9m none disk
start read-only.log --spp 1024 --checkpoint 100ms -o disk/x.exr
mount -o remount,ro disk
ends 4 read-only.log
grep -q 'Read-only file system.*the render goes on' read-only.log || fail "it does not warn"
mount -o remount,rw disk
go_on read-only read-only.log
single read-only --spp 1024
same read-only

# --- a clock that jumps --------------------------------------------------------------------------------------------
preload=$(find /usr/lib -name libfaketimeMT.so.1 | head -n 1)
export FAKETIME_TIMESTAMP_FILE=$dir/clock FAKETIME_NO_CACHE=1 FAKETIME_DONT_FAKE_MONOTONIC=1
echo '+0' >clock
LD_PRELOAD=$preload start clock.log --spp 1048576 --checkpoint 100ms -o clock.exr
sleep 0.5
echo '-1000d' >clock
sleep 0.5
kill -TERM "$running"
ends 75 clock.log
echo '+5000d' >clock
held=$("$etendue" status clock.film --json | python3 -c 'import json, sys; print(json.load(sys.stdin)["held"])')
spp=$(python3 -c "print(4 * 2 ** (($held + 3) // 4 - 1).bit_length())")
LD_PRELOAD=$preload "$etendue" resume clock.film --spp "$spp" --quiet --report clock.json -o clock.exr >clock.log 2>&1 || fail "it does not go on"
single clock --spp "$spp"
same clock
python3 - <<'PYTHON' || fail "the clock did not jump, or the time it took is not the sum of both"
import json
render = json.load(open("clock.json"))["render"]
assert render["finished"][:4] > "2035" and 0 < render["wall_seconds"] < 600, render
PYTHON
echo '+0' >clock
began=$SECONDS
LD_PRELOAD=$preload start budget.log --time 4s -o budget.exr
echo '-1000d' >clock
ends 0 budget.log
[ $((SECONDS - began)) -le 6 ] || fail "a time budget was not kept when the clock jumped"
say "a budget of 4 s took $((SECONDS - began)) s"
say "disks.sh: all is well"
