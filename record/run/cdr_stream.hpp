#pragma once
// The recorder's own records as XCDR1, little-endian, behind the encapsulation header. msg/cdr.hpp encodes messages
// with a description; those have no sequences. Source: as there.
#include <string_view>
#include <type_traits>

#include "record/buffer.hpp"

namespace sinew::record {

inline constexpr std::byte kEncapsulation[4] = {std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}};

class CdrWriter {
 public:
  /// Replaces the content of `to`.
  explicit CdrWriter(Buffer& to) : CdrWriter(to, 0) {
    to_.clear();
    to_.append(kEncapsulation);
  }
  /// Continues where another writer stopped.
  static CdrWriter behind(Buffer& to) { return CdrWriter(to, 0); }
  template <class T>
  void number(T value) {
    static_assert(std::is_integral_v<T> || std::is_floating_point_v<T>);
    while ((to_.size() - sizeof kEncapsulation) % sizeof(T) != 0) to_.number(std::uint8_t{0});
    if constexpr (std::is_same_v<T, double>)
      to_.number(std::bit_cast<std::uint64_t>(value));
    else
      to_.number(value);
  }
  void boolean(bool value) { number(static_cast<std::uint8_t>(value)); }
  void text(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size() + 1));
    to_.append(as_bytes(text));
    to_.number(std::uint8_t{0});
  }
  /// The number of elements of a sequence; the elements follow.
  void length(std::size_t n) { number(static_cast<std::uint32_t>(n)); }

 private:
  CdrWriter(Buffer& to, int) : to_(to) {}
  Buffer& to_;
};

/// Reads any bytes safely: as Cursor.
class CdrReader {
 public:
  explicit CdrReader(std::span<const std::byte> bytes) : size_(bytes.size()), from_(bytes) {
    const auto head = from_.take(sizeof kEncapsulation);
    if (head.size() != sizeof kEncapsulation || head[0] != std::byte{0} || head[1] != std::byte{1})
      static_cast<void>(from_.take(~std::uint64_t{0}));  // makes good() false
  }
  bool good() const { return from_.good(); }
  bool at_end() const { return from_.good() && from_.rest().empty(); }
  std::span<const std::byte> rest() const { return from_.rest(); }

  template <class T>
  T number() {
    align(sizeof(T));
    if constexpr (std::is_same_v<T, double>)
      return std::bit_cast<double>(from_.number<std::uint64_t>());
    else if constexpr (std::is_signed_v<T>)
      return static_cast<T>(from_.number<std::make_unsigned_t<T>>());
    else
      return from_.number<T>();
  }
  bool boolean() { return number<std::uint8_t>() != 0; }
  std::span<const std::byte> bytes(std::size_t n) { return from_.take(n); }
  std::string_view text() {
    const auto bytes = from_.take(number<std::uint32_t>());
    return bytes.empty() ? std::string_view() : as_text(bytes.first(bytes.size() - 1));
  }
  /// Number of elements of a sequence, each of at least `smallest` bytes. A number that the input cannot hold is no
  /// good.
  std::uint32_t length(std::size_t smallest) {
    const auto n = number<std::uint32_t>();
    if (n <= from_.rest().size() / smallest) return n;
    static_cast<void>(from_.take(~std::uint64_t{0}));
    return 0;
  }

 private:
  void align(std::size_t to) {
    const std::size_t at = size_ - from_.rest().size() - sizeof kEncapsulation;
    static_cast<void>(from_.take((to - at % to) % to));
  }
  std::size_t size_;
  Cursor from_;
};

}  // namespace sinew::record
