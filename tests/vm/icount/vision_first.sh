# limit_s: 120
# The measure sees what it is for: with vision above the loop, releases are missed.
$build/tests/vm/vm_lateness --vision-first
