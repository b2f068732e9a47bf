# shellcheck shell=bash
# Shared by ./run, ./test and tools/*.sh: `source` it. Sourcing it starts nothing.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
logs=$root/build/logs
jobs=${SINEW_JOBS:-$(nproc 2>/dev/null || getconf _NPROCESSORS_ONLN)}
configure_options=() # for builds that do not exist yet
launcher=() # a program that starts builds and tests, e.g. (setarch -R)

say() { printf '%s\n' "$*"; }
die() {
  printf '%s: %s\n' "$(basename "$0")" "$*" >&2
  exit 1
}

now_s() { date +%s; }

# minutes SECONDS -> "3 min 07 s" or "7 s"
minutes() {
  if (($1 < 60)); then printf '%d s' "$1"; else printf '%d min %02d s' $(($1 / 60)) $(($1 % 60)); fi
}

# logged LOG COMMAND...: output goes to LOG. On a terminal its last line is shown while the command runs, so that a long
# build does not look dead.
logged() {
  local log=$1 status=0 ticker=
  shift
  mkdir -p "$(dirname "$log")"
  if [[ -t 1 ]]; then
    show_last_line "$log" &
    ticker=$!
  fi
  "$@" >"$log" 2>&1 || status=$?
  if [[ -n $ticker ]]; then
    kill "$ticker" 2>/dev/null || true
    wait "$ticker" 2>/dev/null || true
    printf '\r\033[K'
  fi
  return "$status"
}

# quietly LOG COMMAND...: as logged; shows all of LOG when the command fails.
quietly() {
  local log=$1 status=0
  shift
  logged "$log" "$@" || status=$?
  if ((status != 0)); then
    cat "$log"
    say "failed ($status): $*"
    say "log: ${log#"$root"/}"
  fi
  return "$status"
}

# limited SECONDS COMMAND...: runs the command without input; returns its exit code, 124 or 137 when its time was over.
# `timeout` runs in a separate process group, which Ctrl-C does not reach, and can outlive the script: a script that
# calls this has end_limited in its trap for EXIT.
limited_pid=
limited() {
  local status=0
  timeout -k 5 "$@" </dev/null &
  limited_pid=$!
  wait "$limited_pid" || status=$?
  limited_pid=
  return "$status"
}

end_limited() {
  [[ -n $limited_pid ]] || return 0
  kill "$limited_pid" 2>/dev/null || true
  wait "$limited_pid" 2>/dev/null || true
}

show_last_line() {
  local width=$(($(tput cols 2>/dev/null || echo 80) - 3))
  while sleep 0.3 && kill -0 $$ 2>/dev/null; do # ends with the script, also after an interruption
    printf '\r\033[K  %.*s' "$width" "$(tail -n 1 "$1" 2>/dev/null | tr -d '\r\033')"
  done
}

# configure PRESET: configures again when there is no build yet, or when a preset, an installed package or a board's
# sysroot may have changed it; else only when a CMakeLists.txt or the set of files has changed.
configure() {
  local ninja_file=$root/build/$1/build.ninja
  local sysroot=${SINEW_SYSROOTS:-$root/build/sysroot}/$1
  if [[ -f $ninja_file && $ninja_file -nt $root/CMakePresets.json && ! $root/build/.packages-changed -nt $ninja_file &&
    ! $sysroot/made-by -nt $ninja_file ]]; then
    quietly "$logs/$1-configure.log" ninja -C "$root/build/$1" build.ninja
    return
  fi
  (cd "$root" && quietly "$logs/$1-configure.log" cmake --preset "$1" "${configure_options[@]}") || return
  touch "$ninja_file"
}

# stop_ahead PRESET: this build is not, or no longer, compiled by tools/build_ahead.sh.
ahead=$logs/ahead
stop_ahead() {
  [[ -d $ahead ]] || return 0
  touch "$ahead/stop.$1"
  flock --nonblock "$ahead/lock.$1" true && return # nobody builds it: an old pid may be somebody else's now
  kill "$(cat "$ahead/pid.$1" 2>/dev/null)" 2>/dev/null || true
  flock "$ahead/lock.$1" true
}

# build PRESET [TARGET...]: configures when needed, builds, says how long it took.
build() {
  local preset=$1 start status=0
  shift
  start=$(now_s)
  stop_ahead "$preset"
  configure "$preset" || return
  [[ -t 1 ]] || say "building $preset; log: build/logs/$preset-build.log"
  quietly "$logs/$preset-build.log" "${launcher[@]}" ninja -C "$root/build/$preset" -j "$jobs" "$@" || status=$?
  ((status == 0)) && say "build $preset: $(minutes $(($(now_s) - start)))"
  return "$status"
}

# sources: every C++ file of the repository, relative to its root, one a line.
sources() {
  if git -C "$root" rev-parse --is-inside-work-tree >/dev/null 2>&1; then
    git -C "$root" ls-files --cached --others --exclude-standard -- '*.hpp' '*.cpp'
  else # an unpacked archive
    (cd "$root" && find . -path ./build -prune -o \( -name '*.hpp' -o -name '*.cpp' \) -print | sed 's|^\./||')
  fi | LC_ALL=C sort -u | while IFS= read -r file; do
    if [[ -f $root/$file ]]; then printf '%s\n' "$file"; fi
  done
}
