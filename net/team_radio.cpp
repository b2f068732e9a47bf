#include "net/team_radio.hpp"

#include <algorithm>
#include <ctime>
#include <nlohmann/json.hpp>

#include "wire/net_link.hpp"

namespace sinew::net {
namespace {

constexpr std::size_t kCdrHead = 4, kLengthBytes = 4;
constexpr std::uint32_t kReadAhead = 64;
constexpr int kMostAtOnce = 256;  // samples, before the robot's own have their turn

std::int64_t monotonic_ns() {
  timespec ts{};
  clock_gettime(CLOCK_MONOTONIC, &ts);
  return std::int64_t{ts.tv_sec} * 1'000'000'000 + ts.tv_nsec;
}

/// Of the participant that a writer belongs to: the first 12 bytes of a GUID, of which any may be the only one to
/// differ.
std::uint32_t sender_of(const Guid& guid) {
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < 12; ++i) sum = (sum ^ guid[i]) * 16777619u;  // FNV-1
  return sum;
}

}  // namespace

std::optional<std::span<const std::uint8_t>> datagram_of(std::span<const std::uint8_t> cdr) {
  if (cdr.size() < kCdrHead + kLengthBytes || cdr[0] != 0 || cdr[1] > 1) return std::nullopt;
  const bool little = cdr[1] == 1;
  std::uint32_t size = 0;
  for (std::size_t i = 0; i < kLengthBytes; ++i)
    size |= std::uint32_t{cdr[kCdrHead + i]} << (8 * (little ? i : kLengthBytes - 1 - i));
  if (size == 0 || size > wire::kNetLinkMostDatagram || size > cdr.size() - kCdrHead - kLengthBytes)
    return std::nullopt;
  return cdr.subspan(kCdrHead + kLengthBytes, size);
}

TeamRadio::TeamRadio(std::uint32_t team, LocalLink& robot) : robot_(robot) {
  spec_.topic = "sinew_team_" + std::to_string(team);
  spec_.type = "sinew::TeamDatagram";
  spec_.qos.depth = kReadAhead;
  robot_.on_say([this](std::span<const std::uint8_t> datagram) { say(datagram); });
}

bool TeamRadio::start(Participant& participant, std::string& why) {
  auto writer = participant.write(spec_, why);
  if (!writer) return false;
  auto reader = participant.read(spec_, why);
  if (!reader) return false;
  writer_ = std::move(*writer), reader_ = std::move(*reader);
  return true;
}

std::vector<OwnEndpoint> TeamRadio::endpoints() const { return {{spec_, true}, {spec_, false}}; }

void TeamRadio::say(std::span<const std::uint8_t> datagram) {
  if (!writer_) {
    ++not_said_;
    return;
  }
  const auto size = static_cast<std::uint32_t>(datagram.size());
  cdr_ = {0, 1, 0, 0};
  for (std::size_t i = 0; i < kLengthBytes; ++i) cdr_.push_back(static_cast<std::uint8_t>(size >> (8 * i)));
  cdr_.insert(cdr_.end(), datagram.begin(), datagram.end());
  ++(writer_->write(cdr_) ? said_ : not_said_);
}

void TeamRadio::look(hal::Time) {
  for (int i = 0; i < kMostAtOnce && reader_ && reader_->take(sample_); ++i) {
    const auto datagram = datagram_of(sample_.cdr);
    ++(datagram ? heard_ : odd_);
    if (datagram) robot_.hear(sender_of(sample_.writer), monotonic_ns(), *datagram);
  }
}

void TeamRadio::add_status(nlohmann::json& status) const {
  status["radio"] = {{"topic", spec_.topic},
                     {"robots_here", robot_.robots()},
                     {"readers", writer_ ? writer_->matched() : 0},
                     {"writers", reader_ ? reader_->matched() : 0},
                     {"said", said_},
                     {"not_said", not_said_},
                     {"heard", heard_},
                     {"odd", odd_},
                     {"lost_by_dds", reader_ ? reader_->lost() : 0},
                     {"lost_to_robot", robot_.lost()}};
}

}  // namespace sinew::net
