#pragma once
// A pipe to or from a child process. Internal to hal/linux.

namespace sinew::hal {

/// Both ends of a pipe; an end that was closed is -1. Programs that are started inherit neither.
/// Thread:  owner.
struct Pipe {
  int read = -1, write = -1;

  /// False: it could not be made (errno).
  bool open();
  static void close(int& end);

  Pipe() = default;
  ~Pipe();
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
};

}  // namespace sinew::hal
