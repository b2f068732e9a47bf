#include "apps/sim/simspark_serve.hpp"

#include <cstdio>

#include "hal/linux/process.hpp"
#include "hal/linux/socket.hpp"
#include "hal/platform.hpp"
#include "sim_hil/worlds/json_object.hpp"

namespace sinew::plant {
namespace {

int simspark_failed(const std::string& what, const hal::Error& error) {
  std::fprintf(stderr, "sinew-sim: %s: %s (%s, %lld)\n", what.c_str(), hal::to_string(error.code), error.where,
               static_cast<long long>(error.detail));
  return 1;
}

void wait_for_clients(std::span<const std::intptr_t> handles, hal::Duration patience) {
  std::vector<hal::Waiting> all;
  for (const std::intptr_t handle : handles) all.push_back({.handle = handle});
  // Errors: none of these is one that hal::Waiting refuses; at worst it does not wait.
  static_cast<void>(hal::wait_ready(std::span(all).first(std::min(all.size(), hal::kMaxWaiting)), patience));
}

void print_simspark(const simspark::Server& server, const simspark::SparkArena& arena, std::uint64_t late) {
  const simspark::DoorCounts& c = server.counts();
  const auto n = [](std::uint64_t count) { return static_cast<unsigned long long>(count); };
  for (const std::string& line : c.news) std::printf("%s\n", line.c_str());
  std::printf("ended in play mode %s after %.2f s, %llu cycles, score %d:%d; the clock was late %llu times\n",
              std::string(to_string(arena.game().mode())).c_str(), arena.now_s(), n(server.cycles()),
              arena.game().score(simspark::Team::left), arena.game().score(simspark::Team::right), n(late));
  std::printf(
      "%llu connections, %llu players, %llu refused, %llu let go; %llu messages came, %llu were sent, %llu found no "
      "reader\n",
      n(c.connections), n(c.agents), n(c.refused), n(c.closed), n(c.messages), n(c.sent), n(c.unsent));
  std::printf("not obeyed: %llu before (init), %llu beams in a play mode without, %llu of unknown type", n(c.early),
              n(c.not_now), n(c.unknown));
  for (const auto& [type, count] : c.of_type) std::printf(", %s: %llu", type.c_str(), n(count));
  std::printf("\n");
}

std::string simspark_json(const simspark::Server& server, const simspark::SparkArena& arena, std::uint64_t late) {
  const simspark::DoorCounts& c = server.counts();
  JsonObject types, all;
  for (const auto& [type, count] : c.of_type) types.integer(type.c_str(), count);
  std::vector<std::string> players, news;
  for (std::size_t i = 0; i < arena.players(); ++i) {
    const simspark::PlayerCounts& p = arena.counts(i);
    JsonObject player;
    player.integer("cycles", p.cycles);
    player.number("walked_m", p.walked_m);
    player.integer("falls", p.falls);
    player.integer("beams", p.beams);
    player.number("x_m", arena.pitch().truth(i).torso.p_m.x);
    player.number("y_m", arena.pitch().truth(i).torso.p_m.y);
    players.push_back(player.done());
  }
  for (const std::string& line : c.news) {
    JsonObject text;
    text.text("text", line);
    news.push_back(text.done());
  }
  all.text("world", "simspark");
  all.number("plant_s", arena.now_s());
  all.text("play_mode", std::string(to_string(arena.game().mode())));
  all.integer("score_left", static_cast<std::uint64_t>(arena.game().score(simspark::Team::left)));
  all.integer("score_right", static_cast<std::uint64_t>(arena.game().score(simspark::Team::right)));
  all.number("ball_x_m", arena.pitch().ball().p_m.x);
  all.number("ball_y_m", arena.pitch().ball().p_m.y);
  all.integer("clock_late", late);
  all.integer("physics_warnings", arena.pitch().trouble());
  const std::pair<const char*, std::uint64_t> numbers[] = {
      {"cycles", server.cycles()}, {"connections", c.connections}, {"agents", c.agents},     {"monitors", c.monitors},
      {"refused", c.refused},      {"closed", c.closed},           {"messages", c.messages}, {"sent", c.sent},
      {"unsent", c.unsent},        {"unknown", c.unknown},         {"early", c.early},       {"not_now", c.not_now}};
  for (const auto& [key, value] : numbers) all.integer(key, value);
  all.object("unknown_types", types.done());
  all.list("players", players);
  all.list("news", news);
  return all.done();
}

}  // namespace

int serve_simspark(const SimulatorOptions& s, std::string& report) {
  static_cast<void>(hal::stop_requested());  // from here on a signal only asks for the end
  simspark::ArenaOptions options;
  options.body = s.session.world.body_of(0);
  options.players = s.simspark.players;
  options.seed = s.session.seed.value_or(1);
  options.rules.kick_off_after_s = s.simspark.kick_off_s;
  options.rules.half_s = s.simspark.half_s;
  options.beam_noise = !s.simspark.exact_beam;
  std::string why;
  const auto arena = simspark::SparkArena::create(options, why);
  if (!arena) {
    std::fprintf(stderr, "sinew-sim: --serve simspark: %s\n", why.c_str());
    return kUsage;
  }
  simspark::Server::Doors doors;
  auto agents = hal::listen_stream(s.listen);
  if (!agents) return simspark_failed("cannot listen on " + s.listen, agents.error());
  doors.agents = std::move(*agents);
  if (s.simspark.monitor_listen != "none") {
    auto monitors = hal::listen_stream(s.simspark.monitor_listen);
    if (!monitors) return simspark_failed("cannot listen on " + s.simspark.monitor_listen, monitors.error());
    doors.monitors = std::move(*monitors);
  }
  doors.address = hal::peer_address;
  doors.wait = wait_for_clients;
  std::printf("SimSpark with %zu bodies (%s): agents on %s, monitors on %s, %s\n", arena->players(),
              options.body->name.c_str(), doors.agents->endpoint().c_str(),
              doors.monitors ? doors.monitors->endpoint().c_str() : "none",
              s.simspark.sync ? "each cycle waits for (syn)" : "a cycle each 20 ms");
  std::fflush(stdout);
  simspark::Server server(hal::system_os(), *arena, s.simspark.server(), std::move(doors));
  const std::uint64_t late = server.run(s.session.duration_s, &hal::stop_requested);
  server.close();
  print_simspark(server, *arena, late);
  report = simspark_json(server, *arena, late);
  return 0;
}

}  // namespace sinew::plant
