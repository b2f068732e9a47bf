#!/usr/bin/env bash
# Fetches and builds the VM bench: Debian's PREEMPT_RT kernel, the kernel's test drivers that Debian leaves
# out, and a first file system; for another machine than this one also the file tree that our programs run in. Nothing is
# installed; all of it lies in build/vm/ARCH. Does nothing when that is there.
#
#   tests/vm/setup.sh [amd64 | arm64]     another kernel than the one that is there: rm -r build/vm/ARCH first
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../../tools/lib.sh"
source "$root/tools/own_apt.sh"
source "$root/tests/vm/kernel.sh"

arch=${1:-amd64}
triplet='' tools=() # for another machine than this one
case $arch in
  amd64) kernel_arch=x86 ;;
  arm64) kernel_arch=arm64 triplet=aarch64-linux-gnu ;;
  *) die "$arch: amd64 or arm64" ;;
esac
if [[ -n $triplet ]]; then # tools of the sub-tests, and the libraries of our programs
  tools=(bash dash coreutils grep sed mawk findutils util-linux mount hostname procps kmod iproute2 can-utils busybox-static
    libstdc++6 zlib1g liblz4-1 libzstd1 libdeflate0 libpng16-16 libfmt9 libcamera0.0.3 libcamera-ipa
    libturbojpeg0 libmujoco2.2.2 libegl1 libegl-mesa0 libgl1-mesa-dri)
fi
here=$root/tests/vm
vm=$root/build/vm/$arch
work=$vm.new
log=$logs/vm-$arch-setup.log

