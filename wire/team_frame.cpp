#include "wire/team_frame.hpp"

#include <algorithm>
#include <type_traits>

namespace sinew::wire {
namespace {

constexpr std::size_t kEchoesAt = 5, kMessagesAt = 6;
constexpr std::size_t kMostCdr = 65535, kLeastCdr = 4;
constexpr const char* kNoInstant = "an instant that cannot be";

const char* look_at_echo(const TeamEcho& echo) {
  if (echo.robot == 0) return "no robot has the number 0";
  return is_team_instant(echo.sent_ns) && is_team_instant(echo.received_ns) ? nullptr : kNoInstant;
}

/// Writes numbers one after the other.
class TeamPut {
 public:
  explicit TeamPut(std::uint8_t* at) : at_(at) {}
  template <class T>
  TeamPut& put(T value) {
    auto bits = static_cast<std::make_unsigned_t<T>>(value);
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      *at_++ = static_cast<std::uint8_t>(bits);
      if constexpr (sizeof(T) > 1) bits = static_cast<std::make_unsigned_t<T>>(bits >> 8);
    }
    return *this;
  }
  std::uint8_t* at() const { return at_; }

 private:
  std::uint8_t* at_;
};

/// Reads numbers one after the other; the caller knows that they are there.
class TeamGet {
 public:
  explicit TeamGet(const std::uint8_t* at) : at_(at) {}
  template <class T>
  TeamGet& get(T& value) {
    std::make_unsigned_t<T> bits = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i)
      bits = static_cast<std::make_unsigned_t<T>>(bits | static_cast<std::make_unsigned_t<T>>(*at_++) << (8 * i));
    value = static_cast<T>(bits);
    return *this;
  }
  std::uint8_t byte() { return *at_++; }
  const std::uint8_t* at() const { return at_; }

 private:
  const std::uint8_t* at_;
};

bool is_team_topic(std::string_view topic) {
  return !topic.empty() && topic.size() <= kTeamMostTopicBytes &&
         std::all_of(topic.begin(), topic.end(), [](char c) { return c > ' ' && c < '\x7F'; });
}

/// The message at the front of `rest`. Null: it is there, and `size` says how long it is.
const char* look_at_message(std::span<const std::uint8_t> rest, TeamMessage& out, std::size_t& size) {
  if (rest.size() < kTeamMessageBytes) return "ends within a message";
  TeamGet get(rest.data());
  const std::size_t topic = get.byte();
  std::uint16_t cdr = 0;
  get.get(cdr).get(out.type_hash).get(out.sequence).get(out.stamp_ns);
  size = kTeamMessageBytes + topic + cdr;
  if (rest.size() < size) return "ends within a message";
  if (cdr < kLeastCdr) return "a message without content";
  if (!is_team_instant(out.stamp_ns)) return kNoInstant;
  // A topic is text, and text is bytes: a cast between the two character types is defined.
  out.topic = {reinterpret_cast<const char*>(get.at()), topic};
  out.cdr = rest.subspan(kTeamMessageBytes + topic, cdr);
  return is_team_topic(out.topic) ? nullptr : "a topic's name that cannot be";
}

/// The caller knows that it is there.
TeamEcho echo_at(std::span<const std::uint8_t> frame, std::size_t i) {
  TeamEcho out;
  TeamGet(&frame[kTeamHeadBytes + i * kTeamEchoBytes])
      .get(out.robot)
      .get(out.start)
      .get(out.sequence)
      .get(out.sent_ns)
      .get(out.received_ns);
  return out;
}

}  // namespace

TeamWriter::TeamWriter(std::span<std::uint8_t> buffer, const TeamHead& head) noexcept : buffer_(buffer) {
  if (buffer.size() < kTeamHeadBytes || head.robot == 0 || !is_team_instant(head.sent_ns)) return;
  TeamPut(buffer.data())
      .put(kTeamMagic)
      .put(kTeamVersion)
      .put(std::uint8_t{0})  // echoes: finish()
      .put(std::uint8_t{0})  // messages
      .put(std::uint8_t{0})
      .put(head.robot)
      .put(std::uint16_t{0})
      .put(head.team)
      .put(head.start)
      .put(head.sequence)
      .put(head.sent_ns);
  size_ = kTeamHeadBytes;
}

