// Spends the processor that nobody else wants, so that a guest of counted time is never idle (tests/vm/guest/main.sh):
// one instruction in a circle, which costs the host about as much time as the guest.
int main() {
  for (;;) asm volatile("");
}
