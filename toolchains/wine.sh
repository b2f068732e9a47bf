#!/bin/sh
# Runs a Windows program: with a prefix of its own for each user and build, and without windows, sounds and serial lines.
set -eu
: "${WINEPREFIX:=${XDG_CACHE_HOME:-$HOME/.cache}/sinew/wine}"
export WINEPREFIX WINEDEBUG=-all WINEDLLOVERRIDES='mscoree=;mshtml=' DISPLAY=
wine=$(command -v wine64 || echo /usr/lib/wine/wine64)
[ -x "$wine" ] || { echo "wine.sh: wine64 is missing (Debian: wine64)" >&2; exit 127; }
mkdir -p "$WINEPREFIX"
exec "$wine" "$@"
