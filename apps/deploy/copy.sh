# Unpacks a tar stream, tries the new version, and only then makes it the running one.
# Arguments: folder, robot file, calibration file ("": none), free text about this version, board ("": the file's).
# Exit codes are those of BoardStep in apps/deploy/deploy_plan.hpp.
dir=$1 robot=$2 calibration=$3 about=$4 board=$5
umask 022
fresh=$dir/incoming
if ! { mkdir -p "$dir" && rm -rf "$fresh" && mkdir "$fresh"; }; then exit 10; fi
trap 'rm -rf "$fresh"' EXIT
trap 'exit 99' HUP INT TERM
tar -xf - --no-same-owner -C "$fresh" || exit 11
if [ -n "$calibration" ] && [ -e "$dir/app/$calibration" ]; then
  mkdir -p "$(dirname "$fresh/$calibration")" && cp -p "$dir/app/$calibration" "$fresh/$calibration" || exit 12
  echo '::sinew calibration kept'
fi
{
  echo "about=$about, $(date -u '+%Y-%m-%d %H:%M UTC')"
  echo "robot=$robot"
  echo "calibration=$calibration"
} >"$fresh/deployed.txt" || exit 12
echo '::sinew libraries'
LD_TRACE_LOADED_OBJECTS=1 "$fresh/bin/sinew" --version </dev/null 2>&1
echo '::sinew version'
"$fresh/bin/sinew" --version </dev/null || exit 13
echo '::sinew check'
"$fresh/bin/sinew" check "$fresh/$robot" ${board:+--board "$board"} </dev/null 2>&1 || exit 14
sync
last=0
for version in "$dir"/version-*; do
  number=${version##*/version-}
  case $number in *[!0-9]* | '') continue ;; esac
  if [ "$number" -gt "$last" ]; then last=$number; fi
done
next=version-$((last + 1))
before=$(readlink "$dir/app")
mv "$fresh" "$dir/$next" && ln -sfn "$next" "$dir/app.new" && mv -T "$dir/app.new" "$dir/app" || exit 15
if [ -n "$before" ]; then
  ln -sfn "$before" "$dir/previous.new" && mv -T "$dir/previous.new" "$dir/previous" || exit 15
fi
for version in "$dir"/version-*; do
  case ${version##*/} in "$next" | "$before") ;; *) rm -rf "$version" ;; esac
done
sync
echo "::sinew deployed $next"
