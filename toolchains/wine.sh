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
exec "$wine" "$@"
