#!/usr/bin/env bash
# Time to error on the Cornell box (S1), the landscape (S7), three scenes for bidirectional methods (S2, S4, S6) and ten thousand
# lights (S5), étendue and other renderers interleaved in one run, étendue's ray rates and its start-up time. For an otherwise
# idle machine; about half an hour. Results go to bench/out/.
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

[ -f scenes/ajar-door/scene.gltf ] || scenes/make.py

# ours SCENE SPP [OPTION…]: the command that versus.py runs
ours() {
  echo "$etendue render scenes/$1/scene.gltf --filter box --depth 64 --size 256x256 --spp $2 --seed {seed} -o {out}" \
    "--report {report} --quiet ${*:3}"
}
"$python" "$peers/versus.py" S1 --peers mi_scalar:64 mi_llvm:64 cycles:64 lux_path:32 --reps "${REPS:-5}" \
  --ours "$(ours cornell-box 64)" --ours "$(ours cornell-box 64 --replicates 1)" --ours "$(ours cornell-box 64 --backend obvhs)" \
  --json bench/out/S1.json | tee bench/out/S1.txt
"$python" "$peers/versus.py" S7 --peers mi_scalar:16 mi_llvm:32 --reps "${REPS:-5}" \
  --ours "$(ours landscape 32)" --ours "$(ours landscape 32 --replicates 1)" --ours "$(ours landscape 32 --backend obvhs)" \
  --json bench/out/S7.json | tee bench/out/S7.txt
# Caustics and light through a gap: ours0 is path, ours1 bdpt.
for pair in S2:modified-cornell S4:glass-caustic S6:ajar-door; do
  name=${pair%%:*} scene=${pair#*:}
  "$python" "$peers/versus.py" "$name" --peers mi_llvm:64 lux_bidir:16 --reps "${REPS:-5}" \
    --ours "$(ours "$scene" 64)" --ours "$(ours "$scene" 16 -m bdpt)" --json "bench/out/$name.json" | tee "bench/out/$name.txt"
done
# Ten thousand lights, by the tree and by power, of the meshes of the other renderers.
"$python" bench/peer_scene.py "${PEERS_WORK:-$HOME/.cache/etendue-peers}/scenes/S5" bench/out/S5.glb
many="$etendue render bench/out/S5.glb --filter box --depth 64 --size 256x256 --spp 64 --seed {seed} -o {out} --report {report} --quiet"
"$python" "$peers/versus.py" S5 --peers mi_llvm:64 lux_bidir:16 --reps "${REPS:-5}" \
  --ours "$many" --ours "$many --light-choice power" --json bench/out/S5.json | tee bench/out/S5.txt
echo "On S1 and S7 ours0 has the default 4 replicates, ours1 has 1 (their ratio is what the error bar costs), ours2 traces rays with obvhs."
for name in cornell-box landscape; do
  "$etendue" bench rays "scenes/$name/scene.gltf" --size 256x256 --filter box --threads 1
done | tee bench/out/rays.txt
bench/startup.py "$etendue" scenes/cornell-box/scene.gltf | tee bench/out/startup.txt
