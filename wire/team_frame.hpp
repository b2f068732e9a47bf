#pragma once
// What robots of a team say to each other in one datagram: who sends, its clock, and messages of topics. Little-endian,
// fields without padding. docs/team-protocol.md has the bytes.
// Source:  ours. The exchange of times is that of NTP's symmetric mode (RFC 5905, section 8), carried by traffic that
//          goes anyway: each frame says when the newest frame of each mate came here.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace sinew::wire {

inline constexpr std::uint32_t kTeamMagic = 0x54574E53;  // the bytes "SNWT"
inline constexpr std::uint8_t kTeamVersion = 1;
inline constexpr std::size_t kTeamMostEchoes = 15;
inline constexpr std::size_t kTeamMostMessages = 255;
inline constexpr std::size_t kTeamMostTopicBytes = 64;  // of a topic's name
/// Bytes of the head, of an echo, and of a message beside its topic and its CDR.
inline constexpr std::size_t kTeamHeadBytes = 32, kTeamEchoBytes = 26, kTeamMessageBytes = 19;

/// Instants are within 73 years of their clock's zero, so that sums and differences of a few of them fit.
inline constexpr std::int64_t kTeamMostNs = std::int64_t{1} << 61;
constexpr bool is_team_instant(std::int64_t ns) { return ns >= -kTeamMostNs && ns <= kTeamMostNs; }

/// In front of each frame.
struct TeamHead {
  std::uint16_t robot = 0;     // number within the team, 1 to 65535
  std::uint32_t start = 0;     // differs from start to start of the sender, so that a restart is no reordering
  std::uint32_t sequence = 0;  // counts the sender's frames of this start from 0, wraps
  std::int64_t sent_ns = 0;    // the sender's clock as it sent
  std::uint32_t team = 0;      // frames of another team on the same channel are not ours
};

/// When the newest frame of a mate arrived at the sender of this one.
struct TeamEcho {
  std::uint16_t robot = 0;     // the mate
  std::uint32_t start = 0;     // of the mate: after a restart of its computer an old time says nothing about its clock
  std::uint32_t sequence = 0;  // of the mate's frame
  std::int64_t sent_ns = 0, received_ns = 0;  // the mate's clock as it sent; the clock of this frame's sender
};

/// One message of a topic. `topic` and `cdr` point into the frame.
struct TeamMessage {
  std::string_view topic{};             // as its writer names it: "ball.model"; printable ASCII without spaces
  std::uint32_t type_hash = 0;          // of the definition: builds that differ are named and never misread
  std::uint32_t sequence = 0;           // of the topic
  std::int64_t stamp_ns = 0;            // the message's own stamp, sender's clock
  std::span<const std::uint8_t> cdr{};  // msg/cdr.hpp, with its head of four bytes
};

/// Writes one frame.
///     TeamWriter frame(buffer, head);
///     frame.add(echo);                 // echoes first
///     if (!frame.add(message)) ...     // did not fit: send(frame.finish()), begin the next one
/// RT:  yes.
class TeamWriter {
 public:
  TeamWriter(std::span<std::uint8_t> buffer, const TeamHead& head) noexcept;
  /// False, and nothing is written: no room, too many, an echo after the first message, an echo of robot 0, a topic or
  /// a CDR or an instant that no frame has (docs/team-protocol.md).
  bool add(const TeamEcho& echo) noexcept;
  bool add(const TeamMessage& message) noexcept;
  bool empty() const noexcept { return messages_ == 0; }
  /// The frame's bytes; empty when not even the head fitted, or the head is one that no frame has.
  std::span<const std::uint8_t> finish() noexcept;

 private:
  std::span<std::uint8_t> buffer_;
  std::size_t size_ = 0;
  std::uint8_t echoes_ = 0, messages_ = 0;
};

/// Reads one frame; trusts nothing. RT: yes.
///     TeamReader frame;
///     if (const char* why = frame.open(datagram.bytes())) ...   // no frame of ours: `why` says it
///     while (auto message = frame.next()) ...
class TeamReader {
 public:
  /// Null: it is a whole, valid frame: every length has been checked, nothing is left over. Else why not, in words.
  /// Owner:   `bytes`, for as long as the reader and its messages are used.
  const char* open(std::span<const std::uint8_t> bytes) noexcept;
  const TeamHead& head() const noexcept { return head_; }
  std::size_t echoes() const noexcept { return echoes_; }
  std::size_t messages() const noexcept { return messages_; }
  TeamEcho echo(std::size_t i) const noexcept;  // i < echoes()
  /// One after the other; nothing: that was the last.
  std::optional<TeamMessage> next() noexcept;

 private:
  std::span<const std::uint8_t> bytes_{};
  TeamHead head_{};
  std::size_t echoes_ = 0, messages_ = 0, told_ = 0, at_ = 0;
};

}  // namespace sinew::wire
