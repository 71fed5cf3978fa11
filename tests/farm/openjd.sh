#!/usr/bin/env bash
# The Open Job Description template farm/openjd/etendue.yaml, checked and run with openjd-cli: shards merge to the pixels of a single
# run, for one frame and for two; a task that is cancelled saves its film and goes on with it; a broken scene fails with a message.
#
#   ETENDUE=path   the binary [default: target/release/etendue]
#   OPENJD=path    openjd of openjd-cli [default: that on the PATH, else it is installed from PyPI into a temporary venv]
#   KEEP=1         keep the folder with all logs
set -euo pipefail
cd "$(dirname "$0")/../.."

etendue=$(realpath "${ETENDUE:-target/release/etendue}")
scenes=$PWD/scenes/cornell-box template=farm/openjd/etendue.yaml
say() { printf '[%3d s] %s\n' "$SECONDS" "$*"; }
fail() { printf 'FAILED: %s\n' "$*" >&2; exit 1; }
[ -x "$etendue" ] || fail "there is no $etendue: make build, or set ETENDUE"

dir=$(mktemp -d "${TMPDIR:-/tmp}/etendue-openjd.XXXXXX")
running=''
finish() {
  local code=$? log
  trap - EXIT INT TERM
  set +e
  [ -z "$running" ] || kill -TERM "$running" 2>/dev/null
  if [ "$code" != 0 ]; then for log in "$dir"/*.log; do echo "--- $log"; tail -n 40 "$log"; done; fi
  if [ -n "${KEEP:-}" ]; then echo "kept: $dir"; else rm -rf "$dir"; fi
  exit "$code"
}
trap finish EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

openjd=${OPENJD:-$(command -v openjd || true)}
if [ -z "$openjd" ]; then
  python3 -m venv "$dir/venv" || fail "no venv: python3-venv is missing"
  "$dir/venv/bin/pip" install --quiet 'openjd-cli>=0.8,<1' || fail "openjd-cli cannot be installed from PyPI"
  openjd=$dir/venv/bin/openjd
fi
"$openjd" check "$template" >"$dir/check.log" 2>&1 || fail "the template is not valid"
say "the template is valid ($("$openjd" --version 2>&1 | tail -n 1))"

hash_of() { python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))["pixel_hash"])' "$1"; }
single() { # NAME OPTIONS
  # shellcheck disable=SC2086
  nice "$etendue" render "$scenes/scene.gltf" $2 --quiet --output "$dir/single-$1.exr" --report "$dir/single-$1.json" >/dev/null
}
parameters() { # NAME SHARDS OPTIONS SCENE
  printf '%s\n' -p "Etendue=$etendue" -p "Scene=$4" -p "Output=$dir/$1.exr" -p "Shards=$2" -p "Options=$3" -p "MergeOptions=--report $dir/$1.json"
}
same() { # NAME SINGLE
  [ "$(hash_of "$dir/$1.json")" = "$(hash_of "$dir/single-$2.json")" ] || fail "$1: other pixels than in a single run"
  say "$1: $(hash_of "$dir/$1.json"), as in a single run"
}

# --- all shards and the merge, by method --------------------------------------------------------------------------
for method in path bdpt mlt; do
  options="--size 64x64 --spp 64 -m $method"
  single "$method" "$options"
  mapfile -t p < <(parameters "$method" 5 "$options" "$scenes/scene.gltf")
  "$openjd" run "$template" --step Merge --run-dependencies "${p[@]}" >"$dir/$method.log" 2>&1 || fail "openjd run"
  same "$method" "$method"
done

# --- one step after the other, one task at a time, two frames ------------------------------------------------------
for frame in 0007 0008; do
  cp "$scenes/scene.gltf" "$dir/frame $frame.gltf"
  cp "$scenes"/*.bin "$scenes/render.toml" "$dir/"
done
# shellcheck disable=SC2016
mapfile -t p < <(parameters 'shot $HOME ####' 2 "--size 64x64 --spp 64 -m path" "$dir/frame ####.gltf")
p=("${p[@]/MergeOptions=*/MergeOptions=--report $dir/shot####.json}" -p Frames=7-8)
"$openjd" run "$template" --step Render --no-run-dependencies --tasks '[{"Frame": 7, "Shard": 1}]' "${p[@]}" >"$dir/task.log" 2>&1 || fail "one task"
[ "$(find "$dir/shot \$HOME 0007.films" -name '*.film')" = "$dir/shot \$HOME 0007.films/0-of-2.film" ] || fail "not the film of one task"
"$openjd" run "$template" --step Render --no-run-dependencies "${p[@]}" >"$dir/render.log" 2>&1 || fail "step Render"
[ "$(grep -c 'complete already' "$dir/render.log")" -ge 1 ] || fail "a complete shard was rendered again"
"$openjd" run "$template" --step Merge --no-run-dependencies "${p[@]}" >"$dir/merge.log" 2>&1 || fail "step Merge"
same shot0007 path
same shot0008 path

# --- cancelled in the middle --------------------------------------------------------------------------------------
options="--size 64x64 --spp 2048 -m path"
mapfile -t p < <(parameters cancelled 2 "$options" "$scenes/scene.gltf")
"$openjd" run "$template" --step Merge --run-dependencies "${p[@]}" >"$dir/cancelled.log" 2>&1 &
running=$!
for _ in {1..150}; do grep -qs 'etendue: rendering' "$dir/cancelled.log" && break; sleep 0.2; done
sleep 1
kill -TERM "$running"
if wait "$running"; then fail "a cancelled job succeeded"; fi
running=''
grep -q 'stopped by a signal after' "$dir/cancelled.log" || fail "étendue was not told of the cancellation"
[ -f "$dir/cancelled.films/0-of-2.part.film" ] || fail "no film was saved"
"$openjd" run "$template" --step Merge --run-dependencies "${p[@]}" >"$dir/resumed.log" 2>&1 || fail "the job after a cancellation"
grep -q 'samples per pixel so far' "$dir/resumed.log" || fail "the film was not gone on with"
single long "$options"
same cancelled long

# --- failures -----------------------------------------------------------------------------------------------------
echo '{"asset": 1' >"$dir/broken.gltf"
mapfile -t p < <(parameters broken 2 "--size 8x8" "$dir/broken.gltf")
if "$openjd" run "$template" --step Merge --run-dependencies "${p[@]}" >"$dir/broken.log" 2>&1; then fail "a broken scene succeeded"; fi
grep -q 'openjd_fail: the scene is invalid' "$dir/broken.log" || fail "no message about a broken scene"
mapfile -t p < <(parameters path 5 "--size 8x8" "$scenes/scene.gltf") # path.films is there from above
if "$openjd" run "$template" --step Render --no-run-dependencies "${p[@]}" >"$dir/other.log" 2>&1; then fail "films of another picture were taken"; fi
grep -q 'openjd_fail: .* holds another picture' "$dir/other.log" || fail "no message about another picture"
say "openjd.sh: all is well"
