#!/usr/bin/env bash
# farm/opencue: syntax only. Nothing here has met an OpenCue.
set -euo pipefail
cd "$(dirname "$0")/../.."
python3 -c 'import ast, sys; ast.parse(open(sys.argv[1], encoding="utf-8").read(), sys.argv[1])' farm/opencue/etendue_outline.py
bash -n farm/opencue/shard.sh
echo "opencue.sh: the syntax is right"
