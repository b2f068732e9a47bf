#include "tap/connection.hpp"

#include <algorithm>

namespace sinew::tap {
namespace {

constexpr unsigned kMaxStrikes = 8;  // garbage in well-formed frames, before the connection is closed
constexpr double kBurst_s = 0.5;     // of the rate, allowed at once
constexpr int kReadsAtOnce = 4;      // system calls of one turn
constexpr auto kWritePatience = std::chrono::milliseconds(20);  // of the one write that may not be split

std::string instead_of(const Json& reply, hal::Errc code, const char* why) {
  Json json = refused(code, why);
  if (const auto id = reply.find("id"); id != reply.end()) json["id"] = *id;
  return to_text(json);
}

}  // namespace

Connection::Connection(std::uint64_t id, std::unique_ptr<hal::Stream> stream, int pid, const Allowance& allowance,
                       hal::Time now)
    : id_(id),
      stream_(std::move(stream)),
      pid_(pid),
      allowance_(allowance),
      since_(now),
      tokens_(kBurst_s * allowance.requests_per_s),
      refilled_(now),
      last_request_(now) {
  stream_->set_patience(kWritePatience);  // of handles that the client sends the stream keeps one, for publish.memory
}

hal::Waiting Connection::waiting(hal::Time now) {
  const double most = kBurst_s * allowance_.requests_per_s;
  tokens_ = std::min(most, tokens_ + msg::seconds(now - refilled_) * allowance_.requests_per_s);
  refilled_ = now;
  if (!out_.empty()) return {stream_->handle(), true, false};
  if (change_ || throttled()) return {-1, false, false};
  return {stream_->handle(), false, false};
}

std::optional<std::string_view> Connection::read(hal::Time now) {
  for (int i = 0; i < kReadsAtOnce && !frames_.frame(); ++i) {
    const auto n = stream_->read_now(frames_.room());
    if (!n) {
      end_ = End::gone;
      return std::nullopt;
    }
    if (*n == 0) break;
    frames_.filled(*n);
    if (frames_.broken()) {
      end_ = End::garbage;
      return std::nullopt;
    }
  }
  if (!half_ && frames_.half()) since_ = now;
  half_ = frames_.half();
  const auto frame = frames_.frame();
  if (frame) {
    tokens_ -= 1;
    last_request_ = now;
  }
  return frame;
}

bool Connection::reply(const Reply& reply, std::size_t room, hal::Time now) {
  frames_.drop();
  if (reply.garbage && ++strikes_ > kMaxStrikes) end_ = End::garbage;
  if (reply.change) {
    change_ = reply.change;
    since_ = now;
    return true;
  }
  std::string text = to_text(reply);
  if (text.size() > kMaxReplyBytes)
    text = instead_of(reply.json, hal::Errc::not_supported, "the reply is longer than a reply may be");
  const bool no_room = text.size() > kShortReplyBytes && text.size() > room;
  if (no_room) text = instead_of(reply.json, hal::Errc::busy, "other clients have not taken their long replies yet");
  send(text, reply.memory, now);
  return !no_room;
}

void Connection::settle(const Json& json, hal::Time now) {
  change_.reset();
  send(to_text(json), nullptr, now);
}

void Connection::send(const std::string& text, const hal::SharedMemory* memory, hal::Time now) {
  const auto head = frame_head(text.size());
  out_.assign(reinterpret_cast<const char*>(head.data()), head.size());
  out_ += text;
  sent_ = 0, memory_ = memory, since_ = now;
  if (!memory) write();  // with memory only where there is surely room: that write cannot be done in part
}

void Connection::write() {
  const std::span<const std::byte> rest = std::as_bytes(std::span(out_)).subspan(sent_);
  if (memory_) {
    if (!stream_->write_with_memory(rest, *memory_)) end_ = End::gone;
    sent_ = out_.size();
    memory_ = nullptr;
  } else if (const auto n = stream_->write_now(rest); n) {
    sent_ += *n;
  } else {
    end_ = End::gone;
  }
  if (sent_ == out_.size()) out_.clear();
  if (out_.empty() && out_.capacity() > kMaxRequestBytes) out_.shrink_to_fit();
}

void Connection::look_at_time(hal::Time now) {
  if (end_ == End::open && (half_ || !out_.empty()) && now - since_ > allowance_.patience) end_ = End::slow;
}

}  // namespace sinew::tap
