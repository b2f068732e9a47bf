#!/usr/bin/env bash
# Flies robots/quad/quad.toml in virtual time with every kind of fault on every device, for many seeds.
#
#   tools/fault_matrix.sh [--seeds N] [--build FOLDER] [--device NAME]...
#
# --seeds N      seeds 1..N of each cell (default 20), as many flights at once as there are cores
# --build FOLDER build/FOLDER/bin/sinew flies (default release)
# --device NAME  only this device; may be repeated
#
# The flights are flown by `sinew sweep`: after Ctrl-C or kill -9 the same command goes on, and what is complete is not
# flown again. Passes when every flight ends as the table in tests/apps/run/fault_matrix.py says. All flights are in
# build/faults.txt, the sweep's results in build/faults/; prints the wrong flights, and per cell how many landed,
# stopped, or neither.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
seeds=20 preset=release options=()
while (($#)); do
  case $1 in
    --seeds) shift && seeds=$1 ;;
    --build) shift && preset=$1 ;;
    --device) shift && options+=(--device "$1") ;;
    *) die "unknown option $1" ;;
  esac
  shift
done

bin=$root/build/$preset/bin
[[ -x $bin/sinew && -x $bin/sinew-sim ]] || die "build/$preset/bin/sinew and sinew-sim are not built"
out=$root/build/faults.txt
start=$(now_s)
status=0
mkdir -p "$root/build/faults"
python3 -B "$root/tests/apps/run/fault_matrix.py" "$bin/sinew" "$bin/sinew-sim" "$root/robots/quad/quad.toml" \
  --seeds "$seeds" --first-seed 1 --jobs "$jobs" --folder "$root/build/faults" "${options[@]}" >"$out" || status=1
awk '$3 ~ /^[0-9]+$/ && NF > 4 { cell = sprintf("%-8s %-13s", $1, $2); if (!(cell in n)) order[++cells] = cell
                       ++n[cell]; ++ended[cell, $4]; wrong[cell] += /WRONG/ }
     / none: / { printf "%s\n", $0 }
     END { printf "%-8s %-13s %6s %7s %7s %6s\n", "device", "kind", "landed", "stopped", "neither", "wrong"
           for (i = 1; i <= cells; ++i) { c = order[i]
             printf "%s %6d %7d %7d %6d\n", c, ended[c, "landed"], ended[c, "stopped"],
                    n[c] - ended[c, "landed"] - ended[c, "stopped"], wrong[c] } }' "$out"
grep WRONG "$out" || true
tail -n 1 "$out"
say "faults: $(tail -n 1 "$out"), $(minutes $(($(now_s) - start)))"
exit "$status"
