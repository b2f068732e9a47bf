#pragma once
// Packets of Dynamixel servos, protocol 1.0 and 2.0, and of Feetech's, which are 1.0's with a Sync Read: built, found
// in a stream of bytes, and taken apart. Source:  ROBOTIS e-manual, "DYNAMIXEL Protocol 1.0", "DYNAMIXEL Protocol 2.0"
// and "CRC Calculation"; Feetech,
//          "Communication protocol of magnetic encoder servos" (SMS/STS) and its SCServo library for Sync Read.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "wire/frame_scanner.hpp"

namespace sinew::wire {

enum class DxlVersion : std::uint8_t { one = 1, two = 2 };

enum class DxlInstruction : std::uint8_t {
  ping = 0x01,
  read = 0x02,
  write = 0x03,
  reg_write = 0x04,
  action = 0x05,
  factory_reset = 0x06,
  reboot = 0x08,  // 2.0; Feetech's newer firmwares
  clear = 0x10,   // 2.0
  status = 0x55,  // 2.0: an answer
  sync_read = 0x82,
  sync_write = 0x83,
  fast_sync_read = 0x8A,  // 2.0
  bulk_read = 0x92,
  bulk_write = 0x93,     // 2.0
  fast_bulk_read = 0x9A  // 2.0
};
/// "sync read"; "0x7f" has none and is "unknown".
std::string_view to_string(DxlInstruction instruction);

inline constexpr std::uint8_t kDxlBroadcast = 0xFE;
inline constexpr std::uint8_t kDxlMostId1 = 253, kDxlMostId2 = 252;
constexpr std::uint8_t dxl_most_id(DxlVersion v) { return v == DxlVersion::one ? kDxlMostId1 : kDxlMostId2; }

/// Error numbers of a 2.0 status, bits 0 to 6. Bit 7 is the alert: the servo's Hardware Error Status says why.
enum class DxlError : std::uint8_t { none, result_fail, instruction, crc, data_range, data_length, data_limit, access };
inline constexpr std::uint8_t kDxlAlert = 0x80;
/// "data range"; for numbers that the protocol does not have "unknown".
std::string_view to_string(DxlError error);
/// Error bits of a 1.0 status.
inline constexpr std::uint8_t kDxl1Voltage = 0x01, kDxl1AngleLimit = 0x02, kDxl1Heat = 0x04, kDxl1Range = 0x08,
                              kDxl1Checksum = 0x10, kDxl1Overload = 0x20, kDxl1Instruction = 0x40;

/// CRC-16 with the polynomial 0x8005, most significant bit first, start 0 ("CRC-16/UMTS"; "123456789": 0xFEE8),
/// continued from `crc`. RT: yes.
std::uint16_t dxl_crc(std::span<const std::uint8_t> bytes, std::uint16_t crc = 0) noexcept;
/// Of 1.0: the complement of the sum of the bytes behind the header.
std::uint8_t dxl_checksum(std::span<const std::uint8_t> bytes) noexcept;

/// What a packet has beside its parameters: bytes on the line. 2.0 may add stuffing.
constexpr std::size_t dxl_instruction_bytes(DxlVersion v, std::size_t parameters) {
  return (v == DxlVersion::one ? 6 : 10) + parameters;
}
constexpr std::size_t dxl_status_bytes(DxlVersion v, std::size_t data) {
  return (v == DxlVersion::one ? 6 : 11) + data;
}
/// The one answer to a Fast Sync Read of `servos`, `data` bytes each.
constexpr std::size_t dxl_fast_status_bytes(std::size_t servos, std::size_t data) { return 8 + servos * (data + 4); }

/// FF FF ID LENGTH ... SUM.
struct Dxl1Format {
  static constexpr std::size_t kMaxFrame = 4 + 255;
  static FrameVerdict check(std::span<const std::uint8_t> bytes) noexcept;
};
/// FF FF FD 00 ID LENGTH LENGTH ... CRC CRC. Longer packets than kMaxFrame are not packets of ours.
struct Dxl2Format {
  static constexpr std::size_t kMaxFrame = 1024;
  static FrameVerdict check(std::span<const std::uint8_t> bytes) noexcept;
};

/// A whole packet. `parameters` is valid in the callback that gets it.
/// In 1.0 nothing tells an instruction from an answer: `code` is the instruction or the error bits, by who sent it.
struct DxlPacket {
  std::uint8_t id = 0;
  std::uint8_t code = 0;   // instruction; 1.0: or error bits
  std::uint8_t error = 0;  // 2.0 status: error byte; 1.0: `code` again
  std::span<const std::uint8_t> parameters;

  bool is(DxlInstruction what) const { return code == static_cast<std::uint8_t>(what); }
};

/// Finds packets of one protocol in the bytes of a line, and takes 2.0's stuffing out of them. The answer to a fast
/// read (status from id 0xFE) has none.
/// Thread:  owner.   RT: yes.
class DxlReader {
 public:
  explicit DxlReader(DxlVersion version) : version_(version) {}
  /// Calls on_packet(const DxlPacket&) for each packet that this byte completes.
  template <class OnPacket>
  void push(std::uint8_t byte, OnPacket&& on_packet) noexcept {
    const auto on_frame = [&](std::span<const std::uint8_t> frame) { on_packet(take_apart(frame)); };
    if (version_ == DxlVersion::one)
      one_.push(byte, on_frame);
    else
      two_.push(byte, on_frame);
  }
  /// The line is silent: what was begun will not go on; whole packets behind its head are found.
  template <class OnPacket>
  void gap(OnPacket&& on_packet) noexcept {
    const auto on_frame = [&](std::span<const std::uint8_t> frame) { on_packet(take_apart(frame)); };
    if (version_ == DxlVersion::one)
      one_.gap(on_frame);
    else
      two_.gap(on_frame);
  }
  /// The bytes so far are dropped.
  void gap() noexcept { one_.gap(), two_.gap(); }
  DxlVersion version() const { return version_; }
  const ScanStats& stats() const { return version_ == DxlVersion::one ? one_.stats() : two_.stats(); }

