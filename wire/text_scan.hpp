#pragma once
// Reading short lines of text without a stream or the C library's locale.
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace sinew::wire {

/// Takes one piece after another from the front of a text. RT: yes.
class TextScan {
 public:
  explicit TextScan(std::string_view text) : rest_(text) {}
  std::string_view rest() const noexcept { return rest_; }
  bool empty() const noexcept { return rest_.empty(); }
  /// True and past it when the text goes on with `c`.
  bool take(char c) noexcept;
  void skip_blanks() noexcept;
  /// The text up to the next blank or the end, without leading blanks; empty: nothing is left.
  std::string_view word() noexcept;
  /// One digit 0-9A-Fa-f.
  std::optional<std::uint32_t> hex_digit() noexcept;
  /// Two of them; nothing is taken when there are not two.
  std::optional<std::uint8_t> hex_byte() noexcept;

 private:
  std::string_view rest_;
};

/// The whole text as a number of at most `digits` digits; nothing for any other character or an empty text. RT: yes.
std::optional<std::uint32_t> parse_hex(std::string_view text, std::size_t digits = 8) noexcept;
std::optional<std::uint64_t> parse_decimal(std::string_view text, std::size_t digits = 18) noexcept;
/// "SECONDS.FRACTION" in nanoseconds: up to 9e9 seconds, and 1 to 9 digits of fraction. RT: yes.
std::optional<std::int64_t> parse_seconds(std::string_view text) noexcept;

/// Writes text into a fixed buffer; remembers when a text did not fit. RT: yes.
class TextPut {
 public:
  explicit TextPut(std::span<char> into) : into_(into) {}
  TextPut& put(std::string_view text) noexcept;
  TextPut& hex(std::uint32_t value, int digits) noexcept;  // upper case, leading zeros
  TextPut& decimal(std::uint64_t value, int digits = 1) noexcept;
  /// "SECONDS.MICROSECONDS" of a time that is not negative.
  TextPut& seconds(std::int64_t ns) noexcept;
  /// 0 when it did not fit.
  std::size_t size() const noexcept { return fits_ ? used_ : 0; }

 private:
  std::span<char> into_;
  std::size_t used_ = 0;
  bool fits_ = true;
};

}  // namespace sinew::wire
