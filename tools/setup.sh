#!/usr/bin/env bash
# Installs the missing Debian packages of tools/packages.txt; returns at once if none is missing.
#
#   tools/setup.sh [build | test | ci]      each includes the ones before it; default: build
#   tools/setup.sh cross [ARCH...]          compilers for boards, with all sysroots (armhf, arm64, mipsel) or those of ARCH
#   tools/setup.sh windows                  a compiler for 64-bit Windows, and Wine
#   tools/setup.sh windows32                the same and a compiler for 32 bits, with a file tree for Wine's 32-bit half
#   tools/setup.sh web                      a browser and node for ./test stage web
#   tools/setup.sh ros2                     Fast DDS and its generator for ./test stage ros2: 350 MB with Java
#   tools/setup.sh policy                   node for ./test stage policy
#   tools/setup.sh grab                     a display, programs that draw, and Wine for ./test stage grab
#   tools/setup.sh cluster                  Slurm, munge, an ssh server and GNU parallel for ./test stage cluster; a system
#                                           starts their daemons at boot, so that neither ./run nor ./test installs them
#
#   tools/setup.sh octave                   Octave and its compiler for ./test stage octave: 130 packages, half a gigabyte
#
# Exit: 0 all there, 3 something is missing and cannot be installed here (says what), 2 wrong call.
# SINEW_SKIP_SETUP=1 skips the check, for systems that get the same things in another way.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

case ${1:-build} in
  build) groups=' build ' ;;
  test) groups=' build test ' ;;
  ci) groups=' build test ci ' ;;
  cross) groups=' build cross ' ;;
  windows) groups=' build windows ' ;;
  windows32) groups=' build windows windows32 ' ;;
  web) groups=' web ' ;;
  ros2) groups=' build ros2 ' ;;
  policy) groups=' build policy ' ;;
  grab) groups=' build grab ' ;;
  cluster) groups=' cluster ' ;;
  octave) groups=' build test octave ' ;;
  *)
    say "usage: tools/setup.sh [build | test | ci | cross [ARCH...] | windows | windows32 | web | ros2 | policy | grab | cluster | octave]" >&2
    exit 2
    ;;
esac
boards=()
if [[ ${1:-} == cross ]]; then
  boards=("${@:2}")
  ((${#boards[@]})) || boards=(armhf arm64 mipsel)
  for board in "${boards[@]}"; do # before anything is installed
    [[ $board =~ ^(armhf|arm64|mipsel)$ ]] || { say "setup: no board '$board'; known: armhf arm64 mipsel" >&2 && exit 2; }
  done
fi
if [[ ${1:-} == windows32 ]]; then boards=(i386); fi

# Makes the sysroots, also when the check of packages is skipped: they are our own files, not packages.
end() {
  ((${#boards[@]} == 0)) || exec "$root/toolchains/sysroot.sh" "${boards[@]}"
  exit 0
}
if [[ ${SINEW_SKIP_SETUP:-0} == 1 ]]; then end; fi

wanted=()
while read -r group package _; do
  # A Node from another source has its own npm, and Debian's npm conflicts with it.
  if [[ $package == nodejs || $package == npm ]] && command -v npm >/dev/null; then continue; fi
  if [[ -n $group && $group != \#* && $groups == *" $group "* ]]; then wanted+=("$package"); fi
done <"$root/tools/packages.txt"

missing() {
  local installed package
  # dpkg-query fails when one of them is unknown, but still lists the others.
  installed=$(dpkg-query -W -f='${db:Status-Status} ${Package}\n' "${wanted[@]}" 2>/dev/null || true)
  for package in "${wanted[@]}"; do
    grep -qxF "installed $package" <<<"$installed" || printf '%s\n' "$package"
  done
}

# Installs the npm packages that tests use as other readers of our recordings and other viewers of the monitor, pinned by
# their lock files. Without npm or its packages the tests that need them are skipped, and say so.
readers_of_others() {
  [[ $groups == *' test '* ]] && command -v npm >/dev/null || return 0
  local room folder
  for room in record monitor; do
    folder=$root/tests/$room/others
    [[ ! $folder/node_modules/.package-lock.json -nt $folder/package-lock.json ]] || continue
    mkdir -p "$logs"
    # Without these limits npm tries for more than a minute when there is no network, at each start of ./test.
    timeout 120 npm --prefix "$folder" ci --fetch-retries=1 --fetch-retry-mintimeout=2000 --fetch-timeout=20000 \
      --ignore-scripts --no-audit --no-fund >"$logs/setup-npm-$room.log" 2>&1 ||
      say "setup: no programs of others for tests/$room (log: build/logs/setup-npm-$room.log)"
  done
}

give_up() {
  {
    say "setup: $1"
    say "setup: needed, by the names of Debian 12's packages:"
    printf '  %s\n' "${@:2}"
    say "setup: install them, then start this again; SINEW_SKIP_SETUP=1 skips this check."
  } >&2
  exit 3
}

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
  give_up "this is not a Debian system, so nothing was checked or installed" "${wanted[@]}"
fi
mapfile -t lacking < <(missing)
if ((${#lacking[@]} == 0)); then
  readers_of_others
  end
fi

as_root=(env DEBIAN_FRONTEND=noninteractive)
if ((EUID != 0)); then
  command -v sudo >/dev/null || give_up "neither root nor sudo, so nothing was installed" "${lacking[@]}"
  as_root=(sudo "${as_root[@]}")
fi
apt=("${as_root[@]}" apt-get -y -q -o DPkg::Lock::Timeout=120)

start=$(now_s)
say "setup: installing ${#lacking[@]} packages: ${lacking[*]}"
mkdir -p "$logs"
# The lists of a fresh or an old system may be missing or stale: try, refresh them, try again.
if ! "${apt[@]}" install --no-install-recommends "${lacking[@]}" >"$logs/setup.log" 2>&1; then
  "${apt[@]}" update >>"$logs/setup.log" 2>&1 || true
  if ! "${apt[@]}" install --no-install-recommends "${lacking[@]}" >>"$logs/setup.log" 2>&1; then
    tail -n 20 "$logs/setup.log" >&2
    mapfile -t lacking < <(missing)
    give_up "apt-get could not install them (log: build/logs/setup.log)" "${lacking[@]}"
  fi
fi
touch "$root/build/.packages-changed"
readers_of_others
say "setup: $(minutes $(($(now_s) - start)))"
end
