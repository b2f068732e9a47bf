# shellcheck shell=bash
# The common functions of the sub-tests: `source`d before each, in the guest, as root.

root=${root:?} build=${build:?}

fail() {
  echo "FAILED: $*"
  exit 1
}

gtest_runner=() # the command in front of programs
# gtest PROGRAM [ARGUMENT...]: a GoogleTest program of the build, by its path below tests/. No case may be skipped: what is
# missing on a build machine is here.
gtest() {
  local program=$build/tests/$1 log status=0
  shift
  [[ -x $program ]] || fail "$program was not built"
  log=$(mktemp)
  "${gtest_runner[@]}" "$program" "$@" 2>&1 | tee "$log" || status=$?
  ((status == 0)) || fail "$(basename "$program"): exit code $status"
  if grep -qF '[  SKIPPED ]' "$log"; then fail "$(basename "$program"): cases were skipped"; fi
  grep -qE '^\[  PASSED  \] [1-9]' "$log" || fail "$(basename "$program"): no case ran"
}

# eventually SECONDS COMMAND...: tries it until it succeeds.
eventually() {
  local until=$((SECONDS + $1))
  shift
  until "$@"; do
    ((SECONDS < until)) || fail "not in time: $*"
    sleep 0.1
  done
}

# can_up: vcan0 to vcan3, which take CAN FD frames, and can0, can1: controllers with one wire between them.
can_up() {
  local i
  modprobe -a vcan can-raw kvaser_pci
  for i in 0 1 2 3; do
    [[ -e /sys/class/net/vcan$i ]] || ip link add "vcan$i" type vcan
    ip link set "vcan$i" mtu 72 up
  done
  for i in 0 1; do
    eventually 10 test -e "/sys/class/net/can$i"
    ip link set "can$i" down
    ip link set "can$i" type can bitrate 500000 restart-ms 100
    ip link set "can$i" txqueuelen 100 up
  done
}

# i2c_stub CHIP...: chips that only have registers; sets `adapter` to the number of their bus.
i2c_stub() {
  local chips
  chips=$(IFS=, && echo "$*")
  modprobe i2c-dev
  modprobe i2c-stub "chip_addr=$chips"
  adapter=$(basename "$(dirname "$(grep -ls "SMBus stub" /sys/bus/i2c/devices/i2c-*/name)")")
  adapter=${adapter#i2c-}
}

# iio_device NAME: sets `device` to the folder of the IIO device of that name.
iio_device() {
  local name
  device=
  for name in /sys/bus/iio/devices/iio:device*/name; do
    if [[ $(cat "$name") == "$1" ]]; then device=$(dirname "$name"); fi
  done
  [[ -n $device ]]
}

# Servos on CAN buses, see tests/vm/servo_buses.cpp. begin_drives PLACE...: the last one's can be ended by end_drives. They
# go before our scripts, for which a real drive does not wait.
begin_drives() {
  local place
  for place in "$@"; do
    nice -n -15 "$build/tests/vm/vm_servo_buses" drives "$place" >>drives.txt &
    drives=$!
  done
}
end_drives() { kill "$drives"; }
begin_master() {
  trap 'kill $(jobs -p) || true; cat drives.txt master.txt' EXIT
  "$build/tests/vm/vm_servo_buses" master "$@" >master.txt &
  master=$!
}
# reached WORD: the master has printed WORD.
reached() {
  local alive=1
  kill -0 "$master" 2>/dev/null || alive=0 # asked first: its last word may be WORD
  grep -qx "$1" master.txt && return
  ((alive)) || fail "the master ended before it was $1"
  return 1
}
