#!/usr/bin/env bash
# Flies one robot twice in lockstep: with this machine's sinew-fly, and with the same program built for another machine.
# All bytes of all topics must be the same; names the first topic that differs. The simulator's truth is a topic of `sinew`
# only (docs/recording.md): with sinew-fly neither side has it, with --replay both.
#
#   tools/compare_flight.sh [--replay] [--seed N] [--duration S] [--robot FILE] [--plant 'WORDS'] [--host H] [--label TEXT]
#                           -- COMMAND...
#
# COMMAND gets "ROBOT tcp:H:PORT --seed N [--duration S]" appended, e.g.
#   tools/compare_flight.sh -- toolchains/wine.sh build/windows/bin/sinew-fly.exe
#   tools/compare_flight.sh --duration 5 -- qemu-arm -L build/sysroot/armhf build/armhf/bin/sinew-fly
#   tools/compare_flight.sh --label mipsel --host 10.0.2.2 -- tests/boards/fly.sh mipsel
#   tools/compare_flight.sh --replay --duration 5 --robot robots/kid/kid.toml --plant '--world soccer --body robots/kid/kid.toml' \
#     -- qemu-arm -L build/sysroot/armhf build/armhf/bin/sinew
# --plant: what sinew-sim gets beside its seed: the world, where it is not the quadrotor's.
# Without --duration both fly the whole mission and must land well. --host: how COMMAND names this machine (127.0.0.1).
# --replay: COMMAND is the other machine's `sinew`. Both record their flight, pixels included, and each replays the
# other's recording: every step of every module must be identical; prints the first one that is not, with its field.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

seed=1 duration=() robot=robots/quad/quad.toml plant=() host=127.0.0.1 label=other program=sinew-fly limit_s=${SINEW_FLIGHT_LIMIT_S:-900}
while (($#)); do
  case $1 in
    --seed | --duration | --robot | --plant | --host | --label) [[ ${2:---} != -- ]] || die "$1: of what?" ;;&
    --replay) program=sinew ;;
    --seed) shift && seed=$1 ;;
    --duration) shift && duration=(--duration "$1") ;;
    --robot) shift && robot=$1 ;;
    --plant) shift && read -ra plant <<<"$1" ;;
    --host) shift && host=$1 ;;
    --label) shift && label=$1 ;;
    --) shift && break ;;
    *) die "$1: unknown; see the head of ${BASH_SOURCE[0]#"$root"/}" ;;
  esac
  shift
done
(($#)) || die "which command flies? It comes after --"
bin=$root/build/release/bin
for needed in sinew-sim "$program"; do [[ -x $bin/$needed ]] || die "build/release has no $needed: cmake --build build/release --target $needed"; done
work=$(mktemp -d) sim=
# Ends everything that this script started, also after an interruption.
finish() {
  end_limited
  [[ -z $sim ]] || kill "$sim" 2>/dev/null || true
  rm -rf "$work"
}
trap finish EXIT
mkdir -m 700 "$work/robots"
export SINEW_RUN_DIR=$work/robots SINEW_RECORD=on

# words_of NAME ENDPOINT: the arguments of the flying program, one a line.
words_of() {
  if [[ $program == sinew ]]; then
    printf '%s\n' run "$robot" --virtual --plant "$2" --verbose --record-images --runs "$work/runs-$1"
  else
    printf '%s\n' "$robot" "$2"
  fi
  printf '%s\n' --seed "$seed" "${duration[@]}"
}

# fly NAME HOST COMMAND...: one flight; its output in $work/NAME.
fly() {
  local name=$1 as=$2 code=0 endpoint='' words
  shift 2
  : >"$work/$name.sim" # the loop reads it before a busy machine has started the simulator
  "$bin/sinew-sim" --listen tcp:127.0.0.1:0 --lockstep --seed "$seed" --wait 300 "${plant[@]}" >"$work/$name.sim" 2>&1 &
  sim=$!
  for ((i = 0; i < 600; ++i)); do
    endpoint=$(sed -n 's/^listening on tcp:[^:]*:\([0-9]*\).*/\1/p' "$work/$name.sim")
    [[ -z $endpoint ]] || break
    kill -0 "$sim" 2>/dev/null || die "sinew-sim does not start: $(cat "$work/$name.sim")"
    sleep 0.1
  done
  [[ -n $endpoint ]] || die "sinew-sim does not listen after 60 s"
  mapfile -t words < <(words_of "$name" "tcp:$as:$endpoint")
  local start=$SECONDS
  limited "$limit_s" "$@" "${words[@]}" >"$work/$name" 2>"$work/$name.err" || code=$?
  kill "$sim" 2>/dev/null || true
  wait "$sim" 2>/dev/null || true
  sim=
  tr -d '\r' <"$work/$name" | grep '^hash ' >"$work/$name.hashes" || true
  # Only `sinew` publishes the simulator's truth.
  [[ $program == sinew ]] || sed -i '/^hash ground_truth /d' "$work/$name.hashes"
  [[ -s $work/$name.hashes ]] || die "$name: no flight (exit $code): $(tail -n 5 "$work/$name.err")"
  say "$name: $(wc -l <"$work/$name.hashes") topics, $((SECONDS - start)) s, exit $code$(tr -d '\r' <"$work/$name" | sed -n 's/^mission .*\(landing error [^,]*\).*/, \1/p')"
  tr -d '\r' <"$work/$name" | grep -E '^(grants|start-up|board) ' || true
  # A flight that --duration cuts short has not landed: exit code 1.
  [[ $code == 0 || (${#duration[@]} -gt 0 && $code == 1) ]] || die "$name: exit $code: $(tail -n 5 "$work/$name.err")"
}

# again NAME WHOSE COMMAND...: NAME replays the recording of WHOSE flight.
again() {
  local name=$1 whose=$2 file code=0 start=$SECONDS
  shift 2
  file=$work/runs-$whose/latest/run.mcap
  [[ -f $file ]] || die "$whose recorded nothing: $(tail -n 5 "$work/$whose" "$work/$whose.err")"
  limited "$limit_s" "$@" replay "$file" >"$work/said" 2>&1 || code=$?
  [[ $code == 0 && $(head -n 1 "$work/said") == identical:* ]] || die "$name, executing again what $whose recorded (exit $code): $(head -n 12 "$work/said")"
  say "$name, executing again what $whose recorded ($(($(stat -c %s "$file") / 1000000)) MB, $((SECONDS - start)) s): $(head -n 1 "$work/said")"
}

cd "$root"
fly here 127.0.0.1 "$bin/$program"
fly "$label" "$host" "$@"
if ! difference=$(diff "$work/here.hashes" "$work/$label.hashes"); then
  die "$label: the first topic that differs: $(sed -n 's/^[<>] hash \([^ ]*\).*/\1/p' <<<"$difference" | head -n 1)"
fi
say "$label: the same bytes on all $(wc -l <"$work/here.hashes") topics"
if [[ $program == sinew ]]; then
  again "$label" here "$@"
  again here "$label" "$bin/sinew"
fi
