#!/usr/bin/env bash
# Makes the Debian packages and tries them in a bare Debian 12: the reference scene, the manual page, the
# completion, and a program that uses the library. As root.
# usage: jobs/bare.sh [FOLDER]   (of the bare system; without, debootstrap makes one and it is removed)
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

"$root/jobs/install.sh" --package
say "making the packages in $root/build/package"
mkdir -p "$root/build"
rm -f "$root"/build/package/*.deb   # of other versions
(cd "$root" && cmake --workflow --preset package >"$root/build/package.log") ||
  { tail -n 30 "$root/build/package.log" >&2; exit 1; }
say "checking them against Debian's policy"
lintian --allow-root --fail-on error "$root"/build/package/*.deb
given=${1-}
bare=$given
if [ -z "$bare" ]; then
  bare=$(mktemp -d)
  say "making a bare Debian 12 in $bare"
  # From the mirror that this system uses, if it is a Debian 12.
  mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Codename: bookworm' \
    'Component: main' 2>/dev/null | head -n 1)
  debootstrap --variant=minbase bookworm "$bare" ${mirror:+"$mirror"} >"$bare.log" ||
    { tail -n 30 "$bare.log" >&2; exit 1; }
  rm -f "$bare.log"
fi
leave() {
  umount "$bare/proc"
  [ -n "$given" ] || rm -rf --one-file-system "$bare"
}
mount -t proc proc "$bare/proc"   # Open MPI needs it
trap leave EXIT
there() { chroot "$bare" env DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8 bash -c "$1"; }
apt="apt-get -qq -o Dpkg::Use-Pty=0 install -y --no-install-recommends"
fail() { say "$*" >&2; exit 1; }

rm -f "$bare"/tmp/*stylet*.deb
cp "$root"/build/package/*.deb "$bare/tmp"
say "installing stylet and what it depends on"
there "apt-get -qq update && $apt --reinstall /tmp/stylet_*.deb" >"$bare/tmp/apt.log" 2>&1 ||
  { tail -n 30 "$bare/tmp/apt.log" >&2; exit 1; }
say "running the reference scene there"
there "cd /tmp && stylet run /usr/share/stylet/input/prostate.yaml --force" | tee "$bare/tmp/run.log"
# The number with its band of the README, which the stored study beside the scene gives.
wanted=$(grep '^placement error' "$root/README.md")
grep -qF "$wanted" "$bare/tmp/run.log" || fail "the README says: $wanted"

say "manual page and completion"
there "$apt man-db bash-completion" >"$bare/tmp/apt.log" 2>&1 || { tail -n 30 "$bare/tmp/apt.log" >&2; exit 1; }
there "man stylet | grep -q -e --mesh-levels" || fail "no manual page"
there ". /usr/share/bash-completion/bash_completion; _completion_loader stylet
  COMP_WORDS=(stylet converge --mesh); COMP_CWORD=2; _stylet; echo \${COMPREPLY[@]}" |
  grep -qx -e --mesh-levels || fail "no completion"

say "building a program that uses the library"
there "$apt --reinstall /tmp/libstylet-dev_*.deb && $apt cmake make g++" >"$bare/tmp/apt.log" 2>&1 ||
  { tail -n 30 "$bare/tmp/apt.log" >&2; exit 1; }
rm -rf "$bare/tmp/example"
cp -r "$root/tests/library/examples" "$bare/tmp/example"
there "cd /tmp/example && cmake -B build -DCMAKE_BUILD_TYPE=Release && cmake --build build" \
  >"$bare/tmp/example.log" 2>&1 || { tail -n 30 "$bare/tmp/example.log" >&2; exit 1; }
there "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 /tmp/example/build/insertion"
say "all is well"
