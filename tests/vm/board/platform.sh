# What a board must grant: fixed priorities, locked memory, a PREEMPT_RT kernel with its timers and its throttle.
uname -rv
grep -q PREEMPT_RT /proc/version
gtest hal/hal_linux_os_test
gtest hal/hal_linux_memory_test
gtest hal/hal_linux_process_test
gtest hal/hal_linux_buses_test --gtest_filter='-OpenError.PermissionDenied*' # an arm64 guest has no list of groups

$build/examples/example_real_time_loop | tee loop.txt
if grep "not granted" loop.txt; then fail "the executor did not get what it asked for"; fi

# The same, by what the kernel shows of a robot that runs.
$build/examples/example_own_program run "$root/examples/own_program.toml" --quiet --no-record --duration 20 &
robot=$!
thread_is_fixed() { grep -lsx loop /proc/$robot/task/*/comm >thread.txt && awk '$41 == 1 && $40 == 10' "$(dirname "$(cat thread.txt)")/stat" | grep -q .; }
eventually 15 thread_is_fixed
locked_kb=$(awk '/^VmLck:/ { print $2 }' /proc/$robot/status)
echo "VmLck of the robot: $locked_kb kB"
((locked_kb > 1000)) || fail "its memory is not locked"
kill -TERM $robot
wait $robot || fail "the robot ended with $?"
