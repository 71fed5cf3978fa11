#!/usr/bin/env bash
# The example pages in docs/reports/: error against time of all methods with all backends, and rays per second. For an otherwise
# idle machine; about twenty minutes. JSON, CSV and references stay in bench/out/reports/.
#
#   BUDGET=20s             for each curve, all its repetitions together
#   REFERENCE_BUDGET=300s  for each reference at most; one that is cut short shows as a warning, and its page is not worth keeping
set -euo pipefail
cd "$(dirname "$0")/.."

etendue=${ETENDUE:-${CARGO_TARGET_DIR:-target}/release/etendue}
[ -x "$etendue" ] || { echo "reports.sh: no $etendue: run make build" >&2; exit 1; }
mkdir -p docs/reports bench/out/reports

# page NAME SCENE… [-- OPTION…]: docs/reports/NAME.html
page() {
  local name=$1 scenes=()
  shift
  while [ $# -gt 0 ] && [ "$1" != -- ]; do scenes+=("scenes/$1/scene.gltf"); shift; done
  [ $# = 0 ] || shift
  local reference=(--reference-budget "${REFERENCE_BUDGET:-300s}")
  case " $* " in *" --reference "*) reference=() ;; esac
  "$etendue" bench methods "${scenes[@]}" --budget "${BUDGET:-20s}" "${reference[@]}" "$@" -o "bench/out/reports/$name"
  cp "bench/out/reports/$name/index.html" "docs/reports/$name.html"
}
# with_reference SCENE SPP [OPTION…]: the same with a long render of another seed for a reference: where small lamps have edges, a noisy
# one divides by almost nothing.
with_reference() {
  local image=bench/out/reports/$1-80.exr
  "$etendue" render "scenes/$1/scene.gltf" --size 80x80 --filter box --depth 64 --spp "$2" --seed 77 --quiet -o "$image"
  page "$1" "$1" -- --size 80x80 --filter box --depth 64 --reference "$image" "${@:3}"
}
with_reference cornell-box 8192
with_reference veach-mis 4096
page modified-cornell modified-cornell -- --methods path,bdpt --backends embree --reference scenes/modified-cornell/reference.exr
# with_chains SCENE: samples do not find the light of these in any time for a reference, so that chains make it; what they agree with bdpt in is
# tested (tests/agreement/chains.rs).
with_chains() {
  local image=bench/out/reports/$1-128.exr
  "$etendue" render "scenes/$1/scene.gltf" --no-config -m mlt --size 128x128 --filter box --depth 64 --time 120s --seed 77 --quiet -o "$image"
  page "$1" "$1" -- --size 128x128 --filter box --depth 64 --methods bdpt,mmlt,mlt --backends embree --reference "$image"
}
BUDGET=${BUDGET:-25s} with_chains door-2cm
BUDGET=${BUDGET:-25s} with_chains caustic-pool
for scene in many-lights street hall; do
  BUDGET=${BUDGET:-12s} with_reference "$scene" 8192 --methods path,bdpt,vpl,lightcuts --backends embree
done
BUDGET=${BUDGET:-20s} with_reference foggy-box 4096 --methods path,bdpt,mmlt,mlt --backends embree
BUDGET=${BUDGET:-7s} page spheres sphere-lamp sphere-cap -- --size 48x48

"$etendue" bench rays scenes/{cornell-box,modified-cornell,landscape}/scene.gltf --size 256x256 --filter box --depth 64 \
  --builds fast,robust,compact,high --threads 1,2 --rounds 7 -o bench/out/rays
cp bench/out/rays/index.html docs/reports/rays.html
"$etendue" bench rays --hard-cases --rays-per-case 2000000 -o bench/out/hard
cp bench/out/hard/index.html docs/reports/hard-cases.html
