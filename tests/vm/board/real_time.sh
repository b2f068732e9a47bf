# limit_s: 150
# The executor, its guardian and the kernel's throttle where fixed priorities are granted. Some of the steps spin until the
# test releases them. The test itself has a fixed priority, too: on PREEMPT_RT a thread of priority 1 runs the timers of
# ordinary threads, and a thread that spins above it starves it for good.
gtest_runner=(chrt --fifo 97)
gtest rt/rt_real_time_test
gtest rt/rt_guardian_real_time_test
gtest rt/rt_throttle_test
