# limit_s: 60
# Two joints over emulated SJA1000 controllers: master on can0, drives on can1, 500 kbit/s. The controllers' receive queue
# holds four frames, so their interrupt threads go before the hub's, as on a board that drives servos.
can_up
for task in /proc/[0-9]*; do
  if grep -qE '^irq/[0-9]+-can' "$task/comm"; then chrt --fifo -p 80 "${task#/proc/}"; fi
done
begin_drives 500000:can1:cia402:2
begin_master 200 400 0 500000:can0:cia402:2
eventually 15 reached arrived
end_drives
eventually 15 reached alone
begin_drives 500000:can1:cia402:2
eventually 15 reached again
wait $master
for bus in can0 can1; do # the queue never ran over
  (($(cat /sys/class/net/$bus/statistics/rx_over_errors) == 0)) || fail "$bus: frames were lost in the controller"
done
