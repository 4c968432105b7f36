#!/usr/bin/env bash
# Installs what the window needs, builds and opens it on the reference scene.
# view.sh [SCENE [options of stylet view]]
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

scene=${1:-$root/input/prostate.yaml}
shift || true
if [ -z "${DISPLAY:-}" ] && [[ " $* " != *" --script "* ]]; then
  say "there is no display here (DISPLAY is not set); with --script FILE the window draws pictures without one" >&2
  exit 1
fi
"$root/jobs/install.sh" --view
say "building into $root/build, which takes some minutes the first time"
build OFF -DSTYLET_VIEW=ON
say "opening $scene; afterwards: export PATH=\"$root/build:\$PATH\", and stylet view SCENE"
exec "$root/build/stylet" view "$scene" "$@"
