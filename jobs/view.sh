#!/usr/bin/env bash
# Installs what the window needs, builds and opens it on the reference scene.
# view.sh [SCENE [options of stylet view]]
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

scene=${1:-$root/input/prostate.yaml}
shift || true
"$root/jobs/install.sh" --view
say "building into $root/build"
build OFF -DSTYLET_VIEW=ON
if [ -z "${DISPLAY:-}" ] && [[ " $* " != *" --script "* ]]; then
  say "there is no display here (DISPLAY is not set); with --script FILE the window draws pictures without one" >&2
  exit 1
fi
exec "$root/build/stylet" view "$scene" "$@"
