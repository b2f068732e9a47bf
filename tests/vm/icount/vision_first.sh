# limit_s: 120
# The measure detects misses: with vision above the loop, releases are missed.
$build/tests/vm/vm_lateness --vision-first
