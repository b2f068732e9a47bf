#include "wire/candump.hpp"

#include "wire/can_check.hpp"
#include "wire/text_scan.hpp"

namespace sinew::wire {
namespace {

constexpr std::uint32_t kErrorBit = 0x20000000;              // CAN_ERR_FLAG of linux/can.h
constexpr std::uint32_t kFdBitRateSwitch = 1, kFdKnown = 7;  // CANFD_BRS; with ESI and FDF

const char* parse_id(std::string_view digits, msg::CanFrame& frame) {
  const auto id = parse_hex(digits);
  if (!id || (digits.size() != 3 && digits.size() != 8)) return "identifier: three or eight hex digits";
  frame.id = *id;
  if (digits.size() == 3) return frame.id <= kCanStandardMask ? nullptr : "identifier of three digits above 7FF";
  if ((*id & ~(kErrorBit | kCanExtendedMask)) != 0) return "identifier of eight digits above 3FFFFFFF";
  if ((*id & kErrorBit) == 0) {
    frame.flags |= msg::kCanExtended;
  } else {
    frame.flags |= msg::kCanError;
    frame.id &= kCanExtendedMask;
  }
  return nullptr;
}

const char* parse_data(TextScan& text, msg::CanFrame& frame) {
  const std::size_t room = frame.fd() ? msg::kMaxCanBytes : 8;
  while (!text.empty() && text.rest().front() != ' ' && text.rest().front() != '_') {
    const auto byte = text.hex_byte();
    if (!byte) return "data: two hex digits a byte";
    if (frame.size == room) return "more data than a frame can have";
    frame.data[frame.size++] = *byte;
    text.take('.');
  }
  if (frame.fd() && !is_can_fd_size(frame.size)) return "no CAN FD frame has this many bytes";
  if (text.take('_')) {
    const auto dlc = text.hex_digit();
    if (frame.fd() || frame.size != 8 || !dlc || *dlc <= 8) return "a raw DLC 9..F follows eight bytes only";
  }
  return nullptr;
}

const char* parse_body(TextScan& text, msg::CanFrame& frame) {
  if (text.take('#')) {
    const auto flags = text.hex_digit();
    if (!flags || *flags > kFdKnown) return "CAN FD flags: one digit 0..7";
    frame.flags |= msg::kCanFd | ((*flags & kFdBitRateSwitch) != 0 ? msg::kCanBitRateSwitch : 0u);
    return frame.error() ? "error frames are not CAN FD" : parse_data(text, frame);
  }
  if (!text.take('R')) return parse_data(text, frame);
  frame.flags |= msg::kCanRemote;
  if (text.empty() || text.rest().front() == ' ') return frame.error() ? "error frames ask for nothing" : nullptr;
  const auto size = text.hex_digit();
  if (!size || *size > 8 || frame.error()) return "remote frames ask for 0..8 bytes";
  frame.size = *size;
  return nullptr;
}

}  // namespace

const char* candump_parse(std::string_view line, CandumpLine& out) noexcept {
  while (!line.empty() && (line.back() == '\n' || line.back() == '\r' || line.back() == ' ')) line.remove_suffix(1);
  TextScan text(line);
  const std::string_view time = text.word();
  if (time.size() < 3 || time.front() != '(' || time.back() != ')') return "begins with (SECONDS.MICROSECONDS)";
  const auto stamp = parse_seconds(time.substr(1, time.size() - 2));
  if (!stamp) return "time: (SECONDS.MICROSECONDS)";
  CandumpLine found;
  found.frame.stamp.ns = *stamp;
  found.interface = text.word();
  if (found.interface.empty() || found.interface.size() > 15) return "name of an interface, at most 15 characters";
  text.skip_blanks();
  const std::size_t hash = text.rest().find('#');
  if (hash == std::string_view::npos) return "IDENTIFIER#DATA";
  if (const char* why = parse_id(text.rest().substr(0, hash), found.frame)) return why;
  TextScan body(text.rest().substr(hash + 1));
  if (const char* why = parse_body(body, found.frame)) return why;
  const std::string_view direction = body.word();
  if (!(direction.empty() || direction == "R" || direction == "T") || !body.empty()) return "text after the data";
  out = found;
  return nullptr;
}

std::size_t candump_format(const msg::CanFrame& frame, std::string_view interface, std::span<char> out) noexcept {
  if (frame.error() ? frame.id > kCanExtendedMask || frame.size > 8 || frame.fd() || frame.remote()
                    : !is_can_frame(frame))
    return 0;
  if (interface.empty() || interface.size() > 15) return 0;
  TextPut text(out);
  text.put("(").seconds(frame.stamp.ns).put(") ").put(interface).put(" ");
  if (frame.error())
    text.hex(frame.id | kErrorBit, 8);
  else
    text.hex(frame.id, frame.extended() ? 8 : 3);
  text.put(frame.fd() ? "##" : "#");
  if (frame.fd()) text.hex((frame.flags & msg::kCanBitRateSwitch) != 0 ? kFdBitRateSwitch : 0, 1);
  if (frame.remote()) {
    text.put("R");
    if (frame.size > 0) text.hex(frame.size, 1);
    return text.size();
  }
  for (const std::uint8_t byte : frame.bytes()) text.hex(byte, 2);
  return text.size();
}

}  // namespace sinew::wire
