# limit_s: 60
# 20 joints at 500 Hz on four virtual buses, of four kinds; error frames on the first bus; then the last bus goes silent
# and comes back, and the other joints do not notice.
can_up
for ((i = 0; i < 20; ++i)); do # a driver's word for: receiver warned, a bit was wrong
  echo "($i.000000) vcan0 2000008C#0004000000000000" >>errors.txt
done
idle_ns() { awk '{ print $1 }' "/proc/$(pgrep -x vm_busy)/schedstat"; } # vm_busy takes the rest of the processor
now_ns() { awk '{ printf "%.0f", $1 * 1e9 }' /proc/uptime; }
begin_drives 1000000:vcan0:cia402:5 1000000:vcan1:ak80:5 1000000:vcan2:cybergear:5 1000000:vcan3:damiao:5
begin_master 500 500 20 1000000:vcan0:cia402:5 1000000:vcan1:ak80:5 1000000:vcan2:cybergear:5 1000000:vcan3:damiao:5
eventually 15 reached running
idle=$(idle_ns) from=$(now_ns)
# One program sends them: the joints leave little of the processor to start 20.
canplayer -t -I errors.txt
eventually 15 reached arrived
echo "20 joints, their drives and these scripts left $((100 * ($(idle_ns) - idle) / ($(now_ns) - from))) % of the processor"
end_drives
eventually 15 reached alone
begin_drives 1000000:vcan3:damiao:5
eventually 15 reached again
wait $master
