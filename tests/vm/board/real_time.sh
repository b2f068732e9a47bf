# limit_s: 150
# The executor, its guardian and the kernel's throttle where fixed priorities are granted. Some of the steps spin until the
# test lets them go: the test itself has a fixed priority, too, for on PREEMPT_RT the timers of ordinary threads are run by
# a thread of priority 1, which one that spins above it starves for good.
gtest_runner=(chrt --fifo 97)
gtest rt/rt_real_time_test
gtest rt/rt_guardian_real_time_test
gtest rt/rt_throttle_test
