# shellcheck shell=bash
# What the sub-tests have in common: `source`d before each, in the guest, as root.

root=${root:?} build=${build:?}

fail() {
  echo "FAILED: $*"
  exit 1
}

# gtest PROGRAM [ARGUMENT...]: a GoogleTest program of the build, by its path below tests/. No case may be skipped: what is
# missing on a build machine is here.
gtest() {
  local program=$build/tests/$1 log status=0
  shift
  [[ -x $program ]] || fail "$program was not built"
  log=$(mktemp)
  "$program" --gtest_brief=0 "$@" >"$log" 2>&1 || status=$?
  cat "$log"
  ((status == 0)) || fail "$(basename "$program"): exit code $status"
  if grep -qF '[  SKIPPED ]' "$log"; then fail "$(basename "$program"): cases were skipped"; fi
  grep -qE '^\[  PASSED  \] [1-9]' "$log" || fail "$(basename "$program"): no case ran"
}

# eventually SECONDS COMMAND...: tries it until it succeeds.
eventually() {
  local until=$((SECONDS + $1))
  shift
  until "$@"; do
    ((SECONDS < until)) || fail "not in time: $*"
    sleep 0.1
  done
}
