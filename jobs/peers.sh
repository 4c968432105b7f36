#!/usr/bin/env bash
# Runs the same block of tissue in DOLFINx and in Stylet and compares times; table in out/peers.
# usage: jobs/peers.sh [OPTIONS of jobs/peers.py]
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

cd "$root"
[ -x build/stylet ] || { echo "peers.sh: no build/stylet; bash jobs/start.sh builds it" >&2; exit 2; }
if ! /usr/bin/python3 -c "import dolfinx" 2>/dev/null; then
  echo "peers.sh: apt-get install python3-dolfinx, then again" >&2
  exit 2
fi
exec /usr/bin/python3 -B jobs/peers.py build/stylet out/peers "$@"
