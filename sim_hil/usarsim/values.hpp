#pragma once
// Values of a client's line, read as tolerantly as real clients need: keys in any case, decimal commas, True as 1.
#include <optional>
#include <string>
#include <string_view>

#include "math/linear.hpp"
#include "wire/text/usarsim.hpp"

namespace sinew::usarsim {

bool same_word(std::string_view a, std::string_view b);  // whatever their case; ASCII

/// The value of the first part with this key in any case; nothing: there is none.
std::optional<std::string_view> value_of(const wire::UsarLine& line, std::string_view key);
/// The same, or an empty text.
std::string text_of(const wire::UsarLine& line, std::string_view key);

/// One number: "0.5", also "0,5" of a client with such a locale. Nothing: it is none, or not finite.
std::optional<double> number_in(std::string_view value);
std::optional<double> number_of(const wire::UsarLine& line, std::string_view key);
/// "1.2,3,4.5", also with blanks or semicolons between, and with decimal commas: "1,2 3,0 4,5", "1,2,3,0,4,5".
std::optional<math::Vec3> vector_of(const wire::UsarLine& line, std::string_view key);
/// True, true, 1 and False, false, 0.
std::optional<bool> flag_of(const wire::UsarLine& line, std::string_view key);

/// {Order n} of a joint: 0, or none, is an angle, 1 a rate. Nothing: another one (2, a torque, is none that a servo
/// knows).
std::optional<bool> is_rate(std::optional<double> order);

/// `text` as a value of a line: braces and control characters would end it, so they become blanks; at most 200
/// characters.
std::string clean(std::string_view text);

}  // namespace sinew::usarsim
