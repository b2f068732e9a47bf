#!/usr/bin/env bash
# The output of one sub-test of the last boot, with its exit code; a missing result is a failure.
#
#   tests/vm/result.sh board can
set -euo pipefail
results=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)/build/vm/results/${1:?folder}
[[ -f $results/finished && -f $results/${2:?sub-test}.result ]] || {
  echo "no result of $1/$2: see build/logs/vm-$1.log"
  exit 1
}
cat "$results/$2.log"
read -r code took <"$results/$2.result"
echo "exit code $code after $took s of the guest"
[[ $code == 0 ]]
