// Replaces the trap where it is not linked: in sanitizer builds, and on Windows, which has no trap and no weak symbols.
namespace sinew::trap {
#ifndef _WIN32
[[gnu::weak]] bool is_set();
#endif
bool is_set() { return false; }
}  // namespace sinew::trap
