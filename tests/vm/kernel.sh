# shellcheck shell=bash
# Debian's kernels in qemu, shared by tests/vm and tests/boards: `source` it after lib.sh.

# kernel_package ARCH: the package that names Debian's newest kernel for it, with PREEMPT_RT where there is one.
kernel_package() {
  case $1 in
    amd64 | arm64) say "linux-image-rt-$1" ;;
    armhf) say linux-image-rt-armmp ;;
    mipsel) say linux-image-4kc-malta ;;
    *) return 1 ;;
  esac
}

# depends PACKAGE PATTERN: its dependencies that match PATTERN. The kernel's packages carry their version in
# their names, so no name is written here.
depends() { apt-cache depends "$1" | awk -v pattern="$2" '$1 == "Depends:" && $2 ~ pattern { print $2 }'; }

# machine_of ARCH: sets `machine` to the emulator's command, `port` to the kernel's name of the serial line.
# shellcheck disable=SC2034  # `port` is for the scripts that source this
machine_of() {
  case $1 in
    # Without features that TCG is slow at and no test is about: page tables of five levels, guards of the kernel's own memory.
    amd64) machine=(qemu-system-x86_64 -M q35 -cpu "max,-la57,-smap,-smep") port=ttyS0 ;;
    # As on a board of today, with atomic instructions (Armv8.2): a lock costs one where a loop of the first Armv8 takes five.
    arm64) machine=(qemu-system-aarch64 -M virt -cpu cortex-a76) port=ttyAMA0 ;;
    # With its PCI window above 4 GB the kernel would find no device.
    armhf) machine=(qemu-system-arm -M "virt,highmem=off" -cpu cortex-a15) port=ttyAMA0 ;;
    mipsel) machine=(qemu-system-mipsel -M malta -cpu 24Kf) port=ttyS0 ;;
    *) die "$1: no machine is described for it" ;;
  esac
  command -v "${machine[0]}" >/dev/null || die "${machine[0]} is missing: tools/packages.txt has its package"
  machine+=(-nodefaults -no-reboot -display none -monitor none)
}

# share NAME FOLDER [OPTION]: adds that folder of the host to `machine`. Without readonly=on the guest may write to it.
share() {
  machine+=(-fsdev "local,id=$1,path=$2,security_model=none,multidevs=remap${3:+,$3}"
    -device "virtio-9p-pci,fsdev=$1,mount_tag=$1")
}

# first_file_system KERNEL BUSYBOX INIT MODULE...: files that KERNEL (its unpacked package) needs before the host's files,
# as KERNEL/initramfs.gz: busybox, those modules with what they need, listed in modules/order, and INIT.
first_file_system() {
  local kernel=$1 busybox=$2 init=$3 tree=$1/initramfs release module
  shift 3
  release=$(basename "$kernel"/lib/modules/*)
  rm -rf "$tree"
  mkdir -p "$tree"/{bin,proc,sys,dev,host,layer,root,modules}
  cp "$busybox" "$tree/bin/busybox"
  cp "$init" "$tree/init"
  chmod 755 "$tree/init"
  for module in "$@"; do
    modprobe -d "$kernel" -S "$release" --show-depends "$module" | awk '$1 == "insmod" { print $2 }'
  done | awk '!seen[$0]++' | while read -r module; do
    cp "$module" "$tree/modules/"
    basename "$module" >>"$tree/modules/order"
  done
  (cd "$tree" && find . | cpio -o -H newc --quiet -R 0:0 | gzip -1) >"$kernel/initramfs.gz.new"
  mv "$kernel/initramfs.gz.new" "$kernel/initramfs.gz" # complete or missing: its age decides whether it is made again
  rm -r "$tree"
}
