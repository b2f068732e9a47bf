// Stands in where the trap is not linked (sanitizer builds).
namespace sinew::trap {
[[gnu::weak]] bool is_set() { return false; }
}  // namespace sinew::trap
