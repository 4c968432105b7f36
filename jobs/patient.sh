#!/usr/bin/env bash
# Meshes a real prostate and runs a scene in it: input/patient.yaml in a contour, input/patient3d.yaml in
# a surface. patient.sh [CONTOUR.csv or SURFACE.stl [options of stylet run]]; neither is part of the source
# tree. STYLET names the program if it is not build/stylet. Exit code 77: the file or the mesher is missing.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

outline=${1:-$root/../shared/data/prostate-0464-sagittal.csv}
shift || true
program=${STYLET:-$root/build/stylet}
if [ ! -r "$outline" ]; then
  say "$outline: cannot be read; name a contour with the header x_m,y_m (.csv), or a surface in mm (.stl)" >&2
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
mkdir -p "$root/out"
case "$outline" in
  *.[sS][tT][lL])
    # x points to the apex (inferior), y to anterior, z to the patient's right; 20 mm of tissue all round.
    scene=patient3d
    make=(surface_mesh.py --unit mm --axes IAR --centre --size 0.004 --outer-size 0.010 --margin 0.02) ;;
  *)
    # A tumour of 16 x 12 mm in the lower half; 20 mm of tissue around the gland.
    scene=patient
    make=(contour_mesh.py --size 0.003 --margin 0.02 --tumour 0.012 -0.008 0.016 0.012) ;;
esac
/usr/bin/python3 "$root/jobs/${make[0]}" "$outline" "$root/out/$scene.msh" --force "${make[@]:1}"
"$program" run "$root/input/$scene.yaml" "$@"
