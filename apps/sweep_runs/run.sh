#!/bin/sh
# Flies the sweep of this folder, or a part of it, with further options of `sinew sweep`:
#   run --shard 3/10 --results FILE      then: run merge FILE... --into FILE
set -eu
folder=$(dirname "$(readlink -f "$0")")
case $folder in
  *[:\;]*) echo "run: $folder: the dynamic loader takes no folder with : or ; in its name" >&2 && exit 2 ;;
esac
(cd "$folder" && sha256sum --check --quiet --strict SHA256SUMS) >&2 ||
  { echo "run: $folder is not as it was packed; copy it again" >&2 && exit 2; }
export LD_LIBRARY_PATH="$folder/lib"
if [ -e "$folder/lib/dri" ]; then
  export __EGL_VENDOR_LIBRARY_FILENAMES="$folder/lib/egl_vendor.json" LIBGL_DRIVERS_PATH="$folder/lib/dri"
fi
if [ "${1-}" = merge ]; then exec "$folder/bin/sinew" "$@"; fi
# The packed options first: one that is given again here has the last word.
given=$#
while IFS= read -r word; do set -- "$@" "$word"; done <"$folder/options"
while [ "$given" -gt 0 ]; do
  first=$1 && shift && set -- "$@" "$first"
  given=$((given - 1))
done
exec "$folder/bin/sinew" sweep --in "$folder" "$@"
