#pragma once
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "net/addresses.hpp"
#include "net/local_link.hpp"
#include "net/other_domains.hpp"
#include "net/part.hpp"

namespace sinew::net {

struct ServiceOptions {
  std::string robot;
  ParticipantOptions dds{};
  int attempt = 0;                                // how often it has failed before
  std::function<bool()> stop{};                   // true: end
  std::function<void()> alive{};                  // called each second while run() does not hang
  std::function<void(const std::string&)> say{};  // a line for people
};

/// The program beside the robot: a participant, what its parts do with it, and how it is.
///
/// Without a network, or with a configuration that Cyclone refuses, it goes on without DDS, says so to the robot, and
/// ends with `anew` after a while (longer each time, to kMostPause) or as soon as an address comes. It ends with `anew`
/// also when an address changes: Cyclone does not follow that. Whoever started it then starts a new process.
/// Thread:  owner.
class Service {
 public:
  enum class End { stopped, anew, failed };  // failed: anew, after another failure

  /// The parts' sockets are of `link`.
  Service(ServiceOptions options, LocalLink& link, std::vector<std::unique_ptr<Part>> parts);
  ~Service();
  End run();
  std::string status() const;  // JSON

  static constexpr hal::Duration kFirstPause = std::chrono::milliseconds(500), kMostPause = std::chrono::seconds(30);
  static hal::Duration pause_after(int attempt);

 private:
  bool open();
  void wait();
  void look_each_second(hal::Time now);
  void look_for_unmatched();
  void look_for_one_way(hal::Time now);
  void note(const std::string& line);
  std::string name_of(const Guid& participant) const;

  struct Unmatched {
    std::string topic, why;
    Guid endpoint{}, participant{};
    bool writes = false;
  };

  ServiceOptions options_;
  LocalLink& link_;
  std::vector<std::unique_ptr<Part>> parts_;
  AddressWatch watch_;
  std::unique_ptr<Participant> participant_;
  std::optional<OtherDomains> others_;
  std::string trouble_;  // of opening
  hal::Time begin_{}, second_{};
  std::vector<RemoteParticipant> participants_;
  std::map<Guid, hal::Time> silent_since_;  // participants without an endpoint
  std::vector<Unmatched> unmatched_;
  std::set<std::string> told_;
  std::deque<std::string> log_;
};

/// The name in a participant's user data, "sinew=NAME;"; empty: it is no `sinew net`.
std::string robot_in(const std::string& user_data);

}  // namespace sinew::net
