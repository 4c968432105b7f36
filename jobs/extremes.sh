#!/usr/bin/env bash
# Runs the long version of the extremes matrix (tests/extremes): every case with its outcome, and how
# many there are of each. `extremes.sh --only TEXT` runs the cases whose name has TEXT.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

"$root/jobs/install.sh" --tests
build ON
exec "$root/build/tests/extremes/extremes" --long "$@"
