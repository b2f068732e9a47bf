#!/usr/bin/env bash
# Measures the rebuild after a change in one module: the runtime with its simulator, and everything with all tests.
#
#   tools/rebuild_time.sh [SOURCE]      default: the first source of control/
#
# Edits nothing: touches the file and tells ccache to compile it again.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

source_file=${1:-}
if [[ -z $source_file ]]; then
  source_file=$(sources | grep '^control/.*\.cpp$' | head -n 1) || die "control/ has no sources yet; name a file"
fi
[[ -f $root/$source_file ]] || die "no such file: $source_file"

build release
export CCACHE_RECACHE=1
# timed TITLE TARGET...: seconds to one decimal.
timed() {
  local begin end
  touch "$root/$source_file"
  begin=$(date +%s%N)
  quietly "$logs/rebuild.log" ninja -C "$root/build/release" -j "$jobs" "${@:2}"
  end=$(date +%s%N)
  awk -v t=$((end - begin)) -v what="$1" -v f="$source_file" 'BEGIN { printf "%s after touching %s: %.1f s\n", what, f, t / 1e9 }'
}
timed "sinew and sinew-sim" sinew sinew-sim
timed "everything, tests too"
