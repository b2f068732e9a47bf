#pragma once
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "sim_hil/usarsim/session.hpp"

namespace sinew::usarsim {

/// A flat place with a wall at x = 4 to the north (y > 0.5), and three start poses.
inline plant::PlaceMap flat() {
  plant::PlaceMap map;
  map.name = "Flat";
  map.solids.push_back({plant::Shape::plane, {}, {}, {}});
  map.solids.push_back({plant::Shape::box, {4.5, 5.5, 1}, {}, {0.5, 5, 1}});
  map.starts = {{"Pose1", {0, 0, 0}, 0}, {"Pose2", {0, 2, 0}, 0}, {"Pose3", {0, -2, 0}, math::kPi / 2}};
  map.target_way = {{8, -8, 0.25}};
  map.latitude_deg = 39.5, map.longitude_deg = -77.25;
  return map;
}

/// A session without a socket.
class Client {
 public:
  Client(Game& game, std::uint64_t number = 1, std::string address = "10.0.0.1")
      : session_(std::make_unique<Session>(game, std::move(address), number)) {}
  void send(std::string_view bytes) { session_->receive(std::as_bytes(std::span(bytes.data(), bytes.size()))); }
  void say(std::string_view line) {
    send(line);
    send("\r\n");
  }
  /// All lines since the last call.
  std::vector<std::string> hear() {
    const std::string all(session_->waiting());
    session_->drop_sent(all.size());
    std::vector<std::string> lines;
    for (std::size_t at = 0; at < all.size();) {
      const auto end = all.find("\r\n", at);
      EXPECT_NE(end, std::string::npos);
      if (end == std::string::npos) break;
      lines.push_back(all.substr(at, end - at));
      at = end + 2;
    }
    return lines;
  }
  /// The last of those that begin so; empty: none.
  std::string last(std::string_view begin) {
    std::string found;
    for (const std::string& line : hear())
      if (line.starts_with(begin)) found = line;
    return found;
  }
  const Robot* robot() const { return session_->robot(); }
  Session& session() { return *session_; }
  void leave() { session_.reset(); }

 private:
  std::unique_ptr<Session> session_;
};

/// The place, its clients, and time.
struct Rig {
  explicit Rig(Options o = {}, plant::PlaceMap map = flat()) : place(std::move(map), {1, 0, false}), game(place, o) {}
  Client& client(std::string address = "10.0.0.1") {
    clients.push_back(std::make_unique<Client>(game, clients.size() + 1, std::move(address)));
    return *clients.back();
  }
  /// With a robot of this class.
  Client& with(const std::string& kind, const std::string& rest = "{Start Pose1}") {
    Client& c = client();
    c.say("INIT {ClassName USARBot." + kind + "} {Name R" + std::to_string(clients.size()) + "} " + rest);
    EXPECT_TRUE(c.robot());
    return c;
  }
  void wait(double seconds) {
    for (int i = 0; i < seconds * 1e9 / plant::kStepNs; ++i) {
      place.advance({});
      for (const auto& c : clients) c->session().tick();
    }
  }
  const plant::BodyState& body(const Client& c) const { return c.robot()->vehicle().body(); }

  plant::Place place;
  Game game;
  std::vector<std::unique_ptr<Client>> clients;
};

}  // namespace sinew::usarsim
