# Lists recorded files: size, time of the last change, name. Arguments: folder of the deployment, folder of recorded
# runs ("": data in the folder of the deployment), and names in it.
dir=$1 data=$2
shift 2
case $dir in /*) ;; *) dir=$HOME/$dir ;; esac
cd "${data:-$dir/data}" || exit 30
echo "::sinew files $(date +%s)"
for folder; do
  if [ -d "$folder" ]; then find "$folder" -type f -exec stat -c '%s %Y %n' '{}' +; fi
done
