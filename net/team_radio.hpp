#pragma once
#include <memory>

#include "net/local_link.hpp"
#include "net/part.hpp"

namespace sinew::net {

/// The radio of a team on one DDS topic, best effort: datagrams of the robot beside us to all, and of all to it.
/// The topic is sinew_team_N, of type sinew::TeamDatagram { sequence<octet, 1200> data; } without a key.
class TeamRadio final : public Part {
 public:
  TeamRadio(std::uint32_t team, LocalLink& robot);
  bool start(Participant& participant, std::string& why) override;
  std::vector<OwnEndpoint> endpoints() const override;
  void look(hal::Time now) override;
  void add_status(nlohmann::json& status) const override;

 private:
  void say(std::span<const std::uint8_t> datagram);

  EndpointSpec spec_;
  LocalLink& robot_;
  std::unique_ptr<DdsWriter> writer_;
  std::unique_ptr<DdsReader> reader_;
  DdsSample sample_;
  std::vector<std::uint8_t> cdr_;
  std::uint64_t said_ = 0, not_said_ = 0, heard_ = 0, odd_ = 0;
};

/// Of `datagram` as the type above. Nothing: `cdr` is no such sample.
std::optional<std::span<const std::uint8_t>> datagram_of(std::span<const std::uint8_t> cdr);

}  // namespace sinew::net