bool TeamWriter::add(const TeamEcho& echo) noexcept {
  if (size_ == 0 || messages_ > 0 || echoes_ == kTeamMostEchoes || look_at_echo(echo)) return false;
  if (buffer_.size() - size_ < kTeamEchoBytes) return false;
  TeamPut(&buffer_[size_]).put(echo.robot).put(echo.start).put(echo.sequence).put(echo.sent_ns).put(echo.received_ns);
  size_ += kTeamEchoBytes, ++echoes_;
  return true;
}

bool TeamWriter::add(const TeamMessage& message) noexcept {
  if (size_ == 0 || messages_ == kTeamMostMessages || !is_team_topic(message.topic)) return false;
  if (message.cdr.size() < kLeastCdr || message.cdr.size() > kMostCdr || !is_team_instant(message.stamp_ns))
    return false;
  const std::size_t bytes = kTeamMessageBytes + message.topic.size() + message.cdr.size();
  if (buffer_.size() - size_ < bytes) return false;
  std::uint8_t* at = TeamPut(&buffer_[size_])
                         .put(static_cast<std::uint8_t>(message.topic.size()))
                         .put(static_cast<std::uint16_t>(message.cdr.size()))
                         .put(message.type_hash)
                         .put(message.sequence)
                         .put(message.stamp_ns)
                         .at();
  at = std::copy(message.topic.begin(), message.topic.end(), at);
  std::copy(message.cdr.begin(), message.cdr.end(), at);
  size_ += bytes, ++messages_;
  return true;
}

std::span<const std::uint8_t> TeamWriter::finish() noexcept {
  if (size_ == 0) return {};
  buffer_[kEchoesAt] = echoes_, buffer_[kMessagesAt] = messages_;
  return buffer_.first(size_);
}

const char* TeamReader::open(std::span<const std::uint8_t> bytes) noexcept {
  *this = {};
  if (bytes.size() < kTeamHeadBytes) return "too short";
  TeamGet get(bytes.data());
  std::uint32_t magic = 0;
  get.get(magic);
  if (magic != kTeamMagic) return "no team frame";
  if (get.byte() != kTeamVersion) return "another version of the team protocol";
  const std::size_t echoes = get.byte(), messages = get.byte();
  if (get.byte() != 0) return "a reserved byte is not 0";
  TeamHead head;
  std::uint16_t reserved = 0;
  get.get(head.robot).get(reserved).get(head.team).get(head.start).get(head.sequence).get(head.sent_ns);
  if (reserved != 0) return "a reserved byte is not 0";
  if (head.robot == 0) return "no robot has the number 0";
  if (!is_team_instant(head.sent_ns)) return kNoInstant;
  if (echoes > kTeamMostEchoes) return "too many echoes";
  std::size_t at = kTeamHeadBytes + echoes * kTeamEchoBytes;
  if (bytes.size() < at) return "ends within an echo";
  for (std::size_t i = 0; i < echoes; ++i)
    if (const char* why = look_at_echo(echo_at(bytes, i))) return why;
  for (std::size_t i = 0; i < messages; ++i) {
    TeamMessage message;
    std::size_t size = 0;
    if (const char* why = look_at_message(bytes.subspan(at), message, size)) return why;
    at += size;
  }
  if (at != bytes.size()) return "more bytes than messages";
  bytes_ = bytes, head_ = head, echoes_ = echoes, messages_ = messages;
  at_ = kTeamHeadBytes + echoes * kTeamEchoBytes;
  return nullptr;
}

TeamEcho TeamReader::echo(std::size_t i) const noexcept { return echo_at(bytes_, i); }

std::optional<TeamMessage> TeamReader::next() noexcept {
  if (told_ == messages_) return std::nullopt;
  TeamMessage out;
  std::size_t size = 0;
  if (look_at_message(bytes_.subspan(at_), out, size)) return std::nullopt;  // open() has looked: it is one
  at_ += size, ++told_;
  return out;
}

}  // namespace sinew::wire
