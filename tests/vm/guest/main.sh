#!/usr/bin/env bash
# Runs the sub-tests of the job in the guest, one after the other; guest/init starts it in its own place.
# shellcheck disable=SC1091,SC2016  # the job is written at each boot; "$0" is what the inner shell knows
results=$1
export PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/tmp LANG=C.UTF-8 TERM=linux

root='' build='' folder='' shell=0 names=()
source "$results/job"
hostname sinew-vm
ip link set lo up
ip route add 224.0.0.0/4 dev lo
modprobe configfs
mount -t configfs config /sys/kernel/config
export root build results
cd /tmp || exit 1
# So far a shell has kept the processor busy, at ten times the cost for the host.
if [[ -e /dev/vm_busy ]]; then
  nice -n 19 "$build/tests/vm/vm_busy" &
  kill "$(cat /dev/vm_busy)"
fi

# run NAME: a sub-test in a shell of its own; its processes end with it.
run() {
  local limit_s code=0 from
  limit_s=$(sed -n 's/^# limit_s: //p' "$root/tests/vm/$folder/$1.sh")
  from=$(cut -d. -f1 /proc/uptime)
  setsid --wait timeout -k 5 "${limit_s:-60}" bash -c 'set -euo pipefail; source "$0"; source "$1"' \
    "$root/tests/vm/guest/lib.sh" "$root/tests/vm/$folder/$1.sh" </dev/null >"$results/$1.log" 2>&1 || code=$?
  ((code != 124)) || echo "stopped after ${limit_s:-60} s" >>"$results/$1.log"
  echo "$code $(($(cut -d. -f1 /proc/uptime) - from))" >"$results/$1.result"
}

if ((shell)); then
  cd "$root" || exit 1
  echo "exit ends the machine; '. tests/vm/guest/lib.sh' has the helpers of the sub-tests"
  setsid --ctty --wait bash -i
else
  begun=$(cut -d. -f1 /proc/uptime)
  for name in "${names[@]}"; do run "$name"; done
  dmesg >"$results/kernel.log"
  echo "${#names[@]} sub-tests in $(($(cut -d. -f1 /proc/uptime) - begun)) s, up after $begun s" >"$results/finished"
fi
sync
busybox poweroff -f
