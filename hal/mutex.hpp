#pragma once

namespace sinew::hal {

/// Mutual exclusion between threads of different priorities. What a platform makes of it inherits priority: while a
/// more urgent thread waits, the holder runs as urgently, so that no third thread comes between them.
/// Thread: any.
class Mutex {
 public:
  virtual ~Mutex() = default;
  virtual void lock() noexcept = 0;
  virtual void unlock() noexcept = 0;
};

}  // namespace sinew::hal