download() {
  local image headers release version
  image=$(depends "$(kernel_package "$arch")" '^linux-image-')
  headers=$(depends "linux-headers-rt-$arch" '^linux-headers-')
  [[ -n $image && -n $headers ]] || return 1
  release=${image#linux-image-}
  version=$(cut -d. -f1,2 <<<"$release")
  local packages=("$image" "$headers" "linux-source-$version") kbuild
  mapfile -O 3 -t packages < <(depends "$headers" '^linux-headers-')
  kbuild=$(depends "$headers" '^linux-kbuild-')
  mkdir -p "$work/debs"
  # The programs of linux-kbuild build the modules: they are this machine's, whatever the kernel is.
  (cd "$work/debs" && apt-get download -q "${packages[@]}" && unset APT_CONFIG && apt-get download -q "$kbuild")
}

# The lists of a fresh or an old system may be missing or stale.
fetch() {
  if [[ -n $triplet ]]; then
    own_apt "$work/apt" "$arch" "$(main_suite)"
    export APT_CONFIG=$work/apt/apt.conf
    apt-get update -q --error-on=any
    download
    apt-get install -y -q --download-only "${tools[@]}"
    return
  fi
  download && return
  local as_root=()
  ((EUID == 0)) || as_root=(sudo)
  "${as_root[@]}" apt-get update -q && download
}

unpack() {
  local deb
  for deb in "$work"/debs/linux-image-*.deb; do dpkg-deb -x "$deb" "$work/kernel"; done
  for deb in "$work"/debs/linux-{headers,kbuild}-*.deb; do dpkg-deb -x "$deb" "$work/headers"; done
  for deb in "$work"/debs/linux-source-*.deb; do dpkg-deb -x "$deb" "$work/source"; done
  rm -r "$work/debs"
  local tree name
  tree=$(echo "$work"/source/usr/src/linux-source-*.tar.xz)
  name=$(basename "$tree" .tar.xz)
  tar -C "$work/source" --strip-components=1 -I "xz -dT$jobs" -xf "$tree" \
    "$name/drivers/iio" "$name/drivers/media/test-drivers/vimc" "$name/drivers/i2c/i2c-stub.c"
  rm -r "$work/source/usr"
}

# The file tree of another machine's guest, with /lib inside of /usr as on a running system.
unpack_tree() {
  local tree=$1 deb folder
  mkdir -p "$tree"/usr/{bin,sbin,lib,lib64} "$tree"/{etc,root,tmp,run,dev,proc,sys,mnt}
  for folder in bin sbin lib lib64; do ln -s "usr/$folder" "$tree/$folder"; done
  for deb in "$work"/apt/archives/*.deb; do
    dpkg-deb --fsys-tarfile "$deb" | tar -x -C "$tree" --no-same-owner --keep-directory-symlink \
      --exclude=./usr/share/{doc,man,locale,info,lintian,bash-completion}
  done
  ln -sf mawk "$tree/usr/bin/awk"
  rm -r "$work/apt"
}

# vimc: a camera with the parts of a phone's, for libcamera. iio_dummy and the triggers: a sensor whose buffer is filled
# at a rate of our choice. i2c-stub: chips that only have registers; Debian has it on amd64 only.
build_modules() {
  local build=$work/modules from=$work/source/drivers headers
  mkdir -p "$build/vimc"
  cp "$from"/iio/industrialio-{configfs,sw-device,sw-trigger}.c "$from"/iio/trigger/iio-trig-hrtimer.c \
    "$from"/iio/dummy/iio_simple_dummy{.c,.h,_buffer.c} "$build/"
  cp "$from"/media/test-drivers/vimc/*.[ch] "$build/vimc/"
  cp "$from/i2c/i2c-stub.c" "$build/"
  cat >"$build/Kbuild" <<'KBUILD'
ccflags-y += -DCONFIG_IIO_SIMPLE_DUMMY_BUFFER=1
obj-m += industrialio-configfs.o industrialio-sw-device.o industrialio-sw-trigger.o iio-trig-hrtimer.o iio_dummy.o vimc/
iio_dummy-y := iio_simple_dummy.o iio_simple_dummy_buffer.o
KBUILD
  [[ -z $triplet ]] || echo 'obj-m += i2c-stub.o' >>"$build/Kbuild"
  cat >"$build/vimc/Kbuild" <<'KBUILD'
vimc-y := vimc-core.o vimc-common.o vimc-streamer.o vimc-capture.o vimc-debayer.o vimc-scaler.o vimc-sensor.o vimc-lens.o
obj-m += vimc.o
KBUILD
  headers=$(echo "$work"/headers/usr/src/linux-headers-*-rt-"$arch")
  sed -i "s|^include /usr/src|include $work/headers/usr/src|" "$headers/Makefile" # it expects to be installed
  make -s -C "$headers" M="$build" ARCH=$kernel_arch ${triplet:+CROSS_COMPILE=$triplet-} KBUILD_MODPOST_WARN=1 -j "$jobs" modules
}

install_modules() {
  local release
  release=$(basename "$work"/kernel/lib/modules/*)
  mkdir -p "$work/kernel/lib/modules/$release/extra"
  find "$work/modules" -name '*.ko' -exec cp -t "$work/kernel/lib/modules/$release/extra" {} +
  "${triplet:+$triplet-}strip" -g "$work/kernel/lib/modules/$release/extra"/*.ko
  depmod -b "$work/kernel" "$release"
}

# The modules of the shared folders come first, and guest/init.
pack() {
  local busybox
  busybox=$(command -v busybox)
  [[ -z $triplet ]] || busybox=$1/tree/usr/bin/busybox
  first_file_system "$1" "$busybox" "$here/guest/init" virtio_pci 9pnet_virtio 9p overlay
}

make_kernel() {
  rm -rf "$work" "$vm"
  fetch
  unpack
  build_modules
  install_modules
  [[ -z $triplet ]] || unpack_tree "$work/kernel/tree"
  pack "$work/kernel"
  mv "$work/kernel" "$vm"
  rm -r "$work"
}

mkdir -p "$logs" "$root/build/vm"
exec {lock}>"$root/build/vm/$arch.lock"
flock "$lock" # another boot may be making it
todo=
if [[ ! -f $vm/initramfs.gz || $here/setup.sh -nt $vm/initramfs.gz ]]; then
  todo=make_kernel
elif [[ $here/guest/init -nt $vm/initramfs.gz ]]; then
  todo=pack
fi
[[ -n $todo ]] || exit 0

start=$(now_s)
export PATH=$PATH:/usr/sbin:/sbin # kmod's, for those who are not root
[[ -z $triplet ]] || command -v "$triplet-gcc" >/dev/null || die "$triplet-gcc is missing: it builds the modules of $arch"
set +e # in a shell of its own, which ends at the first failed command
(
  set -e
  "$todo" "$vm"
) >"$log" 2>&1
status=$?
set -e
if ((status != 0)); then
  tail -n 30 "$log" >&2
  die "no kernel to boot (log: ${log#"$root"/})"
fi
say "vm: $arch set up in $(minutes $(($(now_s) - start)))"
