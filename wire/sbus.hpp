#pragma once
// SBUS of Futaba and FrSky receivers: 100000 bit/s, 8E2, inverted; a frame each 7 or 14 ms. Channels are packed with
// the lowest bit first (rc_channels.hpp); all else is single bytes.
// Source:  no public standard; layout as in Betaflight src/main/rx/sbus.c and PX4 src/lib/rc/sbus.cpp.
#include <array>
#include <cstdint>
#include <span>

#include "wire/frame_scanner.hpp"
#include "wire/rc_channels.hpp"

namespace sinew::wire {

struct SbusFrame {
  RcCounts channel{};
  bool channel_17 = false, channel_18 = false;  // switches
  bool frame_lost = false;                      // the receiver missed this one; the channels are those of before
  bool failsafe = false;                        // no transmitter: the channels are made up
};

/// 0x0F, 22 bytes of channels, flags, end (0x00; SBUS2: 0x04, 0x14, 0x24, 0x34).
struct SbusFormat {
  static constexpr std::size_t kMaxFrame = 25;
  static FrameVerdict check(std::span<const std::uint8_t> bytes) noexcept;
};

/// Finds frames. They have no checksum, and a stick can look like a head. So a frame counts only after a pause on the
/// line (gap()), or right behind another frame: a stream that was cut anywhere, or carries garbage, moves no stick.
/// Thread:  owner.   RT: yes.
class SbusScanner {
 public:
  template <class OnFrame>
  void push(std::uint8_t byte, OnFrame&& on_frame) noexcept {
    const std::uint64_t skipped = scanner_.stats().skipped_bytes;
    scanner_.push(byte, [&](std::span<const std::uint8_t> bytes) {
      if (trusted_)
        on_frame(decode(bytes));
      else
        ++untrusted_;
      trusted_ = true;
    });
    if (scanner_.stats().skipped_bytes != skipped) trusted_ = false;
  }
  /// Nothing came for 2 ms or more.
  void gap() noexcept {
    scanner_.gap();
    trusted_ = true;
  }
  const ScanStats& stats() const noexcept { return scanner_.stats(); }
  /// Frames that were not believed.
  std::uint64_t untrusted() const noexcept { return untrusted_; }

 private:
  static SbusFrame decode(std::span<const std::uint8_t> bytes) noexcept;
  FrameScanner<SbusFormat> scanner_;
  bool trusted_ = false;
  std::uint64_t untrusted_ = 0;
};

/// For simulated receivers.
std::array<std::uint8_t, 25> encode_sbus(const SbusFrame& frame) noexcept;

}  // namespace sinew::wire
