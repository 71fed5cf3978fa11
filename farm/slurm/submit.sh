#!/usr/bin/env bash
# Renders a picture on a Slurm cluster: SHARDS tasks of an array job, and a job that merges their films when all are complete.
#
#   submit.sh SCENE SHARDS OUT.exr [option of `etendue render`]…
#
# Films and logs go to the folder OUT.films, which all nodes must see, and stay there. Run again with the same arguments, it goes
# on with what is there. Prints the numbers of both jobs.
#
#   ETENDUE=path            the binary [default: etendue]
#   ETENDUE_SBATCH="…"      options of sbatch for both jobs, e.g. "--partition=cpu --cpus-per-task=16 --time=4:00:00"
#   ETENDUE_RETRIES=3       how often a shard is tried again after a failure that may pass
set -euo pipefail

die() { printf 'submit.sh: %s\n' "$*" >&2; exit 2; }

[ $# -ge 3 ] || die "usage: submit.sh SCENE SHARDS OUT.exr [option of etendue render]…"
here=$(dirname "$(realpath "$0")")
[ -f "$1" ] || die "there is no scene $1"
[[ $2 =~ ^[1-9][0-9]*$ ]] || die "the number of shards must be 1 or more, not $2"
[[ $3 == *.exr || $3 == *.png ]] || die "the output must be an .exr or .png: $3"
[ -d "$(dirname "$3")" ] || die "there is no folder $(dirname "$3")"
scene=$(realpath "$1") shards=$2 out=$(realpath "$3")
films=${out%.*}.films
shift 3

options=() merge_options=()
while [ $# -gt 0 ]; do
  case $1 in
    -o* | --output* | --film* | --shard* | --passes* | --techniques*) die "$1 is not for shards" ;;
    --time* | --target-error* | --require-target) die "$1 is not for shards, which must know their passes: give --spp" ;;
    --png) merge_options+=("$1") ;;
    --report) merge_options+=("$1" "$(realpath "${2:?"--report wants a path"}")"); shift ;;
    --report=*) merge_options+=(--report "$(realpath "${1#*=}")") ;;
    *) options+=("$1") ;;
  esac
  shift
done
read -ra sbatch_options <<<"${ETENDUE_SBATCH:-}"

# A film goes on with the settings that it was begun with: another picture must not find it.
mkdir -p "$films"
job=$(printf '%q ' "$scene" "$shards" ${options[@]+"${options[@]}"})
if [ -e "$films/job" ] && [ "$(cat "$films/job")" != "$job" ]; then
  die "$films holds another picture: $(cat "$films/job"): remove it, or choose another output"
fi
printf '%s\n' "$job" >"$films/job"
rm -f "$films"/*.tries # they are counted anew

export ETENDUE_SHARDS=$shards
log=${films//%/%%}
array=$(sbatch --parsable ${sbatch_options[@]+"${sbatch_options[@]}"} --array="0-$((shards - 1))" --output="$log/%a.log" \
  "$here/shard.sh" "$scene" "$films" ${options[@]+"${options[@]}"})
array=${array%%;*}
# If a shard fails for good the merge job can never run: it is cancelled then.
merge=$(sbatch --parsable ${sbatch_options[@]+"${sbatch_options[@]}"} --cpus-per-task=1 --dependency="afterok:$array" \
  --kill-on-invalid-dep=yes --output="$log/merge.log" \
  "$here/merge.sh" "$films" "$shards" "$out" ${merge_options[@]+"${merge_options[@]}"})
merge=${merge%%;*}
echo "shards: job $array, merge: job $merge, films and logs: $films"
