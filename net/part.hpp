#pragma once
#include <poll.h>
#include <nlohmann/json_fwd.hpp>

#include <string>
#include <vector>

#include "hal/clock.hpp"
#include "net/dds/match.hpp"
#include "net/dds/participant.hpp"

namespace sinew::net {

/// One thing that the program does with DDS: the team's radio, the bridge to ROS 2.
/// Thread:  owner, all of it on the thread of Service::run().
class Part {
 public:
  virtual ~Part() = default;
  /// Makes its endpoints. False, with `why`: it cannot; the program then tries anew, as without a network.
  virtual bool start(Participant& participant, std::string& why) = 0;
  /// Its endpoints, after start(): those of others that do not match them are named.
  virtual std::vector<OwnEndpoint> endpoints() const = 0;
  /// Adds descriptors that it waits for; look() is called when one of them is ready.
  virtual void add_fds(std::vector<pollfd>&) const {}
  /// DDS, one of its descriptors or ten times a second nothing: reads what is there, writes what is due. Never waits.
  virtual void look(hal::Time now) = 0;
  /// Of the network, before start() and when it changes; empty: all is well.
  virtual void set_trouble(const std::string&) {}
  /// Adds its figures to the status, under a key of its own.
  virtual void add_status(nlohmann::json& status) const = 0;
};

}  // namespace sinew::net
