# limit_s: 120
# A 1 kHz thread under a vision load is never late by a release, and p50, p99 are within a factor 2 of the reference's.
$build/tests/vm/vm_lateness "$root/tests/vm/icount/reference_$(uname -m).txt"
