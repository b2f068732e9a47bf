#include "net/bridge/ros2_part.hpp"

namespace sinew::net {

bool Ros2Part::start(Participant& participant, std::string& why) {
  bridge_ = std::make_unique<Ros2Bridge>(robot_, spec_);  // anew: the endpoints of one before went with its participant
  if (bridge_->start(participant, why)) return true;
  bridge_.reset();
  return false;
}

std::vector<OwnEndpoint> Ros2Part::endpoints() const {
  return bridge_ ? bridge_->endpoints() : std::vector<OwnEndpoint>();
}

void Ros2Part::look(hal::Time) {
  if (bridge_) bridge_->look();
}

void Ros2Part::add_status(nlohmann::json& status) const {
  if (bridge_) bridge_->add_status(status);
}

}  // namespace sinew::net
