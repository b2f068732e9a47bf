#pragma once
// One SDO transfer at a time with one CANopen device.
#include <string_view>
#include <utility>

#include "drivers/joints/servo.hpp"
#include "wire/canopen.hpp"

namespace sinew::drivers {

/// Reads and writes objects of one device, one after the other, each asked again when no answer comes.
/// Thread:  the hub's.   RT: yes.
class SdoClient {
 public:
  enum class State : std::uint8_t { idle, busy, done, aborted, timeout };
  explicit SdoClient(std::uint32_t node) : node_(node) {}

  /// Begins; a transfer that was busy is forgotten. The frame goes out with the next tick().
  void start(const wire::Sdo& request) noexcept;
  /// At most one frame; kTries times in all, kPatience apart.
  void tick(Time now, FrameSink& out) noexcept;
  /// What came under the device's reply identifier. foreign: an answer that nobody asked for (any more).
  Heard on_reply(const msg::CanFrame& frame) noexcept;

  State state() const noexcept { return state_; }
  std::uint32_t value() const noexcept { return value_; }                     // done, up to four bytes
  std::string_view text() const noexcept { return {text_.data(), length_}; }  // done, of any length
  std::int32_t signed_value() const noexcept;  // the same, of an object with a sign and as many bytes as came
  /// True once: the last transfer was asked for once and answered twice, so there are two devices.
  bool answered_twice() noexcept { return std::exchange(twice_, false); }
  std::uint32_t abort_code() const noexcept { return abort_code_; }  // aborted
  void reset() noexcept { state_ = State::idle; }

  static constexpr Duration kPatience = std::chrono::milliseconds(50);
  static constexpr int kTries = 3;

 private:
  void finish(State state) noexcept { state_ = state; }
  void ask(const wire::Sdo& frame) noexcept;
  Heard on_segment(const wire::Sdo& reply) noexcept;

  std::uint32_t node_;
  State state_ = State::idle;
  wire::Sdo request_, frame_;  // what was asked for; the frame on its way (a segment of it)
  bool to_send_ = false, repeated_ = false, twice_ = false;
  int tries_ = 0;
  Time sent_{};
  std::uint32_t value_ = 0, abort_code_ = 0;
  std::array<char, 64> text_{};  // longer ones are cut
  std::size_t length_ = 0;
};

}  // namespace sinew::drivers
