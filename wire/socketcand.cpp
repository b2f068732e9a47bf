#include "wire/socketcand.hpp"

#include "wire/can_check.hpp"
#include "wire/text_scan.hpp"

namespace sinew::wire {
namespace {

constexpr std::uint32_t kSocketcandBitRateSwitch = 1;  // CANFD_BRS of linux/can.h
constexpr std::size_t kMaxBusName = 16;

bool read_id(TextScan& text, msg::CanFrame& frame) {
  const std::string_view word = text.word();
  const auto id = parse_hex(word);
  if (!id) return false;
  frame.id = *id;
  if (word.size() > 3 || *id > kCanStandardMask) frame.flags |= msg::kCanExtended;
  return true;
}

bool read_time(TextScan& text, msg::CanFrame& frame) {
  const auto ns = parse_seconds(text.word());
  if (!ns) return false;
  frame.stamp.ns = *ns;
  return true;
}

bool read_fd_flags(TextScan& text, msg::CanFrame& frame) {
  const auto flags = parse_hex(text.word(), 2);
  if (!flags) return false;
  frame.flags |= msg::kCanFd | ((*flags & kSocketcandBitRateSwitch) != 0 ? msg::kCanBitRateSwitch : 0u);
  return true;
}

bool read_size(TextScan& text, msg::CanFrame& frame) {
  const auto size = parse_decimal(text.word(), 2);
  if (!size || *size > msg::kMaxCanBytes) return false;
  frame.size = static_cast<std::uint32_t>(*size);
  return true;
}

/// "11 22" of one or two digits each, or "1122".
bool read_bytes(TextScan& text, msg::CanFrame& frame) {
  frame.size = 0;
  for (std::string_view word = text.word(); !word.empty(); word = text.word()) {
    TextScan digits(word);
    const bool short_byte = word.size() == 1;
    while (!digits.empty()) {
      std::optional<std::uint32_t> byte = short_byte ? digits.hex_digit() : std::nullopt;
      if (!short_byte) byte = digits.hex_byte();
      if (!byte || frame.size == msg::kMaxCanBytes) return false;
      frame.data[frame.size++] = static_cast<std::uint8_t>(*byte);
    }
  }
  return true;
}

bool at_end(TextScan& text) {
  text.skip_blanks();
  return text.empty();
}

/// "ID TIME DATA"
bool read_received(TextScan& text, msg::CanFrame& frame, bool fd) {
  return read_id(text, frame) && (!fd || read_fd_flags(text, frame)) && read_time(text, frame) &&
         read_bytes(text, frame) && is_can_frame(frame);
}

/// "ID LEN DATA"
bool read_to_send(TextScan& text, msg::CanFrame& frame, bool fd) {
  if (!read_id(text, frame) || (fd && !read_fd_flags(text, frame)) || !read_size(text, frame)) return false;
  const std::uint32_t said = frame.size;
  return read_bytes(text, frame) && frame.size == said && is_can_frame(frame);
}

bool read_remote(TextScan& text, msg::CanFrame& frame, bool received) {
  frame.flags |= msg::kCanRemote;
  return read_id(text, frame) && (!received || read_time(text, frame)) && read_size(text, frame) && at_end(text) &&
         is_can_frame(frame);
}

/// "CLASS TIME": an error frame; anything else: words.
void read_error(TextScan& text, SocketcandMessage& out) {
  text.skip_blanks();
  out.kind = SocketcandKind::refused;
  out.text = text.rest();
  while (!out.text.empty() && out.text.back() == ' ') out.text.remove_suffix(1);
  msg::CanFrame frame;
  const auto id = parse_hex(text.word());
  if (!id || *id > kCanExtendedMask || !read_time(text, frame) || !at_end(text)) return;
  frame.id = *id;
  frame.flags = msg::kCanError;
  frame.size = 8;  // as the kernel's; but what stood in them is not told
  out.kind = SocketcandKind::frame;
  out.frame = frame;
}

TextPut& put_id(TextPut& text, const msg::CanFrame& frame) { return text.hex(frame.id, frame.extended() ? 8 : 3); }
std::uint32_t fd_flags(const msg::CanFrame& frame) {
  return (frame.flags & msg::kCanBitRateSwitch) != 0 ? kSocketcandBitRateSwitch : 0;
}

}  // namespace

bool SocketcandSplitter::push(char c) noexcept {
  if (complete_) complete_ = false, size_ = 0;
  if (c == '<') {
    if (inside_) ++dropped_;
    inside_ = true, size_ = 0;
    return false;
  }
  if (!inside_) return false;
  if (c == '>') {
    inside_ = false;
    return complete_ = true;
  }
  if (size_ == text_.size()) {
    ++dropped_;
    reset();
    return false;
  }
  text_[size_++] = c;
  return false;
}

bool socketcand_parse(std::string_view element, SocketcandMessage& out) noexcept {
  TextScan text(element);
  const std::string_view word = text.word();
  out = {};
  const auto plain = [&](SocketcandKind kind) {
    out.kind = kind;
    return at_end(text);
  };
  if (word == "hi") return plain(SocketcandKind::hi);
  if (word == "ok") return plain(SocketcandKind::ok);
  if (word == "echo") return plain(SocketcandKind::echo);
  if (word == "rawmode") return plain(SocketcandKind::raw_mode);
  if (word == "stat") {
    out.kind = SocketcandKind::statistics;
    return true;
  }
  if (word == "error") {
    read_error(text, out);
    return true;
  }
  if (word == "open") {
    out.kind = SocketcandKind::open;
    out.text = text.word();
    return !out.text.empty() && out.text.size() <= kMaxBusName && at_end(text);
  }
  out.kind = SocketcandKind::frame;
  if (word == "frame" || word == "fdframe") return read_received(text, out.frame, word == "fdframe");
  if (word == "rtr") return read_remote(text, out.frame, true);
  out.kind = SocketcandKind::send;
  if (word == "send" || word == "fdsend") return read_to_send(text, out.frame, word == "fdsend");
  if (word == "sendrtr") return read_remote(text, out.frame, false);
  return false;
}

std::size_t socketcand_send(const msg::CanFrame& frame, std::span<char> out) noexcept {
  if (!is_can_frame(frame)) return 0;
  TextPut text(out);
  if (frame.fd())
    text.put("< fdsend ");
  else
    text.put(frame.remote() ? "< sendrtr " : "< send ");
  put_id(text, frame);
  if (frame.fd()) text.put(" ").hex(fd_flags(frame), 2);
  text.put(" ").decimal(frame.size);
  if (!frame.remote())
    for (const std::uint8_t byte : frame.bytes()) text.put(" ").hex(byte, 2);
  return text.put(" >").size();
}

std::size_t socketcand_frame(const msg::CanFrame& frame, std::span<char> out) noexcept {
  TextPut text(out);
  if (frame.error()) {
    if (frame.id > kCanExtendedMask) return 0;
    return text.put("< error ")
        .hex(frame.id, 3 + (frame.id > 0xFFF ? 5 : 0))
        .put(" ")
        .seconds(frame.stamp.ns)
        .put(" >")
        .size();
  }
  if (!is_can_frame(frame)) return 0;
  if (frame.fd())
    text.put("< fdframe ");
  else
    text.put(frame.remote() ? "< rtr " : "< frame ");
  put_id(text, frame);
  if (frame.fd()) text.put(" ").hex(fd_flags(frame), 2);
  text.put(" ").seconds(frame.stamp.ns).put(" ");
  if (frame.remote()) return text.decimal(frame.size).put(" >").size();
  for (const std::uint8_t byte : frame.bytes()) text.hex(byte, 2);
  return text.put(" >").size();
}

std::size_t socketcand_open(std::string_view bus, std::span<char> out) noexcept {
  if (bus.empty() || bus.size() > kMaxBusName) return 0;
  for (const char c : bus)
    if (c <= ' ' || c > '~' || c == '<' || c == '>') return 0;
  return TextPut(out).put("< open ").put(bus).put(" >").size();
}

}  // namespace sinew::wire
