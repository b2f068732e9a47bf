# limit_s: 190
# only: amd64
# The guest is the second host of a team, with a clock of its own: it has the robot `follower`. The world and the robot `scout`
# are on the host, in follower.host.py, which also judges. The robots hear each other by UDP, through qemu's network.
modprobe virtio_net
eventually 10 test -e /sys/class/net/eth0
ip address add 10.0.2.15/24 dev eth0
ip link set eth0 up

shared=$results/follower
# The host's part begins when it sees this. The program is read from the host meanwhile, not during the flight.
date +%s >guest_clock && mv guest_clock "$shared/guest_clock"
{ LD_TRACE_LOADED_OBJECTS=1 "$build/bin/sinew" | awk '$3 ~ "^/" { print $3 }' && echo "$build/bin/sinew"; } |
  sort -u | while read -r file; do [[ ! -f $file ]] || cat "$file"; done >/dev/null
eventually 60 test -f "$shared/world"
source "$shared/world" # plant_port, scout_port, arguments

export SINEW_RUN_DIR=/tmp/run
mkdir -m 700 run
status=0
$build/bin/sinew run "$root/tests/vm/team/follower.toml" --plant "tcp:10.0.2.2:$plant_port" --board-of radio=linux \
  --set device.radio.port=4580 --set "device.radio.peers=10.0.2.2:$scout_port" "${arguments[@]}" --runs /tmp/runs --json \
  >follower.json 2>follower.txt || status=$?
cat follower.txt
cp runs/follower-*/run.mcap "$shared/follower.mcap"
cp follower.json "$shared/follower.new" && mv "$shared/follower.new" "$shared/follower.json"
eventually 60 test -f "$shared/verdict"
cat "$shared/verdict"
((status == 0)) || fail "the follower ended with $status"
grep -qx good "$shared/verdict" || fail "the host's part says what was not as it should be"
