#!/usr/bin/env bash
# Meshes the contour of a real prostate and runs input/patient.yaml in it.
# patient.sh [CONTOUR.csv [options of stylet run]]; the contour is not part of the source tree.
# STYLET names the program if it is not build/stylet. Exit code 77: the contour or the mesher is missing.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

contour=${1:-$root/../shared/data/prostate-0464-sagittal.csv}
shift || true
program=${STYLET:-$root/build/stylet}
if [ ! -r "$contour" ]; then
  say "$contour: cannot be read; name another contour, with the header x_m,y_m" >&2
  exit 77
fi
if [ ! -x "$program" ]; then
  say "$program is not built yet: bash jobs/start.sh" >&2
  exit 1
fi
if ! /usr/bin/python3 -c 'import gmsh' 2>/dev/null; then
  say "the mesher is missing: apt-get install python3-gmsh" >&2
  exit 77
fi
# A tumour of 16 x 12 mm in the lower half; 20 mm of tissue around the gland.
mkdir -p "$root/out"
/usr/bin/python3 "$root/jobs/contour_mesh.py" "$contour" "$root/out/patient.msh" --force \
  --size 0.003 --margin 0.02 --tumour 0.012 -0.008 0.016 0.012
"$program" run "$root/input/patient.yaml" "$@"
