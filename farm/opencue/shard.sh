#!/usr/bin/env bash
# A frame of the layer "shards": renders shard I of N into FILMS/I-of-N.film, or goes on with that film if it is there.
#
#   shard.sh I N FILMS SCENE [option of `etendue render`]…
#
# étendue takes the place of this shell, so that it gets each signal once and its exit code is the frame's: 33 tells OpenCue to give
# the layer more memory.
set -euo pipefail
[ $# -ge 4 ] || { echo "usage: shard.sh I N FILMS SCENE [option of etendue render]…" >&2; exit 2; }
film=$3/$1-of-$2.film
if [ -e "$film" ]; then exec "${ETENDUE:-etendue}" resume "$film" --scene "$4" --output "$film"; fi
exec "${ETENDUE:-etendue}" render "$4" --shard "$1/$2" --output "$film" "${@:5}"
