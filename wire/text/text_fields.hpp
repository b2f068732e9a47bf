#pragma once
// Answers of text robots, whatever their form, as one: a type and keys with values (wire::UsarLine). Three forms:
//
//   usarsim  "SEN {Type GPS} {Fix 0}"                      type SEN, keys Type and Fix
//   fields   "pitch:0;roll:-3;mpry:1,2,3;bat:87;\r\n"      type state, keys pitch, roll, mpry, bat (Tello)
//            "ok", "87", "error Not joystick"              without a key: type reply, key text with the whole of it
//   words    "HEIGHT 1.2 3.4"                              type HEIGHT, key value with the rest
#include "wire/text/usarsim.hpp"

namespace sinew::wire {

enum class TextForm : std::uint8_t { usarsim, fields, words };

/// RT: yes.   Errors: as parse_usarsim(). Fields: text: a field without a key among others with one; brace: never.
UsarError parse_text(TextForm form, std::string_view line, UsarLine& out) noexcept;

}  // namespace sinew::wire
