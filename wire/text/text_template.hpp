#pragma once
// Commands as text with numbers in them: "DRIVE {Left %1.2f} {Right %1.2f}". A template names the few conversions of
// printf that a command needs; nothing else of printf is there: values are numbers, their count is checked when the
// template is read, and what is written never exceeds the buffer. No locale.
//
//   %d %i    whole number, rounded to the nearest (halves away from zero)
//   %u       the same, of values from 0 on
//   %f %F %e %E %g %G   as printf's, of finite values
//   %s       one of the template's words: value 0 is the first
//   %b       the bits of the value as a float, written as a whole number: what AR.Drone's AT commands want
//   %q       the link's next sequence number; takes no value
//   %%       a per cent sign
//
// Between % and the letter: flags - + 0 and blank, a width to 64, a precision to 17 (of f, e, g).
// Source:  ISO C 7.21.6.1 for what they mean; Parrot, AR.Drone Developer Guide 2.0 section 6.5 for %b.
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::wire {

class TextTemplate {
 public:
  /// `words`: of its %s. Nothing: `why` says what is wrong, and what is allowed.
  static std::optional<TextTemplate> parse(std::string_view text, std::vector<std::string> words, std::string& why);

  /// How many values write() takes.
  std::size_t values() const noexcept { return values_; }
  bool has_sequence() const noexcept { return has_sequence_; }
  const std::string& text() const noexcept { return text_; }

  /// Writes it with `values` (values() of them) and counts `sequence` up for each %q. Returns the characters written;
  /// 0: no room, a value that is not finite, a word that there is not. RT:      yes.
  std::size_t write(std::span<const double> values, std::uint32_t& sequence, std::span<char> out) const noexcept;

  static constexpr std::size_t kLongest = 1000;  // characters of a template
  static constexpr int kWidest = 64, kMostPrecise = 17;

 private:
  struct Piece {
    char kind = 0;                      // 0: text; else the letter of the conversion
    std::uint32_t begin = 0, size = 0;  // of text_
    bool left = false, plus = false, zero = false, blank = false;
    int width = 0, precision = -1;
  };
  static std::optional<std::size_t> parse_conversion(std::string_view text, Piece& piece, std::string& why);

  std::string text_;
  std::vector<std::string> words_;
  std::vector<Piece> pieces_;
  std::size_t values_ = 0;
  bool has_sequence_ = false;
};

}  // namespace sinew::wire
