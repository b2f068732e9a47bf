#!/bin/sh
# Runs a 64-bit Windows program, with one prefix for each user, and without windows and sounds.
#
#   toolchains/wine.sh PROGRAM ARGUMENT...
#   toolchains/wine.sh --check         runs nothing; without Wine exits with 77 and says why
set -eu
: "${WINEPREFIX:=${XDG_CACHE_HOME:-$HOME/.cache}/sinew/wine}"
export WINEPREFIX WINEDEBUG=-all WINEDLLOVERRIDES='mscoree=;mshtml=' DISPLAY=
wine=$(command -v wine64 || echo /usr/lib/wine/wine64)
[ -x "$wine" ] || { echo "wine.sh: wine64 is missing (Debian: wine64)" >&2; exit 77; }
[ "${1:-}" != --check ] || exit 0
mkdir -p "$WINEPREFIX"
# The first process makes the prefix; the others wait, since they would find only a part of it.
ready=$WINEPREFIX/sinew-ready
if [ ! -e "$ready" ]; then
  exec 9>"$WINEPREFIX/sinew-lock"
  flock 9
  [ -e "$ready" ] || { "$wine" wineboot --init </dev/null >/dev/null 2>&1 9>&- && : >"$ready"; } ||
    { echo "wine.sh: wineboot could not make $WINEPREFIX" >&2; exit 1; }
  exec 9>&-
fi
exec "$wine" "$@"
