#!/usr/bin/env bash
# Flies one robot twice in lockstep: by this machine's sinew-fly, and by a program built for another one. All bytes of
# all topics must be the same; the first topic that differs is named.
#
#   tools/compare_flight.sh [--seed N] [--duration S] [--robot FILE] [--host H] [--label TEXT] -- COMMAND...
#
# COMMAND gets "ROBOT tcp:H:PORT --seed N [--duration S]" appended, e.g.
#   tools/compare_flight.sh -- toolchains/wine.sh build/windows/bin/sinew-fly.exe
#   tools/compare_flight.sh --duration 5 -- qemu-arm -L build/sysroot/armhf build/armhf/bin/sinew-fly
#   tools/compare_flight.sh --label mipsel --host 10.0.2.2 -- tests/boards/fly.sh mipsel
# Without --duration both fly the whole mission and must land well. --host: how COMMAND names this machine (127.0.0.1).
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

seed=1 duration=() robot=robots/quad.toml host=127.0.0.1 label=other limit_s=${SINEW_FLIGHT_LIMIT_S:-900}
while (($#)); do
  case $1 in
    --seed) shift && seed=$1 ;;
    --duration) shift && duration=(--duration "$1") ;;
    --robot) shift && robot=$1 ;;
    --host) shift && host=$1 ;;
    --label) shift && label=$1 ;;
    --) shift && break ;;
    *) die "$1: unknown; see the head of ${BASH_SOURCE[0]#"$root"/}" ;;
  esac
  shift
done
(($#)) || die "which command flies? It comes after --"
bin=$root/build/release/bin
for program in sinew-sim sinew-fly; do [[ -x $bin/$program ]] || die "build/release has no $program: ./run builds it"; done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# fly NAME HOST COMMAND...: one flight; its output in $work/NAME.
fly() {
  local name=$1 as=$2 code=0 endpoint='' sim
  shift 2
  : >"$work/$name.sim" # it is read before the plant writes it
  "$bin/sinew-sim" --listen tcp:127.0.0.1:0 --lockstep --seed "$seed" --wait 300 >"$work/$name.sim" 2>&1 &
  sim=$!
  for ((i = 0; i < 600; ++i)); do
    endpoint=$(sed -n 's/^listening on tcp:[^:]*:\([0-9]*\).*/\1/p' "$work/$name.sim")
    [[ -z $endpoint ]] || break
    kill -0 "$sim" 2>/dev/null || die "sinew-sim does not start: $(cat "$work/$name.sim")"
    sleep 0.1
  done
  [[ -n $endpoint ]] || die "sinew-sim does not listen after 60 s"
  local start=$SECONDS
  timeout "$limit_s" "$@" "$robot" "tcp:$as:$endpoint" --seed "$seed" "${duration[@]}" >"$work/$name" 2>"$work/$name.err" </dev/null || code=$?
  kill "$sim" 2>/dev/null || true
  wait "$sim" 2>/dev/null || true
  tr -d '\r' <"$work/$name" | grep '^hash ' >"$work/$name.hashes" || true
  [[ -s $work/$name.hashes ]] || die "$name: no flight (exit $code): $(tail -n 5 "$work/$name.err")"
  say "$name: $(wc -l <"$work/$name.hashes") topics, $((SECONDS - start)) s, exit $code$(tr -d '\r' <"$work/$name" | sed -n 's/^landing error */, landing error /p')"
  tr -d '\r' <"$work/$name" | grep -E '^(grants|start-up|board) ' || true
  # A flight that is cut short has not landed, and says so with 1.
  [[ $code == 0 || (${#duration[@]} -gt 0 && $code == 1) ]] || die "$name: exit $code: $(tail -n 5 "$work/$name.err")"
}

cd "$root"
fly here 127.0.0.1 "$bin/sinew-fly"
fly "$label" "$host" "$@"
if ! difference=$(diff "$work/here.hashes" "$work/$label.hashes"); then
  die "$label: the first topic that differs: $(sed -n 's/^< hash \([^ ]*\).*/\1/p' <<<"$difference" | head -n 1)"
fi
say "$label: the same bytes on all $(wc -l <"$work/here.hashes") topics"
