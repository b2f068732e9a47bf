#pragma once
// The text lines of USARSim: "TYPE {Key value} {Key value} ..." with CR or LF behind them, over TCP (port 3000). The
// same syntax both ways: INIT, DRIVE, SET, GETGEO, ... of a client; NFO, STA, SEN, MISSTA, GEO, CONF, ... of the
// simulator.
//
//   UsarLines lines;                                     // bytes in, lines out
//   if (lines.push(c) && parse_usarsim(lines.line(), line) == UsarError::none)
//     height_m = usar_number(line.find("Location").value, 2);
//
//   UsarWriter out(buffer);                              // and back
//   out.type("SEN").number("Time", 42.9771, 4).text("Type", "GroundTruth").vector("Location", xyz, 2);
//   send(out.line());                                    // with CR LF; empty: it did not fit
//
// Source:  USARSim manual V3.1.3; robocup-usarsim, MessageParser.uc; a captured AirRobot session.
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace sinew::wire {

inline constexpr std::size_t kUsarLine = 4096;  // characters of a line; a range scanner of 360 beams has some 2500
inline constexpr std::size_t kUsarParts = 128;  // keys of a line; a humanoid's state has 26

/// One key and its value, without blanks around them. Points into the line.
struct UsarPart {
  std::string_view key, value;
  std::uint32_t brace = 0;  // which {...} of the line it stood in
};

/// A line in its order; keys may occur again ("{Link 1} {Value ..} {Link 2} {Value ..}"). A brace with several keys,
/// "{Name F1 Range 0.5 Name F2 Range 0.6}", gives one part for each; every second word must begin with a letter.
struct UsarLine {
  std::string_view type;
  std::array<UsarPart, kUsarParts> part{};
  std::size_t count = 0;

  std::span<const UsarPart> parts() const noexcept { return {part.data(), count}; }
  /// The part with this key, from number `from` on; nothing: an empty one (its key is empty). Case matters.
  UsarPart find(std::string_view key, std::size_t from = 0) const noexcept;
  /// Where it is; count: nowhere.
  std::size_t index_of(std::string_view key, std::size_t from = 0) const noexcept;
  bool has(std::string_view key) const noexcept { return index_of(key) < count; }
};

enum class UsarError : std::uint8_t {
  none,
  empty,     // only blanks: normal between CR and LF
  text,      // words outside of the braces, or no type
  brace,     // a brace inside of another, one that does not close, or one that was not opened: a torn line
  too_many,  // more than kUsarParts keys
};

/// Takes what real programs write: blanks or none before braces, several or none between, tabs, an empty "{}".
/// RT: yes.   Errors: `out` then has the parts in front of the error.
UsarError parse_usarsim(std::string_view line, UsarLine& out) noexcept;

/// Number `index` of "1.20,2.50,2.05" (or with blanks between). True and False are 1 and 0. Nothing: there is no such
/// one, or it is no finite number. A number has a point; with `decimal_comma` parts are cut at blanks and semicolons
/// only, and a comma is the point ("1,20 2,50": clients on machines with such a locale). RT: yes.
std::optional<double> usar_number(std::string_view value, std::size_t index = 0, bool decimal_comma = false) noexcept;
/// Item `index` as it stands there; empty: there is none.
std::string_view usar_item(std::string_view value, std::size_t index, bool decimal_comma = false) noexcept;
/// How many items.
std::size_t usar_count(std::string_view value, bool decimal_comma = false) noexcept;
/// A whole text as a finite number, locale free: "-1.5", "+2", "1e-3". RT: yes.
std::optional<double> parse_number(std::string_view text) noexcept;

/// Cuts a stream into lines at CR, LF or both, however the stream is split. Control characters other than tab make a
/// line bad. RT: yes; a character costs a store.
class UsarLines {
 public:
  /// True: line() is a new one, not empty.
  bool push(char c) noexcept;
  /// Until the next push().
  std::string_view line() const noexcept { return {text_.data(), size_}; }
  /// Lines that were dropped as a whole: longer than kUsarLine, or with bytes that are no text.
  std::uint64_t dropped() const noexcept { return dropped_; }
  /// The connection is a new one: what was begun will not go on. True: something was.
  bool reset() noexcept;

 private:
  std::array<char, kUsarLine> text_{};
  std::size_t size_ = 0;
  std::uint64_t dropped_ = 0;
  bool bad_ = false, complete_ = false;
};

/// Writes one line into a fixed buffer. Numbers are written without a locale: `decimals` digits behind the point, in
/// full; what is not finite is written as 0. RT: yes.
class UsarWriter {
 public:
  explicit UsarWriter(std::span<char> into) noexcept : into_(into) {}
  UsarWriter& type(std::string_view type) noexcept;
  UsarWriter& text(std::string_view key, std::string_view value) noexcept;
  UsarWriter& number(std::string_view key, double value, int decimals = 4) noexcept;
  UsarWriter& integer(std::string_view key, std::int64_t value) noexcept;
  UsarWriter& flag(std::string_view key, bool value) noexcept { return text(key, value ? "True" : "False"); }
  UsarWriter& vector(std::string_view key, std::span<const double> values, int decimals = 4) noexcept;
  /// A brace with several keys: open("Name"), then word() and number-words, then close().
  UsarWriter& open() noexcept;
  UsarWriter& word(std::string_view word) noexcept;
  UsarWriter& word(double value, int decimals = 4) noexcept;
  UsarWriter& close() noexcept;
  /// The whole line with CR LF; empty: it did not fit.
  std::string_view line() noexcept;

 private:
  UsarWriter& put(std::string_view text) noexcept;
  UsarWriter& put(double value, int decimals) noexcept;
  std::span<char> into_;
  std::size_t used_ = 0;
  bool fits_ = true, first_word_ = true;
};

/// `value` with `decimals` digits behind the point, 0 to 17, rounded to the nearest of its exact decimal value (halves
/// to even), as "%.*f" does in the C locale. Returns the characters written; 0: no room (a double takes at most
/// 310 + decimals), or not finite. RT: yes.
std::size_t write_fixed(double value, int decimals, std::span<char> out) noexcept;

}  // namespace sinew::wire
