#!/usr/bin/env bash
# Time to error on the Cornell box, étendue and other renderers interleaved in one run, and étendue's start-up time. For an
# otherwise idle machine; about five minutes. Results go to bench/out/.
#
#   PEERS=../shared/peers   the folder with versus.py, its references and setup.sh, which installs the other renderers
#   PEERS_WORK=…            where that installed them (default ~/.cache/etendue-peers)
#   REPS=5                  images per renderer; medians are shown
#
# Efficiency is relMSE × CPU seconds of the render itself; lower is better. What counts is a ratio within one run.
set -euo pipefail
cd "$(dirname "$0")/.."

peers=${PEERS:-../shared/peers}
python=${PEERS_WORK:-$HOME/.cache/etendue-peers}/venv/bin/python
etendue=${CARGO_TARGET_DIR:-target}/release/etendue
scene=scenes/cornell-box/scene.gltf
[ -x "$etendue" ] || { echo "versus.sh: no $etendue: run make build" >&2; exit 1; }
[ -f "$peers/versus.py" ] || { echo "versus.sh: no versus.py in $peers: set PEERS" >&2; exit 1; }
[ -x "$python" ] || { echo "versus.sh: the other renderers are not installed: run $peers/setup.sh" >&2; exit 1; }
mkdir -p bench/out

ours="$etendue render $scene --filter box --depth 64 --size 256x256 --spp 64 --seed {seed} -o {out} --report {report} --quiet"
"$python" "$peers/versus.py" S1 --peers mi_scalar:64 mi_llvm:64 cycles:64 lux_path:32 \
  --ours "$ours" --ours "$ours --replicates 1" --reps "${REPS:-5}" --json bench/out/S1.json | tee bench/out/S1.txt
echo "ours0 has the default 4 replicates, ours1 has 1: their ratio is what the error bar costs."
bench/startup.py "$etendue" "$scene" | tee bench/out/startup.txt
