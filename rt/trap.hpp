#pragma once
// Which step the calling thread is in, for the trap: test programs are linked with tests/trap, which replaces every
// allocating, locking and blocking call and looks here. In a program without it this is two thread-local writes a step.
#include <atomic>
#include <cstdint>

namespace sinew::rt::trap {

struct State {
  const char* module = nullptr;          // null: not inside a step
  std::uint32_t* best_effort = nullptr;  // where to count for a best-effort module; null: a trapped call is fatal
};

inline constinit thread_local State state{};

/// Marks the calling thread as inside a step of `module` for its lifetime.
/// Scopes nest: a test may set the trap around an executor's loop.
/// RT: yes.   Owner: `module` and the counter outlive the scope.
class Scope {
 public:
  explicit Scope(const char* module, std::uint32_t* best_effort = nullptr) noexcept : outer_(state) {
    state = {module, best_effort};
    fence();
  }
  ~Scope() {
    fence();
    state = outer_;
  }
  Scope(const Scope&) = delete;
  Scope& operator=(const Scope&) = delete;

 private:
  // Compilers assume that malloc reads no variables of the program; the trap's malloc does.
  static void fence() noexcept { std::atomic_signal_fence(std::memory_order_seq_cst); }

  const State outer_;
};

}  // namespace sinew::rt::trap
