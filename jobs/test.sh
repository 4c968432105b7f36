#!/usr/bin/env bash
# Installs, builds and runs all tests; the summary of ctest comes last.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

"$root/jobs/install.sh" --tests
say "building into $root/build"
build ON
exec ctest --test-dir "$root/build" -j2 --output-on-failure --timeout 600
