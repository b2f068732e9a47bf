#!/usr/bin/env bash
# Fetches a board for tests/boards: Debian's kernel for it, and busybox, packed with init as its first file system.
# Nothing is installed and nothing compiled; it lies in build/boards/BOARD. Does nothing when that is there.
#
#   tests/boards/setup.sh arm64 | armhf | mipsel     a newer kernel than the one that is there: rm -r build/boards/BOARD first
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../../tools/lib.sh"
source "$root/tools/own_apt.sh"
source "$root/tests/vm/kernel.sh"

board=${1:?arm64, armhf or mipsel}
[[ $board == arm64 || $board == armhf || $board == mipsel ]] || die "$board: arm64, armhf or mipsel"
here=$root/tests/boards
kernel=$root/build/boards/$board
work=$kernel.new
log=$logs/boards-$board-setup.log

# Shared folders, and the network.
pack() { first_file_system "$1" "$1/busybox" "$here/init" virtio_pci 9pnet_virtio 9p virtio_net; }

make_kernel() {
  local image
  rm -rf "$work" "$kernel"
  mkdir -p "$work/debs" "$work/kernel" "$work/busybox"
  own_apt "$work/apt" "$board" "$(main_suite)"
  export APT_CONFIG=$work/apt/apt.conf
  apt-get update -q --error-on=any
  image=$(depends "$(kernel_package "$board")" '^linux-image-')
  (cd "$work/debs" && apt-get download -q "$image" busybox-static)
  dpkg-deb -x "$work"/debs/linux-image-*.deb "$work/kernel"
  dpkg-deb -x "$work"/debs/busybox-static_*.deb "$work/busybox"
  mv "$work/busybox/bin/busybox" "$work/kernel/busybox"
  depmod -b "$work/kernel" "$(basename "$work"/kernel/lib/modules/*)"
  pack "$work/kernel"
  mv "$work/kernel" "$kernel"
  rm -r "$work"
}

mkdir -p "$logs" "$root/build/boards"
exec {lock}>"$root/build/boards/$board.lock"
flock "$lock" # another boot may be making it
todo=
if [[ ! -f $kernel/initramfs.gz || $here/setup.sh -nt $kernel/initramfs.gz ]]; then
  todo=make_kernel
elif [[ $here/init -nt $kernel/initramfs.gz ]]; then
  todo=pack
fi
[[ -n $todo ]] || exit 0

start=$(now_s)
export PATH=$PATH:/usr/sbin:/sbin # kmod's, for those who are not root
set +e                            # in a shell of its own, which ends at the first failed command
(
  set -e
  "$todo" "$kernel"
) >"$log" 2>&1
status=$?
set -e
if ((status != 0)); then
  tail -n 30 "$log" >&2
  die "no kernel to boot (log: ${log#"$root"/})"
fi
say "boards: $board set up in $(minutes $(($(now_s) - start)))" >&2
