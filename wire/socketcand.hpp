#pragma once
// The text protocol of socketcand: CAN buses over TCP. Elements "< word ... >", one after the other without line ends.
// Bytes of data are two hexadecimal digits each, in the order of the frame.
// Source:  linux-can/socketcand, doc/protocol.md; the CAN FD elements and the form of "< error" in src/state_raw.c.
#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "msg/can.hpp"

namespace sinew::wire {

inline constexpr std::size_t kSocketcandMax = 256;  // characters of an element; the longest (fdsend) has 216

/// Cuts a stream into elements, however the stream is split. Text between elements is skipped. An element that does not
/// end, or has a new one inside, is dropped and counted.   RT: yes.
class SocketcandSplitter {
 public:
  /// True: element() is a new one.
  bool push(char c) noexcept;
  /// The text between "<" and ">"; until the next push().
  std::string_view element() const noexcept { return {text_.data(), size_}; }
  std::uint64_t dropped() const noexcept { return dropped_; }
  void reset() noexcept { inside_ = false, size_ = 0; }

 private:
  std::array<char, kSocketcandMax> text_{};
  std::size_t size_ = 0;
  std::uint64_t dropped_ = 0;
  bool inside_ = false, complete_ = false;
};

enum class SocketcandKind : std::uint8_t {
  hi,          // server: greets
  ok,          // server: done
  echo,        // both: still there?
  refused,     // server: "< error ... >" in words; `text` has them
  frame,       // server: received a frame; an error frame has no data but its class
  send,        // client: send this frame
  open,        // client: the bus `text`
  raw_mode,    // client: every frame from now on
  statistics,  // server: "< stat ... >", not looked into
};

struct SocketcandMessage {
  SocketcandKind kind = SocketcandKind::hi;
  msg::CanFrame frame;    // frame, send; its stamp is the server's wall time (frame) or zero (send)
  std::string_view text;  // open, refused: points into the element
};

/// False: no element that we know, or one that breaks its own form. Data may be written with blanks between the bytes
/// or without. An identifier of more than three digits, or above 7FF, has 29 bits (python-can writes no leading zeros).
/// RT:      yes.
bool socketcand_parse(std::string_view element, SocketcandMessage& out) noexcept;

/// A whole element; returns the characters written, 0: no room, or a frame without a form (error frames to send, and
/// frames that is_can_frame() refuses).   RT: yes.
std::size_t socketcand_send(const msg::CanFrame& frame, std::span<char> out) noexcept;
std::size_t socketcand_frame(const msg::CanFrame& frame, std::span<char> out) noexcept;  // as a server sends it
std::size_t socketcand_open(std::string_view bus, std::span<char> out) noexcept;         // at most 16 characters

}  // namespace sinew::wire
