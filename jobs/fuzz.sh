#!/usr/bin/env bash
# Builds the fuzz targets (tests/fuzz) with clang under address and undefined-behaviour sanitizers and
# runs a million inputs in all; what they find stays in out/fuzz.
# usage: jobs/fuzz.sh [N [TARGET...]]   (default: 1000000, all targets)
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

total=${1:-1000000}
shift || true
"$root/jobs/install.sh" --fuzz
say "building into $root/build/fuzz"
cmake -S "$root" -B "$root/build/fuzz" -G Ninja -DCMAKE_BUILD_TYPE=None -DSTYLET_FUZZ=ON \
  -DCMAKE_C_COMPILER=clang-14 -DCMAKE_CXX_COMPILER=clang++-14 --log-level=WARNING
targets=("$@")
if [ ${#targets[@]} -eq 0 ]; then
  for source in "$root"/tests/fuzz/*_fuzz.cpp; do targets+=("$(basename "$source" _fuzz.cpp)"); done
fi
ninja -C "$root/build/fuzz" --quiet "${targets[@]/#/fuzz_}"
mkdir -p "$root/out/fuzz"
each=$(((total + ${#targets[@]} - 1) / ${#targets[@]}))
failed=0
for target in "${targets[@]}"; do
  found=$root/out/fuzz/$target   # inputs that reach new code, kept for the next time
  mkdir -p "$found"
  # MPI and PETSc are linked, not started; what they keep until the end is no leak of a reader.
  log=$root/out/fuzz/$target.log
  if ASAN_OPTIONS=detect_leaks=0 "$root/build/fuzz/tests/fuzz/fuzz_$target" -runs="$each" -seed=1 \
      -max_len=4096 -timeout=10 -rss_limit_mb=2048 -artifact_prefix="$found-failure-" \
      "$found" "$root/tests/fuzz/corpus/$target" >"$log" 2>&1; then
    say "$target: $(grep '^Done' "$log")"
  else
    say "$target: FAILED, see $log" >&2
    failed=1
  fi
done
exit $failed
