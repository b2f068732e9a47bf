# Sends parts of files, one after the other: for each input line "offset length name" the bytes, then a line with the
# checksum of the file up to there. Arguments as in list.sh.
dir=$1 data=$2
case $dir in /*) ;; *) dir=$HOME/$dir ;; esac
cd "${data:-$dir/data}" || exit 30
echo '::sinew begin'
while read -r offset length name; do
  if [ ! -r "$name" ]; then
    echo "$name: permission denied" >&2
    exit 31
  fi
  tail -c "+$((offset + 1))" "$name" | head -c "$length"
  echo
  echo "::sinew end $(head -c "$((offset + length))" "$name" | cksum)"
done
