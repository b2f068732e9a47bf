#!/bin/sh
# Runs a 64-bit Windows program: with a prefix of its own for each user, and without windows and sounds.
#
#   toolchains/wine.sh PROGRAM ARGUMENT...
#   toolchains/wine.sh --check         nothing runs: exits with 77, and says why, where there is no Wine
set -eu
: "${WINEPREFIX:=${XDG_CACHE_HOME:-$HOME/.cache}/sinew/wine}"
export WINEPREFIX WINEDEBUG=-all WINEDLLOVERRIDES='mscoree=;mshtml=' DISPLAY=
wine=$(command -v wine64 || echo /usr/lib/wine/wine64)
[ -x "$wine" ] || { echo "wine.sh: wine64 is missing (Debian: wine64)" >&2; exit 77; }
[ "${1:-}" != --check ] || exit 0
mkdir -p "$WINEPREFIX"
# Who comes while another one makes the prefix finds half of it: the first makes it, the others wait.
ready=$WINEPREFIX/sinew-ready
if [ ! -e "$ready" ]; then
  exec 9>"$WINEPREFIX/sinew-lock"
  flock 9
  [ -e "$ready" ] || { "$wine" wineboot --init </dev/null >/dev/null 2>&1 9>&- && : >"$ready"; } ||
    { echo "wine.sh: wineboot could not make $WINEPREFIX" >&2; exit 1; }
  exec 9>&-
fi
exec "$wine" "$@"
