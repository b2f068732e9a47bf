#!/usr/bin/env bash
# Flies robots/quad/quad.toml in virtual time for many seeds, and checks that one flight gives the same bytes everywhere.
#
#   tools/flight_seeds.sh [--seeds N] [--build FOLDER] [--same-bytes "FOLDER ..."] [sweep option...]
#
# --seeds N      seeds 1..N (default 10), as many at once as there are cores
# --build FOLDER build/FOLDER/bin/sinew flies (default release)
# --same-bytes   also: the hash lines of seed 1 from the release build twice, from these other builds (none: ''), and from release
#                with the processor's FMA and AVX hidden from the C library, must be identical; and in each of
#                them a replay of 8 s that release recorded in virtual and in real time must find every step identical
#
# The seeds are flown by `sinew sweep`, whose options may be added. Passes when at least 95 of 100 seeds land (every one of fewer
# than 20). build/flights/seeds.jsonl has the results.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
export SINEW_RECORD=off

seeds=10 preset=release same_bytes=0 others=() options=()
while (($#)); do
  case $1 in
    --seeds) shift && seeds=$1 ;;
    --build) shift && preset=$1 ;;
    --same-bytes)
      shift
      same_bytes=1
      read -ra others <<<"${1?--same-bytes needs the names of builds}"
      ;;
    *) options+=("$1") ;;
  esac
  shift
done

out=$root/build/flights
rm -rf "$out"
mkdir -p "$out"
limit_s=${SINEW_FLIGHT_LIMIT_S:-300} # of real time for one flight; a sanitized build is slow

# fly PRESET SEED NAME: one flight; its output in build/flights/NAME.log, its exit code in NAME.exit.
fly() {
  local code=0
  timeout "$limit_s" "$root/build/$1/bin/sinew" run "$root/robots/quad/quad.toml" --virtual --verbose --seed "$2" "${@:4}" \
    >"$out/$3.log" 2>&1 </dev/null || code=$?
  printf '%s\n' "$code" >"$out/$3.exit"
}

# table: one line per seed; leaves the number of good landings in `landed`.
table() {
  python3 -B - "$out/seeds.jsonl" <<'PYTHON'
import json
import sys

print(f"{'seed':>6}  {'landed':<8} {'error m':>10} {'speed m/s':>12} {'flight s':>9}")
with open(sys.argv[1]) as file:
    next(file)  # what the sweep is
    for line in file:
        case = json.loads(line)
        m = case.get("measures", {})
        verdict = "yes" if case["good"] else f"no ({case['code']})"
        figures = [f"{m[key]:.3f}" if key in m else "-" for key in ("landing_error_m", "touchdown_speed_mps", "flight_s")]
        print(f"{case['case'] + 1:6}  {verdict:<8} {figures[0]:>10} {figures[1]:>12} {figures[2]:>9}")
        if not case["good"]:
            print(f"        {case['outcome']}\n        sinew run {case['run']}")
PYTHON
  landed=$(grep -c '"good":true' "$out/seeds.jsonl") || true
}

# hashes NAME: the hash lines of a flight in order of the topics, and how it ended.
hashes() {
  grep '^hash ' "$out/$1.log" | LC_ALL=C sort || true
  say "exit code $(cat "$out/$1.exit")"
}

hidden=-AVX512F,-AVX512VL,-AVX512DQ,-AVX512BW,-AVX512CD,-AVX2,-AVX,-FMA,-FMA4

# replay PRESET FILE: the first line of that build's replay of a recording; fails when not all of it is identical.
replay() { ASAN_OPTIONS=detect_leaks=0 timeout "$limit_s" "$root/build/$1/bin/sinew" replay "$2" 2>&1 | head -n 1; }

# check_replays: names every build that does not find the release build's recordings identical.
check_replays() {
  local kind file said variant wrong=0
  for kind in --virtual --plain; do
    SINEW_RECORD=on timeout "$limit_s" "$root/build/release/bin/sinew" run "$root/robots/quad/quad.toml" "$kind" --quiet --duration 8 \
      --record-images --runs "$out/runs$kind" >"$out/recorded$kind.log" 2>&1 || true # it has not landed after 8 s
    file=$out/runs$kind/latest/run.mcap
    for variant in release "${others[@]}" no-fma-avx; do
      if [[ $variant == no-fma-avx ]]; then
        said=$(GLIBC_TUNABLES=glibc.cpu.hwcaps=$hidden replay release "$file") || wrong=1
      else
        said=$(replay "$variant" "$file") || wrong=1
      fi
      if [[ $said != identical:* ]]; then
        say "replay of $kind by $variant: $said"
        wrong=1
      fi
    done
    say "replay (${kind#--}): $said"
  done
  rm -rf "$out"/runs--*
  return "$wrong"
}

# check_same_bytes: names every variant whose hash lines differ from the first's, and the first such line.
check_same_bytes() {
  local variant wrong=0 count
  fly release 1 bytes-release "${options[@]}" &
  fly release 1 bytes-again "${options[@]}" &
  wait
  GLIBC_TUNABLES=glibc.cpu.hwcaps=$hidden fly release 1 bytes-no-fma-avx "${options[@]}" &
  for variant in "${others[@]}"; do ASAN_OPTIONS=detect_leaks=0 fly "$variant" 1 "bytes-$variant" "${options[@]}"; done
  wait
  count=$(grep -c '^hash ' "$out/bytes-release.log" || true)
  if ((count == 0)); then
    say "same bytes: the release build printed no hash lines"
    tail -n 5 "$out/bytes-release.log"
    return 1
  fi
  for variant in again no-fma-avx "${others[@]}"; do
    if ! diff <(hashes bytes-release) <(hashes "bytes-$variant") >"$out/diff-$variant"; then
      say "same bytes: $variant differs from release:"
      head -n 8 "$out/diff-$variant"
      wrong=1
    fi
  done
  ((wrong)) || say "same bytes: $count topics, identical from release twice,${others:+ ${others[*]},} and without FMA and AVX"
  return "$wrong"
}

[[ -x $root/build/$preset/bin/sinew ]] || die "build/$preset/bin/sinew is not built"
start=$(now_s)
code=0
(cd "$root" && "build/$preset/bin/sinew" sweep robots/quad/quad.toml --seeds "1..$seeds" --patience "$limit_s" \
  --results "$out/seeds.jsonl" "${options[@]}") >"$out/seeds.log" 2>&1 || code=$?
((code <= 1)) || { cat "$out/seeds.log" && die "the sweep ended with exit code $code"; }
table
tail -n +2 "$out/seeds.log"
bytes=skipped status=0
if ((same_bytes)); then
  bytes=identical
  check_same_bytes || { bytes=DIFFERENT status=1; }
  check_replays || { bytes=DIFFERENT status=1; }
fi
need=$((seeds < 20 ? seeds : seeds * 95 / 100))
((landed >= need)) || status=1
say "flights: $landed of $seeds landed (needed $need), same bytes: $bytes, $(minutes $(($(now_s) - start)))"
exit "$status"
