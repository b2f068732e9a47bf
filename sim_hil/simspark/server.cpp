#include "sim_hil/simspark/server.hpp"

#include <algorithm>

namespace sinew::simspark {

using hal::Duration;
using hal::Time;

Server::Server(hal::Os& os, SparkArena& arena, const ServerOptions& options, Doors doors)
    : os_(os), arena_(arena), options_(options), doors_(std::move(doors)) {}

void Server::hear_all() {
  counts_.refused += sim_hil::welcome(*doors_.agents, agents_, kMostClients, [&](const hal::Stream& stream) {
    return std::make_unique<AgentSession>(arena_, counts_, doors_.address(stream));
  });
  const std::size_t before = monitors_.size();
  if (doors_.monitors)
    counts_.refused += sim_hil::welcome(*doors_.monitors, monitors_, kMostMonitors, [&](const hal::Stream& stream) {
      return std::make_unique<MonitorSession>(arena_, counts_, doors_.address(stream));
    });
  counts_.monitors += monitors_.size() - before;
  for (auto& client : agents_) hear(client);
  for (auto& client : monitors_) {
    hear(client);
    for (const std::size_t slot : client.session->take_killed())
      for (auto& agent : agents_)
        if (agent.session->player() == slot) agent.session->close("a monitor wants it gone");
  }
  tell_all();  // percepts of a scene come at once
}

void Server::tell_all() {
  for (auto& client : agents_) tell(client);
  for (auto& client : monitors_) tell(client);
  const auto over = [](const auto& client) { return client.over(); };
  std::erase_if(agents_, over);
  std::erase_if(monitors_, over);
}

bool Server::all_synced() const {
  std::size_t players = 0;
  for (const auto& client : agents_) {
    if (!client.session->synced()) return false;
    if (client.session->player()) ++players;
  }
  return players > 0 && players >= std::min(options_.agents, arena_.players());
}

void Server::let_go_silent() {
  if (os_.now() - last_cycle_ < options_.patience) return;
  for (auto& client : agents_)
    if (!client.session->synced()) client.session->close("did not say (syn) in time");
  last_cycle_ = os_.now();
}

void Server::cycle() {
  arena_.step();
  ++cycles_;
  for (auto& client : agents_) client.session->tell();
  for (auto& client : monitors_) client.session->tell();
  tell_all();
  last_cycle_ = os_.now();
}

void Server::sleep(Time until) {
  const Duration left = until - os_.now();
  if (left <= Duration{0}) return;
  if (!doors_.wait) return os_.sleep_until(until);
  std::vector<std::intptr_t> handles{doors_.agents->handle()};
  if (doors_.monitors) handles.push_back(doors_.monitors->handle());
  for (const auto& client : agents_) handles.push_back(client.stream->handle());
  for (const auto& client : monitors_) handles.push_back(client.stream->handle());
  doors_.wait(handles, left);
}

std::uint64_t Server::run(double duration_s, const std::function<bool()>& stop) {
  std::uint64_t late = 0;
  last_cycle_ = os_.now();
  Time due = os_.now() + kTick;
  const auto killed = [&] { return std::ranges::any_of(monitors_, [](const auto& m) { return m.session->kills(); }); };
  while (!stop() && !killed() && (duration_s <= 0 || arena_.now_s() < duration_s)) {
    hear_all();
    if (options_.sync) {
      if (all_synced()) {
        cycle();
        continue;
      }
      let_go_silent();
      sleep(os_.now() + kTick);
      continue;
    }
    if (os_.now() < due) {
      os_.sleep_until(due);
      hear_all();
    }
    cycle();
    due = due + kTick;
    if (os_.now() - due > kMostLateTicks * kTick) ++late, due = os_.now() + kTick;
  }
  return late;
}

}  // namespace sinew::simspark
