#!/usr/bin/env bash
# Installs, builds, runs the reference scene on two ranks and makes pictures of it.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

"$root/jobs/install.sh"
say "building into $root/build"
build OFF
cd "$root"
say "running input/prostate.yaml on 2 ranks"
on_ranks 2 build/stylet run input/prostate.yaml --output out/prostate --force
say "drawing every fourth snapshot"
/usr/bin/python3 jobs/frames.py out/prostate --every 4
say "done; look at $root/out/prostate"
