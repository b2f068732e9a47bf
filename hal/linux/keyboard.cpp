#include "hal/linux/keyboard.hpp"

#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <array>

namespace sinew::hal {
namespace {

constexpr Duration kRestOfKey = std::chrono::milliseconds(50);  // the bytes of one key may come in pieces

bool is_begun_arrow(std::string_view bytes) { return bytes == "\033" || bytes == "\033[" || bytes == "\033O"; }

bool keys_come_to_us() { return isatty(STDIN_FILENO) == 1 && tcgetpgrp(STDIN_FILENO) == getpgrp(); }

}  // namespace

std::optional<Key> take_key(std::string_view& bytes) {
  if (bytes.empty()) return std::nullopt;
  const bool arrow = bytes.size() >= 3 && bytes[0] == '\033' && (bytes[1] == '[' || bytes[1] == 'O');
  const char c = bytes[arrow ? 2 : 0];
  bytes.remove_prefix(arrow ? 3 : 1);
  if (!arrow) return c == ' ' ? Key::space : Key::other;
  switch (c) {
    case 'A':
      return Key::up;
    case 'B':
      return Key::down;
    case 'C':
      return Key::right;
    case 'D':
      return Key::left;
    default:
      return Key::other;
  }
}

struct Keyboard::Before {
  termios state{};
};

Keyboard::Keyboard(std::unique_ptr<Before> before) : before_(std::move(before)) {}

std::unique_ptr<Keyboard> Keyboard::open() {
  auto before = std::make_unique<Before>();
  if (!keys_come_to_us() || tcgetattr(STDIN_FILENO, &before->state) != 0) return nullptr;
  termios now = before->state;
  now.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  now.c_cc[VMIN] = 1, now.c_cc[VTIME] = 0;
  if (tcsetattr(STDIN_FILENO, TCSADRAIN, &now) != 0) return nullptr;
  return std::unique_ptr<Keyboard>(new Keyboard(std::move(before)));
}

Keyboard::~Keyboard() {
  if (keys_come_to_us()) tcsetattr(STDIN_FILENO, TCSADRAIN, &before_->state);
}

/// Appends what is there within the patience. False: nothing came.
bool Keyboard::read_more(Duration patience) {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  const auto wait_ms = std::chrono::duration_cast<std::chrono::milliseconds>(patience).count();
  // In the background a read would stop the process.
  if (poll(&input, 1, static_cast<int>(wait_ms)) <= 0 || !keys_come_to_us()) return false;
  std::array<char, 64> bytes{};
  const ssize_t n = read(STDIN_FILENO, bytes.data(), bytes.size());
  if (n > 0) pressed_.append(bytes.data(), static_cast<std::size_t>(n));
  return n > 0;
}

std::optional<Key> Keyboard::next(Duration patience) {
  if (pressed_.empty() && !read_more(patience)) return std::nullopt;
  while (is_begun_arrow(pressed_) && read_more(kRestOfKey)) {
  }
  std::string_view rest = pressed_;
  const auto key = take_key(rest);
  pressed_.erase(0, pressed_.size() - rest.size());
  return key;
}

}  // namespace sinew::hal
