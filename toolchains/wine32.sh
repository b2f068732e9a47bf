#!/usr/bin/env bash
# Runs a 32-bit Windows program by Wine's 32-bit half, which toolchains/sysroot.sh i386 unpacked. The unpacked folder is
# the root of the file system; process and mount namespaces are separate and end with the program.
#
#   toolchains/wine32.sh [OPTION...] PROGRAM ARGUMENT...
#     --see FOLDER           the program sees this folder, too; may be given several times
#     --display NAME         an X server; without it the program has none
#     --graphics TREE        OpenGL of 32 bits to draw with: what toolchains/sysroot.sh i386-gl unpacked, in a folder that it sees
#   toolchains/wine32.sh --check       runs nothing; if it cannot run here, exits with 77 and says why
#
# Needs root, or a kernel that permits user namespaces to everybody. ctest counts exit 77 as not run.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
tree=${SINEW_SYSROOTS:-$root/build/sysroot}/i386

not_run() {
  printf 'wine32.sh: not run: %s\n' "$*" >&2
  exit 77
}

spaces=(unshare --mount --pid --fork --kill-child --propagation private)
((EUID == 0)) || spaces+=(--map-root-user)

# --inside PROGRAM ARGUMENT...: this script again, as the first process of the new spaces.
if [[ ${1:-} == --inside ]]; then
  shift
  (($$ == 1)) || not_run "--inside is for this script alone: the mounts would stay"
  mount -t tmpfs tmp "$tree/tmp" # Wine's server listens there: one server for each program, which ends with it
  mount -t proc proc "$tree/proc" # for these processes: Wine reads the processor time of threads there
  mount --rbind /dev "$tree/dev"
  mount --rbind "$root" "$tree$root"
  while read -r folder; do
    [[ -n $folder ]] || continue
    mkdir -p "$tree$folder"
    mount --rbind "$folder" "$tree$folder"
  done <<<"${wine32_see:-}"
  if [[ -n ${wine32_graphics:-} ]]; then
    libraries=$wine32_graphics/usr/lib/i386-linux-gnu
    export LD_LIBRARY_PATH=$libraries LIBGL_DRIVERS_PATH=$libraries/dri
  fi
  echo '<fontconfig/>' >"$tree/tmp/fonts.conf" # there are no fonts; without this file each program would complain
  export FONTCONFIG_FILE=/tmp/fonts.conf PATH=/usr/bin:/bin HOME=/root WINEPREFIX=/root/prefix WINEARCH=win32 WINESERVER=/usr/lib/wine/wineserver32
  export WINEDEBUG=${WINEDEBUG--all} WINEDLLOVERRIDES='mscoree=;mshtml=' DISPLAY=${wine32_display:-} TMPDIR=/tmp
  within=(unshare --root="$tree" --wd="$PWD")
  [[ $1 == --make-prefix ]] || exec "${within[@]}" /usr/lib/wine/wine "$@"
  "${within[@]}" /usr/lib/wine/wine wineboot -i
  exec "${within[@]}" "$WINESERVER" -w # the server writes the registry when it ends, so wait for it
fi

export wine32_see='' wine32_display='' wine32_graphics=''
while (($# > 1)); do
  case $1 in
    --see) wine32_see+=$(realpath "$2")$'\n' ;;
    --display) wine32_display=$2 ;;
    --graphics) wine32_graphics=$(realpath "$2") ;;
    *) break ;;
  esac
  shift 2
done
[[ -x $tree/usr/lib/wine/wine ]] || not_run "no Wine of 32 bits in $tree (tools/setup.sh windows32)"
for tool in unshare mount flock; do command -v "$tool" >/dev/null || not_run "$tool is missing"; done
mkdir -p "$tree"/{proc,dev,tmp,root} "$tree$root" 2>/dev/null || not_run "$tree belongs to somebody else"
case $PWD/ in
  "$root"/*) ;;
  *) not_run "started outside of $root, which is all that the program sees" ;;
esac
"${spaces[@]}" "${BASH_SOURCE[0]}" --inside --version >/dev/null 2>&1 ||
  not_run "it needs root, to mount and to change the root folder, and that is not to be had here"
[[ ${1:-} != --check ]] || exit 0

# Making Wine's drive C takes seconds and half a gigabyte: only the first process does it.
if [[ ! -e $tree/root/prefix.made ]]; then
  exec {lock}>"$tree/root/prefix.lock"
  flock "$lock"
  if [[ ! -e $tree/root/prefix.made ]]; then
    rm -rf "$tree/root/prefix"
    "${spaces[@]}" "${BASH_SOURCE[0]}" --inside --make-prefix >&2
    [[ -s $tree/root/prefix/system.reg ]] || { printf 'wine32.sh: wineboot made no registry\n' >&2 && exit 1; }
    touch "$tree/root/prefix.made"
  fi
  exec {lock}>&-
fi
exec "${spaces[@]}" "${BASH_SOURCE[0]}" --inside "$@"
