// Uses the processor's idle time, so that a guest of counted time is never idle (tests/vm/guest/main.sh).
// Instructions that do nothing cost the host next to nothing: here the guest's time passes some times as fast as the
// host's on an idle host, and about as fast on one that is busy.
int main() {
  for (;;) asm volatile("nop\n nop\n nop\n nop\n nop\n nop\n nop\n nop");
}
