#!/usr/bin/env bash
# Compiles client/mex for Octave, asks a robot everything that it can, and flies the simulated quadrotors from Octave.
#
#   tests/client/octave_test.sh BUILD
#
# Exit: 77 without mkoctfile or octave.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
build=$(cd "$1" && pwd)
if ! command -v mkoctfile >/dev/null || ! command -v octave >/dev/null; then
  echo "Octave is missing: tools/setup.sh octave installs it"
  exit 77
fi
folder=$(mktemp -d "${TMPDIR:-/tmp}/sinew-octave-XXXXXX")
trap 'rm -rf "$folder"' EXIT
export SINEW_RECORD=off LD_LIBRARY_PATH=$build/bin${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
(cd "$folder" && mkoctfile --mex -Wall -Werror "-I$root/client" "-L$build/bin" "$root/client/mex/sinew_mex.c" -lsinew_client)
octave=(octave --no-gui --no-history --norc -q --path "$folder")
SINEW_RUN_DIR=$folder/run "$build/examples/example_own_program" run "$root/tests/client/client_robot.toml" --plain >"$folder/run.log" 2>&1 &
robot=$!
trap 'kill "$robot" 2>/dev/null || true; wait "$robot" || true; rm -rf "$folder"' EXIT
for _ in {1..200}; do
  [[ -e $folder/run/ball.sock ]] && break
  sleep 0.1
done
cc -Wall -Werror -shared -fPIC "-I$root" -o "$folder/copy_fault.so" "$root/tests/client/copy_fault.c"
SINEW_RUN_DIR=$folder/run LD_PRELOAD=$folder/copy_fault.so "${octave[@]}" "$root/tests/client/mex_test.m"
python3 -B "$root/tests/client/steer_test.py" "$build/bin/sinew" "$build/bin/libsinew_client.so.1" "$root" "${octave[@]}" steer.m
python3 -B "$root/tests/client/emd_test.py" "$build/bin/sinew" "$build/bin/libsinew_client.so.1" "$root" "${octave[@]}" emd.m
