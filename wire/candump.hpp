#pragma once
// Lines of a `candump -l` log: "(1436509052.249713) can0 123#11223344", CAN FD "123##3112233" (one digit of flags),
// remote frames "123#R" and "123#R4", 29-bit identifiers with eight digits, error frames as 29 bits with 0x20000000.
// Text: identifiers with their highest digit first, data byte by byte in the order of the frame.
// Source:  linux-can/can-utils, lib.h (parse_canframe, sprint_canframe) and candump.c (log line).
#include <span>
#include <string_view>

#include "msg/can.hpp"

namespace sinew::wire {

inline constexpr std::size_t kCandumpMax = 200;  // of a line, with an interface name of at most 15

struct CandumpLine {
  msg::CanFrame frame;         // its stamp is the log's: wall time, or whatever was recorded
  std::string_view interface;  // points into the text
};

/// Null, or what is wrong with the line (a string literal). Dots between bytes, "_F" after eight bytes (raw DLC) and a
/// direction "R" or "T" at the end are accepted and mean nothing here.   RT: yes.
const char* candump_parse(std::string_view line, CandumpLine& out) noexcept;

/// Characters written, without a line end; 0: no room, or no such frame.   RT: yes.
std::size_t candump_format(const msg::CanFrame& frame, std::string_view interface, std::span<char> out) noexcept;

}  // namespace sinew::wire
