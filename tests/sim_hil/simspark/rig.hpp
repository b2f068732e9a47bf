#pragma once
// An agent and a monitor without sockets, and the arena that they are in.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "apps/toml/body_reader.hpp"
#include "sim_hil/simspark/session.hpp"

namespace sinew::test {
std::string source_dir();
}

namespace sinew::simspark {

inline kinematics::Body spark_body(const std::string& file = "spark/nao_spark") {
  app::LoadedBody loaded = app::load_body(test::source_dir() + "/robots/" + file + ".toml");
  for (const auto& p : loaded.problems) ADD_FAILURE() << rt::to_string(p, file.c_str());
  return loaded.body;
}

/// Bytes of a message, with their length before them.
inline std::string framed(std::string_view text) {
  std::string frame;
  for (int shift = 24; shift >= 0; shift -= 8) frame += static_cast<char>(text.size() >> shift & 0xFFU);
  return frame += text;
}

template <class S>
class Peer {
 public:
  Peer(SparkArena& arena, DoorCounts& counts) : session_(std::make_unique<S>(arena, counts, "10.0.0.1")) {}
  void send(std::string_view bytes) { session_->receive(std::as_bytes(std::span(bytes.data(), bytes.size()))); }
  void say(std::string_view text) { send(framed(text)); }
  /// All messages since the last call.
  std::vector<std::string> hear() {
    std::vector<char> buffer(Connection::kMostFrame);
    wire::SparkFrames frames(buffer);
    std::vector<std::string> all;
    const std::string waiting(session_->waiting());
    for (const char c : waiting)
      if (frames.push(c)) all.emplace_back(frames.text());
    session_->drop_sent(waiting.size());
    return all;
  }
  S& session() { return *session_; }
  void leave() { session_.reset(); }
  bool is_here() const { return session_ != nullptr; }

 private:
  std::unique_ptr<S> session_;
};
using Agent = Peer<AgentSession>;
using Monitor = Peer<MonitorSession>;

struct Rig {
  explicit Rig(std::size_t players = 2, std::uint64_t seed = 1, GameRules rules = {}) : body(spark_body()) {
    std::string why;
    arena = SparkArena::create({.body = &body, .players = players, .seed = seed, .rules = rules}, why);
    EXPECT_TRUE(arena) << why;
  }
  Agent& agent() { return *agents.emplace_back(std::make_unique<Agent>(*arena, counts)); }
  Monitor& monitor() { return *monitors.emplace_back(std::make_unique<Monitor>(*arena, counts)); }
  /// That plays.
  Agent& player(const std::string& team, int number) {
    Agent& a = agent();
    a.say("(scene rsg/agent/nao/nao.rsg)");
    a.say("(init (unum " + std::to_string(number) + ")(teamname " + team + "))");
    EXPECT_TRUE(a.session().player()) << a.session().why();
    return a;
  }
  void cycle(int n = 1) {
    for (int i = 0; i < n; ++i) {
      arena->step();
      for (const auto& a : agents)
        if (a->is_here()) a->session().tell();
      for (const auto& m : monitors) m->session().tell();
    }
  }
  const plant::BodyTruth& truth(Agent& a) const { return arena->pitch().truth(*a.session().player()); }

  kinematics::Body body;
  std::unique_ptr<SparkArena> arena;
  DoorCounts counts;
  std::vector<std::unique_ptr<Agent>> agents;
  std::vector<std::unique_ptr<Monitor>> monitors;
};

}  // namespace sinew::simspark
