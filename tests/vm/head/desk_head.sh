# limit_s: 120
# The desk head follows its ball for 30 s: servos on the kernel's CAN, IMU from the kernel's bmi160 driver, the loops at
# fixed priorities in locked memory. sinew-sim, on the same processor, is the world that it moves and sees.
modprobe -a vcan can-raw industrialio-triggered-buffer kfifo_buf industrialio-sw-trigger iio-trig-hrtimer
ip link add vcan0 type vcan
ip link set vcan0 txqueuelen 100 up
mkdir /sys/kernel/config/iio/triggers/hrtimer/hr0
i2c_stub 0x69
$build/tests/vm/vm_i2c_registers "$adapter" 0x69 0x00=0xd1 0x40=0x2b 0x41=0x05 0x42=0x2b 0x43=0x00 # 800 Hz, 4 g, 2000 deg/s
modprobe bmi160_i2c
echo bmi160 0x69 >"/sys/bus/i2c/devices/i2c-$adapter/new_device"
eventually 10 iio_device bmi160

export SINEW_RUN_DIR=/tmp/run SINEW_RECORD=off LP_NUM_THREADS=0 LP_NATIVE_VECTOR_WIDTH=128
mkdir -m 700 run world
$build/bin/sinew-sim --world desk_head --seed 2 --camera 160x120 --listen unix:/tmp/head.sock --report report.json \
  --can socketcan:vcan0 --servo cia402:1 --servo cia402:2 --iio /tmp/world >world.txt 2>&1 &
world=$!
trap 'kill $(jobs -p) 2>/dev/null || true; cat world.txt feeder.txt robot.txt report.json' EXIT
eventually 60 test -S head.sock
# Files that the programs read for the first time come from the host: read them now, not during the run.
{ awk '$6 ~ "^/" { print $6 }' /proc/$world/maps && LD_TRACE_LOADED_OBJECTS=1 "$build/bin/sinew" | awk '$3 ~ "^/" { print $3 }' && echo "$build/bin/sinew"; } |
  sort -u | while read -r file; do [[ ! -f $file ]] || cat "$file"; done >/dev/null
chrt --fifo 84 "$build/tests/vm/vm_chip_feeder" /tmp/world "$adapter" 0x69 >feeder.txt 2>&1 &
feeder=$!

# The world has the same processor, in software, and draws with what the robot leaves of it: a step once took 3 ms, and
# of 958 frames 61 came late and 2 not at all. An arm64 of as many instructions a second draws 19 of the 30 pictures a
# second (561 in 30 s; 610 when they have 96x72, so it is not for their pixels): the head has to follow with these.
late_percent=15 lost=10
[[ $(uname -m) == x86_64 ]] || late_percent=70 lost=450
{ cat "$root/robots/desk_head/desk_head.toml" && printf '\n[sim.bounds]\nplant_gap_ms = 5\nframes_late_percent = %d\nlost = %d\n' $late_percent $lost; } >head.toml
$build/bin/sinew run head.toml --board linux --board-of camera=sim --plant unix:/tmp/head.sock \
  --real-actuators --duration 30 --json --no-record --set bus.can0.address=vcan0 \
  --set device.imu.name=bmi160 --set device.imu.trigger=hr0 --set device.imu.rate_hz=800 >robot.txt 2>&1 &
robot=$!
steer_is_fixed() { # at priority 80, in the parent's child
  for runtime in $(cat /proc/$robot/task/*/children); do
    grep -lsx steer /proc/"$runtime"/task/*/comm >thread.txt &&
      awk '$41 == 1 && $40 == 80' "$(dirname "$(cat thread.txt)")/stat" | grep -q . && return
  done
  return 1
}
eventually 60 steer_is_fixed
locked_kb=$(awk '/^VmLck:/ { print $2 }' "/proc/$runtime/status")
((locked_kb > 1000)) || fail "the robot's memory is not locked: $locked_kb kB"

status=0
wait $robot || status=$?
ip -statistics link show vcan0
wait $world || fail "sinew-sim ended with $?"
wait $feeder || fail "the feeder ended with $?"
((status == 0)) || fail "the robot ended with $status"
