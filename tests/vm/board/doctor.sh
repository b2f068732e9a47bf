# `sinew doctor` names what this board has, and for a user without privileges what it lacks.
$build/bin/sinew doctor | tee root.txt
clock=tsc
[[ $(uname -m) == x86_64 ]] || clock=arch_sys_counter
for held in "sched_fifo " "memory_lock " "preemption .*PREEMPT_RT" "hres_timers " "clock_source .*$clock"; do
  grep -qE "^ok +$held" root.txt || fail "not held: $held"
done
grep -q " 0 problems" root.txt

status=0
setpriv --reuid 65534 --regid 65534 --clear-groups --bounding-set -all --inh-caps -all \
  "$build/bin/sinew" doctor >user.txt || status=$?
cat user.txt
((status == 1)) || fail "exit code $status instead of 1"
grep -qE "^problem +sched_fifo" user.txt || fail "a refusal of fixed priorities is not named"
grep -qE "^ok +preemption" user.txt
