#!/usr/bin/env bash
# Makes the file tree of a board to compile and link against, from Debian packages, without installing anything: unpacks
# the groups `sysroot` and `sysroot-ARCH` of tools/packages.txt for another machine. Returns at once if the tree exists.
#
#   toolchains/sysroot.sh ARCH...      armhf, arm64 or mipsel
#   toolchains/sysroot.sh i386         a tree to chroot to for 32-bit Windows programs (group wine32): see wine32.sh
#   toolchains/sysroot.sh i386-gl      32-bit OpenGL and Vulkan (group grab32) for programs that `sinew grab` starts
#
# The tree is in build/sysroot/ARCH, or in $SINEW_SYSROOTS/ARCH, which several clones may share; its file `packages`
# lists the packages and their versions. To take newer versions: rm -r that folder first.
# SINEW_SYSROOT_SOURCE="deb http://HOST/debian SUITE main" names another package source than this system's.
# Exit: 0 all there, 1 not made (says why), 2 wrong call.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../tools/lib.sh"
source "$root/tools/own_apt.sh"

home=${SINEW_SYSROOTS:-$root/build/sysroot}

# wanted_of ARCH: the packages of its groups, one a line.
wanted_of() {
  local group=sysroot
  [[ $1 != i386 ]] || group=wine32
  [[ $1 != i386-gl ]] || group=grab32
  awk -v group="$group" -v own="$group-$1" '$1 == group || $1 == own { print $2 }' "$root/tools/packages.txt"
}

# record DEB NAMES DATABASE: writes the part of dpkg's database that dpkg-shlibdeps and `dpkg -S` read: by it our
# packages that are built with this tree name the packages that they need.
record() {
  local control=$3/control name file
  dpkg-deb -e "$1" "$control"
  name=$(sed -n 's/^Package: //p' "$control/control")
  ! grep -qx 'Multi-Arch: same' "$control/control" || name+=:$(sed -n 's/^Architecture: //p' "$control/control")
  { sed '/^Package: /a Status: install ok installed' "$control/control" && echo; } >>"$3/status"
  sed -n 's|^\.\(/.*[^/]\)/*$|\1|p' "$2" >"$3/info/$name.list"
  for file in symbols shlibs; do
    [[ ! -f $control/$file ]] || cp "$control/$file" "$3/info/$name.$file"
  done
  rm -r "$control"
}

# unpack WORK TREE: unpacks every fetched package, without settings and without documents other than licences.
unpack() {
  local deb database=$2/var/lib/dpkg
  mkdir -p "$database/info"
  echo 1 >"$database/info/format" # file names contain the machine
  for deb in "$1"/archives/*.deb; do
    dpkg-deb --fsys-tarfile "$deb" | tar -xv -C "$2" --no-same-owner --keep-directory-symlink --exclude=./etc \
      --exclude=./usr/share/{man,locale,info,lintian,bash-completion} --exclude=./var --exclude=./dev \
      --exclude='./usr/share/doc/*/[!c]*' --exclude='./usr/share/doc/*/c[!o]*' >"$1/names"
    record "$deb" "$1/names" "$database"
    # shellcheck disable=SC2016
    dpkg-deb -W --showformat='${Package} ${Version}\n' "$deb"
  done >"$2/packages"
}

# Does what an installation would do: puts /lib into /usr, as on a running system, and makes no link leave the tree.
settle() {
  local folder link target libraries name
  for folder in lib lib32 lib64 libx32 bin sbin; do
    [[ -d $1/$folder && ! -L $1/$folder ]] || continue
    mkdir -p "$1/usr/$folder"
    cp -a "$1/$folder/." "$1/usr/$folder/"
    rm -r "${1:?}/$folder"
    ln -s "usr/$folder" "$1/$folder"
  done
  while read -r link; do
    target=$(readlink "$link")
    ln -snf "$(realpath -ms --relative-to="$(dirname "$link")" "$1$target")" "$link"
  done < <(find "$1" -type l -lname '/*')
  # Wine's user32 loads zlib1.dll only as one of Wine's own libraries, which have this mark behind their first 64 bytes.
  name=$1/usr/lib/i386-linux-gnu/wine/i386-windows/zlib1.dll
  if [[ -d $(dirname "$name") ]]; then
    cp "$1/usr/i686-w64-mingw32/lib/zlib1.dll" "$name"
    { printf 'Wine builtin DLL' && head -c 16 /dev/zero; } | dd of="$name" bs=1 seek=64 conv=notrunc status=none
  fi
  libraries=$(echo "$1"/usr/lib/*-linux-gnu*)
  for name in blas lapack; do # two packages offer them, so this links one; OpenCV needs it
    [[ ! -e $libraries/$name/lib$name.so.3 ]] || ln -snf "$name/lib$name.so.3" "$libraries/lib$name.so.3"
  done
}

# make_tree ARCH TREE: runs in a subshell, which ends at the first failed command.
make_tree() {
  local work=$2.apt source
  source=$(main_suite)
  [[ -n $source ]] || {
    say "no main suite among this system's package sources; name one in SINEW_SYSROOT_SOURCE"
    return 1
  }
  rm -rf "$2" "$work"
  mkdir -p "$2"
  own_apt "$work" "${1%%-*}" "$source"
  export APT_CONFIG=$work/apt.conf
  apt-get update -q --error-on=any
  apt-get install -y -q --download-only "${wanted[@]}"
  unpack "$work" "$2"
  settle "$2"
  rm -r "$work"
}

if (($# == 0)); then
  say "usage: toolchains/sysroot.sh ARCH...      armhf, arm64, mipsel, i386 or i386-gl" >&2
  exit 2
fi
for arch in "$@"; do # checks all before it makes the first
  if [[ ! $arch =~ ^(armhf|arm64|mipsel|i386|i386-gl)$ ]]; then
    say "sysroot: no machine '$arch'; known: armhf arm64 mipsel i386 i386-gl" >&2
    exit 2
  fi
done
# Makes a tree again when the wanted packages or these scripts have changed.
how=$(cat "${BASH_SOURCE[0]}" "$root/tools/own_apt.sh")
for arch in "$@"; do
  mapfile -t wanted < <(wanted_of "$arch")
  made_by=$(printf '%s\n' "$how" "${wanted[@]}" "${SINEW_SYSROOT_SOURCE:-}" | sha256sum)
  tree=$home/$arch
  [[ "$(cat "$tree/made-by" 2>/dev/null)" != "$made_by" ]] || continue
  for tool in apt-get dpkg-deb flock; do
    command -v "$tool" >/dev/null || die "$tool is missing: a sysroot is made of Debian packages, on a Debian system"
  done
  mkdir -p "$home" "$logs"
  exec {lock}>"$home/$arch.lock"
  flock "$lock" # another clone may be making it
  [[ "$(cat "$tree/made-by" 2>/dev/null)" != "$made_by" ]] || continue
  start=$(now_s) log=$logs/sysroot-$arch.log
  say "sysroot: $arch from ${#wanted[@]} packages and what they need"
  set +e
  (
    set -e
    make_tree "$arch" "$tree.new"
  ) >"$log" 2>&1
  status=$?
  set -e
  if ((status != 0)); then
    tail -n 20 "$log" >&2
    die "no sysroot for $arch (log: ${log#"$root"/})"
  fi
  say "$made_by" >"$tree.new/made-by"
  rm -rf "$tree"
  mv "$tree.new" "$tree"
  exec {lock}>&-
  say "sysroot: $arch in $(minutes $(($(now_s) - start))), $(wc -l <"$tree/packages") packages, $(du -sm "$tree" | cut -f1) MB"
done
