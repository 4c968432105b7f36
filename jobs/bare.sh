#!/usr/bin/env bash
# Makes the Debian packages and runs the program in a bare Debian 12. As root.
# usage: jobs/bare.sh [FOLDER]   (of the bare system; without, debootstrap makes one and it is removed)
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

"$root/jobs/install.sh" --package
say "making the packages in $root/build/package"
(cd "$root" && cmake --workflow --preset package >"$root/build/package.log") ||
  { tail -n 30 "$root/build/package.log" >&2; exit 1; }
given=${1-}
bare=$given
if [ -z "$bare" ]; then
  bare=$(mktemp -d)
  say "making a bare Debian 12 in $bare"
  debootstrap --variant=minbase bookworm "$bare" >"$bare/debootstrap.log" ||
    { tail -n 30 "$bare/debootstrap.log" >&2; exit 1; }
fi
leave() {
  umount "$bare/proc"
  [ -n "$given" ] || rm -rf --one-file-system "$bare"
}
mount -t proc proc "$bare/proc"   # Open MPI needs it
trap leave EXIT
cp "$root"/build/package/stylet_*.deb "$bare/tmp"
say "installing the package and what it depends on"
chroot "$bare" env DEBIAN_FRONTEND=noninteractive apt-get -qq update
chroot "$bare" env DEBIAN_FRONTEND=noninteractive \
  bash -c 'apt-get -qq -o Dpkg::Use-Pty=0 install -y --no-install-recommends --reinstall /tmp/stylet_*.deb' >/dev/null
say "running the reference scene there"
chroot "$bare" bash -c 'cd /tmp && stylet run /usr/share/stylet/input/prostate.yaml --force'
