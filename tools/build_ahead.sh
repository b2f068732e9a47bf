#!/usr/bin/env bash
# Compiles builds one after the other with what other programs leave of the processors. ./test --ci starts it beside its
# tests, which wait for a third of their time.
#
#   tools/build_ahead.sh FOLDER "PRESET TARGET..." ...
#
# In FOLDER: `lock.PRESET` is held while a preset is built, by the process in `pid.PRESET`; where `stop.PRESET` is, it is
# not begun. An error ends only the build of its preset: whoever needs it builds again, and shows the error.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

folder=${1:?the folder of its state}
shift
# A session has its weight as a whole where the kernel groups by session; SCHED_IDLE counts within it.
{ echo 19 >"/proc/$$/autogroup"; } 2>/dev/null
chrt --idle --pid 0 $$ || exit

child=
trap '[[ -z $child ]] || kill "$child"; exit 1' TERM
for what; do
  read -ra words <<<"$what"
  preset=${words[0]}
  exec 9>"$folder/lock.$preset"
  flock 9
  if [[ ! -e $folder/stop.$preset ]] && configure "$preset"; then
    launcher=()
    if [[ $preset == tsan ]] && setarch -R true 2>/dev/null; then launcher=(setarch -R); fi # as in stage tsan
    "${launcher[@]}" ninja -C "$root/build/$preset" -j "$jobs" "${words[@]:1}" &
    child=$!
    echo "$child" >"$folder/pid.$preset"
    [[ ! -e $folder/stop.$preset ]] || kill "$child"
    wait "$child"
    child=
    rm -f "$folder/pid.$preset"
  fi
  exec 9>&-
done
