#!/usr/bin/env bash
# Installs the Debian 12 packages that Stylet needs; --tests adds those of its tests and mesher,
# --view those of the window, --studies those that statistics of campaigns need, --slurm a cluster for
# tests/slurm, --fuzz the compiler of jobs/fuzz.sh, --package what jobs/bare.sh needs.
# What is already there is left alone, and with everything there no root is needed.
set -euo pipefail

packages=(
  build-essential cmake ninja-build pkg-config
  petsc-dev slepc-dev libopenmpi-dev openmpi-bin libopenblas0-serial libsuitesparse-dev
  libmetis-dev libhdf5-openmpi-dev libyaml-cpp-dev libcli11-dev libudunits2-dev libssl-dev nlohmann-json3-dev
  libpng-dev libturbojpeg0-dev
  python3-numpy python3-h5py python3-matplotlib python3-pil   # pictures of a run
)
window=(libglfw3-dev libepoxy-dev libimgui-dev libegl1 libgl1-mesa-dri fonts-dejavu-core)
case "${1-}" in
  "") ;;
  --tests) packages+=(libgtest-dev libgmock-dev gmsh python3-gmsh python3-openturns
                      "${window[@]}" xvfb xauth xdotool) ;;
  --view) packages+=("${window[@]}") ;;
  --studies) packages+=(python3-openturns) ;;   # Sobol indices
  --slurm) packages+=(slurm-wlm munge) ;;        # for tests/slurm
  --fuzz) packages+=(clang-14 libclang-rt-14-dev libomp-14-dev) ;;   # for jobs/fuzz.sh
  --package) packages+=(dpkg-dev file debootstrap lintian) ;;   # for jobs/bare.sh
  *) echo "install.sh: unknown argument '$1'; allowed: --tests, --view, --studies, --slurm, --fuzz, --package" >&2; exit 2 ;;
esac

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
  echo "install.sh: this is no Debian system; Stylet needs what these packages hold:" >&2
  echo "  ${packages[*]}" >&2
  exit 1
fi
missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)
  [ "$status" = installed ] || missing+=("$package")
done
if [ ${#missing[@]} -eq 0 ]; then
  echo "install.sh: all packages are installed"
  exit 0
fi
if [ "$(id -u)" -ne 0 ]; then
  echo "install.sh: to be installed, as root: apt-get install ${missing[*]}" >&2
  exit 1
fi
echo "install.sh: installing ${#missing[@]} packages and what they need"
export DEBIAN_FRONTEND=noninteractive
options=(-qq -o Acquire::Retries=3 -o Dpkg::Use-Pty=0)
apt-get "${options[@]}" update
log=$(mktemp)
if ! apt-get "${options[@]}" install -y --no-install-recommends "${missing[@]}" >"$log" 2>&1; then
  tail -n 30 "$log" >&2
  echo "install.sh: apt-get failed, see above; all of it is in $log" >&2
  exit 1
fi
rm -f "$log"
