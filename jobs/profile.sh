#!/usr/bin/env bash
# Counts the instructions of a step's parts on finer and finer meshes: what grows with the mesh and
# what does not. Takes about a minute.
# usage: jobs/profile.sh [OPTIONS of jobs/profile.py]
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

cd "$root"
[ -x build/stylet ] || { echo "profile.sh: no build/stylet; bash jobs/start.sh builds it" >&2; exit 2; }
if ! command -v valgrind >/dev/null; then
  echo "profile.sh: apt-get install valgrind, then again" >&2
  exit 2
fi
exec /usr/bin/python3 -B jobs/profile.py build/stylet out/profile "$@"
