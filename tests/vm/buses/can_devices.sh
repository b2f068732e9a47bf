# limit_s: 60
# The buses that the other CAN sub-tests use, tried with foreign tools: four virtual ones for frames of 64 bytes,
# and two emulated SJA1000 controllers on one wire at 500 kbit/s.
can_up
hears() { grep -qE "^ *$1 " /proc/net/can/rcvlist_all; } # a listener that wants every frame of that bus

for bus in vcan0 vcan3; do
  candump -L -n 1 -T 30000 "$bus" >heard.txt &
  listener=$!
  eventually 30 hears "$bus"
  cansend "$bus" 123##1112233445566778899aabbcc
  wait $listener
  grep -qE "$bus 123##[0-9A-F]112233445566778899AABBCC" heard.txt || fail "$bus: a frame of 12 bytes was not heard: $(cat heard.txt)"
done

candump -L -n 200 -T 20000 can1 >heard.txt &
listener=$!
eventually 30 hears can1
cangen can0 -g 2 -n 200 -I i -L 8 -D i
wait $listener
(($(wc -l <heard.txt) == 200)) || fail "can1 heard $(wc -l <heard.txt) of 200 frames"
ip -details -statistics link show can0 | tee can0.txt
grep -q "state ERROR-ACTIVE" can0.txt
grep -q "bitrate 500000" can0.txt
