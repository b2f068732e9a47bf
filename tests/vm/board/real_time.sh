# limit_s: 150
# The executor, its guardian and the kernel's throttle where fixed priorities are granted.
gtest rt/rt_real_time_test
gtest rt/rt_guardian_real_time_test
gtest rt/rt_throttle_test
