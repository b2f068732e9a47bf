#!/usr/bin/env bash
# Runs clang-tidy with the repository's .clang-tidy, on all cores.
#
#   tools/tidy.sh              every source that the clang preset compiles
#   tools/tidy.sh --changed    sources that differ from main, or from HEAD where main is HEAD (a changed header is
#                              checked only through these sources)
#   tools/tidy.sh FILE...      these files
#
# A file that passed is not checked again until it, one of our headers, or .clang-tidy changes.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

configure clang
cd "$root"
passed=build/tidy
mkdir -p "$passed"
mapfile -t known < <(python3 -c '
import json, os
for entry in json.load(open("build/clang/compile_commands.json")):
    print(os.path.relpath(os.path.join(entry["directory"], entry["file"])))' | LC_ALL=C sort -u | grep -v '^build/')

case ${1:-} in
  "") files=("${known[@]}") ;;
  --changed)
    base=$(git merge-base HEAD main)
    mapfile -t files < <({ git diff --name-only "$base" && git ls-files --others --exclude-standard; } | sort -u |
      grep -Fx -f <(printf '%s\n' "${known[@]}") || true)
    ;;
  *) files=("$@") ;;
esac

newest_header=$(sources | grep '\.hpp$' | xargs -r ls -t .clang-tidy | sed -n 1p)
todo=()
for file in "${files[@]}"; do
  stamp=$passed/${file//\//.}
  [[ -f $stamp && $stamp -nt $file && $stamp -nt $newest_header ]] || todo+=("$file")
done

tidy_one() {
  local out status=0
  out=$(clang-tidy -p build/clang --quiet "$1" 2>/dev/null) || status=$?
  if ((status == 0)); then touch "build/tidy/${1//\//.}"; else printf '%s\n%s: clang-tidy failed\n' "$out" "$1"; fi
  return "$status"
}
export -f tidy_one

start=$(now_s) status=0
if ((${#todo[@]})); then
  # shellcheck disable=SC2016  # the quoted program is the inner shell's
  printf '%s\0' "${todo[@]}" | xargs -0 -n 1 -P "$jobs" bash -c 'tidy_one "$1"' tidy || status=1
fi
say "clang-tidy: ${#todo[@]} of ${#files[@]} files looked at in $(minutes $(($(now_s) - start)))"
exit "$status"
