# Prints facts about the board and the rights of this login: lines key=value behind the mark, read by parse_board().
# Arguments: folder of the deployment.
dir=$1
case $dir in /*) ;; *) dir=$HOME/$dir ;; esac
echo '::sinew board'
echo "dir=$dir"
echo "machine=$(uname -m)"
echo "user=$(id -un)"
uid=$(id -u)
echo "uid=$uid"
near=$dir
while [ ! -e "$near" ]; do near=$(dirname "$near"); done
if [ -w "$near" ]; then echo writes=yes; else echo writes=no; fi
if [ "$uid" = 0 ]; then
  echo root=yes
elif ! command -v sudo >/dev/null 2>&1; then
  echo root=no
elif sudo -n true 2>/dev/null; then
  echo root=sudo
else
  echo root=password
fi
df -Pk "$near" 2>/dev/null | {
  read -r _
  read -r _ _ _ free _ && echo "free_kib=$free"
}
if command -v tar >/dev/null 2>&1; then echo tar=yes; fi
if systemctl list-units >/dev/null 2>&1; then echo systemd=yes; fi
echo "cpus=$(cat /sys/devices/system/cpu/online 2>/dev/null)"
for group in video render dialout i2c spi gpio iio input plugdev; do
  if getent group "$group" >/dev/null 2>&1; then echo "group=$group"; fi
done
