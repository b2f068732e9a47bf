#!/usr/bin/env bash
# The robot's program on an emulated board, flying a plant on this host; tools/compare_flight.sh starts it.
#
#   tests/boards/fly.sh BOARD ROBOT tcp:10.0.2.2:PORT [--seed N] [--duration S] ...
#
# Flies with build/BOARD/bin/sinew, or with the program that SINEW_BOARD_PROGRAM names (sinew-fly takes other words).
# Prints the output of `sinew run`, and below it one line about the board.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../../tools/lib.sh"

board=${1:?arm64, armhf or mipsel} robot=${2:?robot file} plant=${3:?endpoint of the plant}
shift 3
program=${SINEW_BOARD_PROGRAM:-$root/build/$board/bin/sinew}
[[ -x $program ]] || die "$program was not built"
words=(run "$robot" --plant "$plant" --virtual --quiet)
[[ $(basename "$program") != sinew-fly ]] || words=("$robot" "$plant")

start=$SECONDS status=0
"$root/tests/boards/boot.sh" --limit "${SINEW_FLIGHT_LIMIT_S:-900}" "$board" "$program" "${words[@]}" "$@" || status=$?
out=$root/build/boards/$board/out
if [[ -f $out/memory ]]; then
  rss_kb=0 locked_kb=0 peak_rss_kb=0
  # shellcheck source=/dev/null
  source "$out/memory"
  up_cs=$(cat "$out/up_cs")
  printf 'board               %s: up after %d.%02d s, %d s in all; %d kB resident, %d kB locked, %d kB at most\n' \
    "$(cat "$out/kernel")" $((up_cs / 100)) $((up_cs % 100)) $((SECONDS - start)) "$rss_kb" "$locked_kb" "$peak_rss_kb"
fi
exit "$status"
