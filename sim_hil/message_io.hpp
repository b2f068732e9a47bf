#pragma once
// Cuts a byte stream into messages, and packs messages for one write. Pure; no allocation after construction.
#include <vector>

#include "sim_hil/protocol.hpp"

namespace sinew::sim_hil {

enum class Sender : std::uint8_t { runtime, plant };

struct Message {
  Header header;
  Bytes payload;                 // until the next space(); of a frame only the first kFrameBytes
  std::uint32_t bulk_bytes = 0;  // pixels behind a frame's payload, to be fetched with take_bulk()
};

/// Receives: read into space(), say filled(n), then next() until it returns false.
/// RT:      yes.
/// Errors:  bad_data at the first byte that breaks the framing (size, type, direction, flags, sequence, time); the
///          stream cannot be followed any further then, and every later call says so again.
class MessageReceiver {
 public:
  explicit MessageReceiver(Sender peer);
  std::span<std::byte> space() noexcept;  // never empty
  void filled(std::size_t bytes) noexcept { end_ += bytes; }
  hal::Result<bool> next(Message& out) noexcept;

  /// Pixels of the last frame: copies what has been received already, returns how much. next() discards the rest. When
  /// bulk_left() remains, they may be read from the stream directly: then say bulk_filled().
  std::size_t take_bulk(std::span<std::uint8_t> into) noexcept;
  std::size_t bulk_left() const noexcept { return bulk_left_; }
  std::size_t buffered() const noexcept { return end_ - begin_; }
  void bulk_filled(std::size_t bytes) noexcept { bulk_left_ -= bytes; }

 private:
  Sender peer_;
  std::vector<std::byte> buffer_;
  std::size_t begin_ = 0, end_ = 0, bulk_left_ = 0;
  std::uint32_t sequence_ = 0;
  hal::Status state_;
};

/// Packs messages one after the other; pending() is what one write has to send.
/// RT:      yes.
class MessageWriter {
 public:
  explicit MessageWriter(std::size_t capacity_bytes);
  /// False, and nothing changed, when there is no room: send pending() and clear() first.
  template <class Payload>
  [[nodiscard]] bool add(Type type, std::uint16_t device, Time time, const Payload& payload,
                         std::size_t bulk_bytes = 0) {
    if (room() < kHeaderBytes + max_bytes(payload)) return false;
    const std::size_t n = encode(payload, end() + kHeaderBytes);
    finish(type, device, time, n, bulk_bytes);
    return true;
  }
  [[nodiscard]] bool add(Type type, std::uint16_t device, Time time) noexcept;        // no payload
  [[nodiscard]] bool add_text(Type type, Time time, std::string_view text) noexcept;  // cut at kMaxTextBytes
  Bytes pending() const noexcept { return {buffer_.data(), used_}; }
  std::size_t room() const noexcept { return buffer_.size() - used_; }
  void clear() noexcept { used_ = 0; }
  /// Forgets the first bytes: they have been sent.
  void sent(std::size_t bytes) noexcept;

 private:
  template <class Payload>
  static std::size_t max_bytes(const Payload&) {
    return kTruthBytes;  // the largest message without a size of its own
  }
  static std::size_t max_bytes(const Sample<msg::JointState>&) {
    return kJointsHeadBytes + msg::kMaxChannels * kJointBytes;
  }
  static std::size_t max_bytes(const Sample<msg::Datagram>& d) { return kDatagramHeadBytes + d.value.bytes().size(); }
  static std::size_t max_bytes(const Transmission& t) { return t.size; }
  static std::size_t max_bytes(const Welcome& w) { return kWelcomeBytes + w.devices.size() * kDeviceBytes; }
  std::byte* end() noexcept { return buffer_.data() + used_; }
  void finish(Type type, std::uint16_t device, Time time, std::size_t payload, std::size_t bulk) noexcept;

  std::vector<std::byte> buffer_;
  std::size_t used_ = 0;
  std::uint32_t sequence_ = 0;
};

}  // namespace sinew::sim_hil
