#pragma once
#include <array>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "hal/buses.hpp"

namespace sinew::drivers {

/// Opens the line anew each time: hal::Connectors::serial() with its spec, or a simulated one.
using SerialOpener = std::function<hal::Result<std::unique_ptr<hal::Serial>>(std::string& why)>;

/// A serial line that is opened again after it was gone.
/// Thread:  owner.   Errors: those of opening and of hal::Serial.
class SerialLine {
 public:
  explicit SerialLine(SerialOpener opener) : open_(std::move(opener)) {}
  hal::Status open(std::string& why) {
    line_.reset();  // held exclusively: the old one first
    auto line = open_(why);
    if (!line) return line.error();
    line_ = std::move(*line);
    return {};
  }
  hal::Serial* get() const noexcept { return line_.get(); }
  /// Hands over what is there now, at most a few reads of it. Errors: with words in `why`.
  template <class OnBytes>
  hal::Status read(OnBytes&& on_bytes, std::string& why) {
    std::array<std::uint8_t, 256> space{};
    for (int i = 0; i < 8; ++i) {
      const auto n =
          line_ ? line_->read_now(space) : hal::Result<std::size_t>(hal::Error{hal::Errc::closed, "serial: not open"});
      if (!n) {
        why = n.error().code == hal::Errc::closed ? "the serial line is gone (unplugged?)"
                                                  : std::string("serial line: ") + hal::to_string(n.error().code) +
                                                        " (errno " + std::to_string(n.error().detail) + ")";
        return n.error();
      }
      if (*n == 0) return {};
      on_bytes(std::span<const std::uint8_t>(space.data(), *n));
    }
    return {};
  }
  /// Errors: timeout when the line takes no more.
  hal::Status write(std::span<const std::uint8_t> bytes) {
    const auto n = line_->write_now(bytes);
    if (!n) return n.error();
    if (*n != bytes.size()) return hal::Error{hal::Errc::timeout, "serial: no room"};
    return {};
  }

 private:
  SerialOpener open_;
  std::unique_ptr<hal::Serial> line_;
};

}  // namespace sinew::drivers