 private:
  DxlPacket take_apart(std::span<const std::uint8_t> frame) noexcept;

  DxlVersion version_;
  FrameScanner<Dxl1Format> one_;
  FrameScanner<Dxl2Format> two_;
  std::array<std::uint8_t, Dxl2Format::kMaxFrame> plain_{};  // without stuffing
};

/// One servo's part of the answer to a fast read.
struct DxlFastPart {
  std::uint8_t id = 0, error = 0;
  std::span<const std::uint8_t> data;
};
/// The parts of an answer to a fast read, in the order in which the servos were asked. Each part ends with the CRC of
/// all bytes before it; the last one is the packet's, which covers the others.
class DxlFastParts {
 public:
  /// `packet`: a status from id 0xFE; of another there are no parts.
  explicit DxlFastParts(const DxlPacket& packet) noexcept;
  /// The next part, of a servo that was asked for `size` bytes. False: there is none.
  bool next(std::size_t size, DxlFastPart& out) noexcept;

 private:
  std::uint8_t error_;
  std::span<const std::uint8_t> rest_;
};

/// Builds one packet. Thread: owner. RT: yes.
class DxlBuilder {
 public:
  /// An instruction; in 1.0 `code` may be the error bits of an answer.
  DxlBuilder(DxlVersion version, std::uint8_t id, std::uint8_t code) noexcept;
  DxlBuilder(DxlVersion version, std::uint8_t id, DxlInstruction what) noexcept
      : DxlBuilder(version, id, static_cast<std::uint8_t>(what)) {}
  static DxlBuilder status(DxlVersion version, std::uint8_t id, std::uint8_t error) noexcept;

  DxlBuilder& byte(std::uint8_t value) noexcept;
  /// Low byte first.
  DxlBuilder& word(std::uint16_t value) noexcept;
  DxlBuilder& bytes(std::span<const std::uint8_t> values) noexcept;
  /// An address or a number of bytes: a byte in 1.0, two in 2.0.
  DxlBuilder& place(std::uint16_t value) noexcept;
  /// Whether so many parameters still fit.
  bool fits(std::size_t parameters) const noexcept;

  /// The packet with stuffing, length and check; valid as long as this is. Empty: it did not fit.
  std::span<const std::uint8_t> finish() noexcept;

 private:
  void put(std::uint8_t value) noexcept;
  DxlVersion version_;
  bool overflow_ = false;
  std::size_t size_ = 0;
  std::array<std::uint8_t, Dxl2Format::kMaxFrame> buffer_{};
};

// Whole instructions. 1.0 has addresses and lengths up to 255.

DxlBuilder dxl_ping(DxlVersion v, std::uint8_t id) noexcept;
DxlBuilder dxl_read(DxlVersion v, std::uint8_t id, std::uint16_t address, std::uint16_t size) noexcept;
DxlBuilder dxl_write(DxlVersion v, std::uint8_t id, std::uint16_t address, std::span<const std::uint8_t> data) noexcept;
DxlBuilder dxl_reg_write(DxlVersion v, std::uint8_t id, std::uint16_t address,
                         std::span<const std::uint8_t> data) noexcept;
DxlBuilder dxl_action(DxlVersion v, std::uint8_t id) noexcept;
/// What a reset leaves as it is; 1.0 resets all.
enum class DxlKeep : std::uint8_t { nothing = 0xFF, id = 0x01, id_and_rate = 0x02 };
DxlBuilder dxl_factory_reset(DxlVersion v, std::uint8_t id, DxlKeep keep) noexcept;
DxlBuilder dxl_reboot(DxlVersion v, std::uint8_t id) noexcept;
/// 2.0: turns that were counted are forgotten; the position is within one turn again.
DxlBuilder dxl_clear_turns(std::uint8_t id) noexcept;
/// `size` bytes from `address` on of each id, in this order. `fast`: one answer for all (2.0).
DxlBuilder dxl_sync_read(DxlVersion v, std::uint16_t address, std::uint16_t size, std::span<const std::uint8_t> ids,
                         bool fast = false) noexcept;
/// Begins one; then for each servo byte(id) and bytes(of its `size` bytes).
DxlBuilder dxl_sync_write(DxlVersion v, std::uint16_t address, std::uint16_t size) noexcept;

/// One servo's part of a bulk read.
struct DxlPlace {
  std::uint8_t id = 0;
  std::uint16_t address = 0, size = 0;
};
/// Each id at most once. 1.0: the MX series alone has it.
DxlBuilder dxl_bulk_read(DxlVersion v, std::span<const DxlPlace> places, bool fast = false) noexcept;
/// 2.0. Begins one; then dxl_bulk_part() for each servo.
DxlBuilder dxl_bulk_write() noexcept;
void dxl_bulk_part(DxlBuilder& packet, std::uint8_t id, std::uint16_t address,
                   std::span<const std::uint8_t> data) noexcept;

}  // namespace sinew::wire
