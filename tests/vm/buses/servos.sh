# limit_s: 60
# 20 joints at 500 Hz on four virtual buses, of four kinds; error frames on the first bus; then the last bus goes silent
# and comes back, and the other joints do not notice.
can_up
for ((i = 0; i < 20; ++i)); do # a driver's word for: receiver warned, a bit was wrong
  echo "($i.000000) vcan0 2000008C#0004000000000000" >>errors.txt
done
begin_drives 1000000:vcan0:cia402:5 1000000:vcan1:ak80:5 1000000:vcan2:cybergear:5 1000000:vcan3:damiao:5
begin_master 500 500 20 1000000:vcan0:cia402:5 1000000:vcan1:ak80:5 1000000:vcan2:cybergear:5 1000000:vcan3:damiao:5
eventually 15 reached running
# By one program: the joints leave 5 to 15 % of the processor, of which starting 20 takes an arm64 more than ten seconds.
canplayer -t -I errors.txt
eventually 15 reached arrived
end_drives
eventually 15 reached alone
begin_drives 1000000:vcan3:damiao:5
eventually 15 reached again
wait $master
