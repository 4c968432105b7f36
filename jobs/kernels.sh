#!/usr/bin/env bash
# Times the parts of a step on meshes of 1e3 to 1e6 triangles, with Google Benchmark.
# usage: jobs/kernels.sh [OPTIONS of the benchmark, such as --benchmark_filter=edit]
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

cd "$root"
if ! dpkg-query -W libbenchmark-dev >/dev/null 2>&1; then
  echo "kernels.sh: apt-get install libbenchmark-dev, then again" >&2
  exit 2
fi
cmake -S . -B build -G Ninja >/dev/null
ninja -C build kernels >/dev/null
exec build/tests/bench/kernels "$@"
