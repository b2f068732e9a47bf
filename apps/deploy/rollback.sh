# Makes the previous version the running one. The present calibration stays in force.
# Arguments: folder.
dir=$1
now=$(readlink "$dir/app") && before=$(readlink "$dir/previous") && [ -d "$dir/$before" ] || exit 16
calibration=$(sed -n 's/^calibration=//p' "$dir/$now/deployed.txt")
if [ -n "$calibration" ] && [ -e "$dir/$now/$calibration" ]; then
  cp -p "$dir/$now/$calibration" "$dir/$before/$calibration" || exit 12
fi
ln -sfn "$before" "$dir/app.new" && mv -T "$dir/app.new" "$dir/app" || exit 15
ln -sfn "$now" "$dir/previous.new" && mv -T "$dir/previous.new" "$dir/previous" || exit 15
sync
echo "::sinew deployed $before"
sed -n 's/^about=//p' "$dir/app/deployed.txt"
