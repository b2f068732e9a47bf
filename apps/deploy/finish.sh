# Checks the machine for this robot (doctor). With a unit: installs, enables and starts it; the unit comes on stdin.
# Arguments: folder, robot file, folder of runs, unit ("": none), folder of units, user of the unit, start (yes, no),
# board instead of the robot file's ("": none).
dir=$1 robot=$2 data=$3 unit=$4 units=$5 user=$6 start=$7 board=$8
echo '::sinew doctor'
"$dir/app/bin/sinew" doctor "$dir/app/$robot" ${board:+--board "$board"} </dev/null 2>&1
ill=$?
echo "::sinew doctor-ended $ill"
if [ -z "$unit" ]; then exit 0; fi
if ! id "$user" >/dev/null 2>&1; then
  useradd --system --user-group --no-create-home --home-dir "$data" --shell /usr/sbin/nologin "$user" || exit 20
  echo "::sinew user-made $user"
fi
if ! { mkdir -p "$data" && chown "$user:" "$data"; }; then exit 21; fi
if ! runuser -u "$user" -- test -x "$dir/app/bin/sinew"; then exit 22; fi
if ! { cat >"$units/$unit.new" && chmod 644 "$units/$unit.new" && mv "$units/$unit.new" "$units/$unit"; }; then exit 23; fi
if ! { systemctl daemon-reload && systemctl enable "$unit"; }; then exit 24; fi
echo "::sinew enabled $unit"
if [ "$start" != yes ]; then exit 0; fi
if [ "$ill" != 0 ]; then exit 25; fi
if systemctl is-active --quiet "$unit"; then exit 26; fi
if ! systemctl start "$unit"; then exit 27; fi
sleep 2
if ! systemctl is-active --quiet "$unit"; then
  echo '::sinew status'
  systemctl status --no-pager --lines 20 "$unit" 2>&1
  exit 27
fi
echo "::sinew started $unit"
