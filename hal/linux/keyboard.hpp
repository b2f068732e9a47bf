#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "hal/clock.hpp"

namespace sinew::hal {

enum class Key : std::uint8_t { space, left, right, up, down, other };

/// The first key of what a terminal sends, which is taken off `bytes`; nothing when there are none.
std::optional<Key> take_key(std::string_view& bytes);

/// Keys of the terminal at standard input, as they are pressed, not shown there. Ctrl-C goes on being a signal.
/// Thread:  owner.
class Keyboard {
 public:
  /// Null: standard input is no terminal, or one whose keys go to another job of its shell.
  static std::unique_ptr<Keyboard> open();
  ~Keyboard();  // the terminal is as before
  Keyboard(const Keyboard&) = delete;
  Keyboard& operator=(const Keyboard&) = delete;

  /// Waits for the next key, at most `patience`, or until a signal comes.
  std::optional<Key> next(Duration patience);

 private:
  struct Before;
  explicit Keyboard(std::unique_ptr<Before> before);
  bool read_more(Duration patience);
  std::unique_ptr<Before> before_;
  std::string pressed_;  // bytes that were not taken yet
};

}  // namespace sinew::hal
