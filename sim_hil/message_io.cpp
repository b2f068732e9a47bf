#include "sim_hil/message_io.hpp"

#include <algorithm>

namespace sinew::sim_hil {
namespace {

using hal::Errc;
using hal::Error;

// The largest small message and some more, so that moving the rest to the front is rare and space() never empty.
constexpr std::size_t kBufferBytes = kMaxSmallBytes + 16 * 1024;
constexpr std::size_t kLeastSpace = 4096;

bool may_send(Sender sender, Type type) {
  switch (type) {
    case Type::bye:
      return true;
    case Type::hello:
    case Type::start:
    case Type::done:
    case Type::command:
    case Type::stop:
    case Type::transmit:
    case Type::clock_ask:
      return sender == Sender::runtime;
    default:
      return sender == Sender::plant;
  }
}

}  // namespace

MessageReceiver::MessageReceiver(Sender peer) : peer_(peer), buffer_(kBufferBytes) {}

std::span<std::byte> MessageReceiver::space() noexcept {
  if (begin_ == end_) begin_ = end_ = 0;
  if (buffer_.size() - end_ < kLeastSpace || buffer_.size() - begin_ < kMaxSmallBytes) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  return {buffer_.data() + end_, buffer_.size() - end_};
}

hal::Result<bool> MessageReceiver::next(Message& out) noexcept {
  if (!state_) return state_.error();
  if (bulk_left_ > 0) {
    const std::size_t n = std::min(bulk_left_, buffered());
    begin_ += n;
    bulk_left_ -= n;
    if (bulk_left_ > 0) return false;
  }
  if (buffered() < kHeaderBytes) return false;
  const Bytes bytes{buffer_.data() + begin_, buffered()};
  Header& h = out.header;
  state_ = decode(bytes, h);
  if (state_ && !may_send(peer_, h.type))
    state_ = Error{Errc::bad_data, "message goes in the wrong direction", std::int64_t(h.type)};
  if (state_ && h.sequence != sequence_) state_ = Error{Errc::bad_data, "messages are missing", h.sequence};
  if (!state_) return state_.error();

  const std::size_t bulk = h.type == Type::frame ? h.size - kHeaderBytes - kFrameBytes : 0;
  const std::size_t whole = h.size - bulk;
  if (buffered() < whole) return false;
  out.payload = bytes.subspan(kHeaderBytes, whole - kHeaderBytes);
  out.bulk_bytes = static_cast<std::uint32_t>(bulk);
  bulk_left_ = bulk;
  begin_ += whole;
  ++sequence_;
  return true;
}

std::size_t MessageReceiver::take_bulk(std::span<std::uint8_t> into) noexcept {
  const std::size_t n = std::min({into.size(), bulk_left_, buffered()});
  std::memcpy(into.data(), buffer_.data() + begin_, n);
  begin_ += n;
  bulk_left_ -= n;
  return n;
}

MessageWriter::MessageWriter(std::size_t capacity_bytes) : buffer_(capacity_bytes) {}

bool MessageWriter::add(Type type, std::uint16_t device, Time time) noexcept {
  if (room() < kHeaderBytes) return false;
  finish(type, device, time, 0, 0);
  return true;
}

bool MessageWriter::add_text(Type type, Time time, std::string_view text) noexcept {
  text = text.substr(0, kMaxTextBytes);
  if (room() < kHeaderBytes + text.size()) return false;
  std::memcpy(end() + kHeaderBytes, text.data(), text.size());
  finish(type, 0, time, text.size(), 0);
  return true;
}

void MessageWriter::finish(Type type, std::uint16_t device, Time time, std::size_t payload, std::size_t bulk) noexcept {
  Header h;
  h.size = static_cast<std::uint32_t>(kHeaderBytes + payload + bulk);
  h.type = type;
  h.device = device;
  h.sequence = sequence_++;
  h.time = time;
  encode(h, end());
  used_ += kHeaderBytes + payload;
}

void MessageWriter::sent(std::size_t bytes) noexcept {
  std::memmove(buffer_.data(), buffer_.data() + bytes, used_ - bytes);
  used_ -= bytes;
}

}  // namespace sinew::sim_hil
