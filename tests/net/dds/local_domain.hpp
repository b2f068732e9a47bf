#pragma once
// A DDS domain of this test process alone, on the loopback interface and without multicast.
#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "net/dds/participant.hpp"

namespace sinew::net::test {

/// The tag keeps the participants of other tests on this machine out.
inline ParticipantOptions local_domain() {
  ParticipantOptions o;
  o.domain = 60;
  o.interfaces = {"lo"};
  o.multicast = false;
  o.peers = {"127.0.0.1"};
  o.extra = "<Discovery><Tag>sinew-test-" + std::to_string(getpid()) + "</Tag></Discovery>";
  return o;
}

inline std::unique_ptr<Participant> joined(const ParticipantOptions& options = local_domain()) {
  std::string why;
  auto opened = Participant::open(options, why);
  EXPECT_TRUE(opened) << why;
  return opened ? std::move(*opened) : nullptr;
}

/// Waits on the participant's descriptor until `done`; half a minute at most.
inline bool becomes(Participant& participant, const std::function<bool()>& done) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (std::chrono::steady_clock::now() < end) {
    participant.begin_look();
    if (done()) return true;
    pollfd fd{participant.wake_fd(), POLLIN, 0};
    poll(&fd, 1, 1000);
  }
  return false;
}

}  // namespace sinew::net::test
