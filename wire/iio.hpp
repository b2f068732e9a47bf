#pragma once
// Scans of the kernel's Industrial I/O: how channels lie in the bytes of /dev/iio:deviceN; each says its byte order.
// Source:  Linux Documentation/ABI/testing/sysfs-bus-iio (scan_elements/*_type, *_index, in_mount_matrix) and
//          Documentation/iio/iio_devbuf.rst; alignment as in drivers/iio/industrialio-buffer.c.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace sinew::wire {

/// One channel's form, written "[be|le]:[s|u]bits/storagebitsXrepeat[>>shift]": "le:s16/16>>0", "be:u12/16>>4".
struct IioForm {
  bool big_endian = false, is_signed = false;
  std::uint8_t bits = 0;          // that count
  std::uint8_t storage_bits = 0;  // 8, 16, 32 or 64
  std::uint8_t shift = 0;         // to the right, before the mask
  std::uint8_t repeat = 1;        // numbers in the channel
  std::size_t bytes() const { return storage_bits / 8u * repeat; }
};
/// Nothing: the text is not of that form, or describes an impossible one (bits + shift > storage).
std::optional<IioForm> parse_iio_form(std::string_view text) noexcept;

/// A channel of a scan: its form, and where its bytes begin.
struct IioChannel {
  std::uint32_t index = 0;
  IioForm form;
  std::size_t offset = 0;
};

/// The channels that are switched on, in the order of their indexes; each lies at a multiple of its size, and the scan
/// is padded to a multiple of its largest channel.
class IioLayout {
 public:
  static constexpr std::size_t kMaxChannels = 32;
  /// False: no room, or an index that is there already; nothing changed then.
  bool add(std::uint32_t index, const IioForm& form) noexcept;
  /// Null: no such channel.
  const IioChannel* find(std::uint32_t index) const noexcept;
  std::span<const IioChannel> channels() const noexcept { return {channels_.data(), count_}; }
  std::size_t scan_bytes() const noexcept { return scan_bytes_; }

 private:
  void place() noexcept;
  std::array<IioChannel, kMaxChannels> channels_{};
  std::size_t count_ = 0, scan_bytes_ = 0;
};

/// The number of a channel in a scan (64-bit unsigned ones as the same bits); 0 where the scan is too short.
std::int64_t iio_raw(std::span<const std::uint8_t> scan, const IioChannel& channel, std::size_t repeat = 0) noexcept;
/// Puts a number where iio_raw() reads it; what does not fit into the channel's bits is cut off.
void put_iio_raw(std::span<std::uint8_t> scan, const IioChannel& channel, std::int64_t value) noexcept;

/// "0.000598550" or "9810" as sysfs writes numbers; nothing: another text.
std::optional<double> parse_iio_number(std::string_view text) noexcept;
/// "x1, y1, z1; x2, ...; x3, ...": takes the chip's coordinates to the board's. Row by row.
std::optional<std::array<double, 9>> parse_iio_mount_matrix(std::string_view text) noexcept;

}  // namespace sinew::wire
