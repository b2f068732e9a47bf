#pragma once
// Who is connected to a door of a simulator that speaks another one's protocol: streams, each with a session of bytes.
// A session S has receive(bytes), waiting(): what is to be sent, and drop_sent(count); closed() where it ends by
// itself. Thread:  owner; nothing here waits.
#include <array>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "hal/stream.hpp"

namespace sinew::sim_hil {

template <class S>
struct DoorClient {
  std::unique_ptr<hal::Stream> stream;
  std::unique_ptr<S> session;
  bool gone = false;

  bool over() const {
    if constexpr (requires { session->closed(); }) return gone || session->closed();
    return gone;
  }
};

/// Takes in who stands at the door: `make(stream)` makes the session. Returns how many were one too many.
template <class S, class Make>
std::uint64_t welcome(hal::Listener& door, std::vector<DoorClient<S>>& clients, std::size_t most, Make&& make) {
  std::uint64_t refused = 0;
  while (auto stream = door.accept(hal::Duration{0})) {
    if (clients.size() == most) {
      ++refused;
      continue;  // closes it
    }
    auto session = make(**stream);
    clients.push_back({std::move(*stream), std::move(session)});
  }
  return refused;
}

template <class S>
void hear(DoorClient<S>& client) {
  std::array<std::byte, 16384> buffer;
  constexpr int kMostReads = 4;  // of one client at a time
  for (int i = 0; i < kMostReads && !client.over(); ++i) {
    const auto n = client.stream->read_now(buffer);
    client.gone = client.gone || !n;
    if (!n || *n == 0) return;
    client.session->receive({buffer.data(), *n});
  }
}

template <class S>
void tell(DoorClient<S>& client) {
  while (!client.gone && !client.session->waiting().empty()) {
    const std::string_view text = client.session->waiting();
    const auto n = client.stream->write_now(std::as_bytes(std::span(text.data(), text.size())));
    client.gone = !n;
    if (!n || *n == 0) return;
    client.session->drop_sent(*n);
  }
}

}  // namespace sinew::sim_hil
