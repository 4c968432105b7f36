# Read by the other scripts: where the source tree is, and how MPI runs here.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
job=$(basename "$0")

say() { echo "$job: $*"; }

[ -d /proc/self ] || { say "/proc is not mounted; Open MPI needs it" >&2; exit 1; }
[ -d /sys/devices/system/cpu ] || say "no /sys: Open MPI will say that it cannot see the processors; it runs all the same" >&2
[ -w /dev/shm ] || say "no writable /dev/shm: ranks will exchange data through files in ${TMPDIR:-/tmp}" >&2

export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1   # one thread a rank
# Containers forbid one process to read another's memory, which Open MPI tries first.
export OMPI_MCA_btl_vader_single_copy_mechanism=none
if [ "$(id -u)" -eq 0 ]; then
  export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
fi

# build TESTS [OPTIONS]: configures and builds into build/, with tests (ON) or without (OFF). Warnings of another
# compiler must not keep a user from the program: they are errors where the environment asks for it.
build() {
  cmake -S "$root" -B "$root/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DBUILD_TESTING="$1" "${@:2}" \
    -DCMAKE_COMPILE_WARNING_AS_ERROR="${STYLET_WARNINGS_ARE_ERRORS:-OFF}" --log-level=WARNING
  ninja -C "$root/build" --quiet
}

# on_ranks N PROGRAM...: mpirun, also where there are fewer processors than ranks.
on_ranks() {
  local options=()
  [ "$(nproc)" -ge "$1" ] || options=(--oversubscribe)
  mpirun "${options[@]}" -n "$@"
}
