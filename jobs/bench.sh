#!/usr/bin/env bash
# Times steps of the reference scene on finer and finer meshes; table and picture in out/bench.
# usage: jobs/bench.sh [OPTIONS of jobs/bench.py]   (default: 1 and 2 ranks, to 313,856 triangles)
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

cd "$root"
[ -x build/stylet ] || { echo "bench.sh: no build/stylet; bash jobs/start.sh builds it" >&2; exit 2; }
options=("$@")
[ ${#options[@]} -gt 0 ] || options=(--ranks 1 2 --finest 4)
exec /usr/bin/python3 -B jobs/bench.py build/stylet out/bench "${options[@]}"
