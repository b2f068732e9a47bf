#pragma once
// What all connections share: the place, its robots by name, which pictures are where, and what was counted.
#include <array>
#include <map>
#include <string>
#include <vector>

#include "sim_hil/places/place.hpp"
#include "sim_hil/usarsim/frame.hpp"
#include "sim_hil/usarsim/robot_class.hpp"

namespace sinew::usarsim {

struct Options {
  bool sonars_together = true;  // UT2004's form: all in one brace; false: UDK's, a line each
  Frame frame;
  std::uint32_t tile_width = 320, tile_height = 240;  // of one camera
  int image_type = 2;                                 // 0: raw; 1 (superb) to 5 (bad): JPEG
  bool legacy = false;                                // a picture goes out as soon as an image client connects
};

/// A camera's picture among others in one.
struct Tile {
  std::size_t slot = plant::kMostRobots;  // whose camera; kMostRobots: black
  std::uint32_t x = 0, y = 0;
};
struct Wall {
  std::uint32_t width = 0, height = 0;
  std::vector<Tile> tiles;
};

/// What clients did, for the report.
struct Counts {
  std::uint64_t connections = 0, robots = 0, refused = 0;  // refused: INIT that gave no robot
  std::uint64_t lines = 0, dropped = 0;     // dropped: no text, too long, or torn by the end of a connection
  std::uint64_t torn = 0;                   // braces that do not fit
  std::uint64_t unknown = 0, unusable = 0;  // of no known type; without what their type needs
  std::uint64_t sent = 0, unsent = 0;       // lines; unsent: the client did not read
  std::uint64_t frames = 0, image_clients = 0, skipped = 0;  // skipped: bytes of image clients that ask for nothing
  std::map<std::string, std::uint64_t> of_type{};            // unknown types, the first kMostTypes
  static constexpr std::size_t kMostTypes = 20;
};

/// Thread:  owner.
class Game {
 public:
  struct Bot {
    std::string name;
    const RobotClass* kind = nullptr;
    std::size_t slot = 0;
  };

  Game(plant::Place& place, const Options& options) : place_(place), options_(options) {}

  plant::Place& place() { return place_; }
  const plant::Place& place() const { return place_; }
  const Options& options() const { return options_; }
  double now_s() const { return msg::seconds(place_.now()); }
  Counts& counts() { return counts_; }
  const Counts& counts() const { return counts_; }

  /// A robot's time in the place, for the report.
  struct Visit {
    std::string name;
    const RobotClass* kind = nullptr;
    double from_s = 0, until_s = 0, driven_m = 0, highest_m = 0;
    std::uint32_t touches = 0;
    bool stands = false;
    math::Vec3 from_m, to_m;   // Sinew's world
    std::uint64_t drives = 0;  // DRIVE lines that it obeyed
    plant::Verdict verdict{};
  };
  static constexpr std::size_t kMostVisits = 256;  // the first ones

  // ---- robots
  void add(const Bot& bot) { bots_.push_back(bot); }
  void add_visit(const Visit& visit) {
    if (visits_.size() < kMostVisits) visits_.push_back(visit);
  }
  const std::vector<Visit>& visits() const { return visits_; }
  void remove(std::size_t slot);
  /// In any case; null: there is none.
  const Bot* find(std::string_view name) const;
  const std::vector<Bot>& bots() const { return bots_; }

  // ---- pictures
  /// From now on clients at this address see these cameras (by slot; kMostRobots: none) in one or four parts. Empty
  /// address: all clients without a choice of their own.
  void show(const std::string& address, const std::vector<std::size_t>& slots);
  /// What a client at this address sees: its choice, or all cameras side by side, four in a row.
  Wall wall(const std::string& address) const;
  /// Where a robot's camera is on the wall of all; -1: nowhere.
  int view_of(std::size_t slot) const;

 private:
  plant::Place& place_;
  Options options_;
  std::vector<Bot> bots_;
  std::map<std::string, std::vector<std::size_t>> shown_;
  std::vector<Visit> visits_;
  Counts counts_;
};

}  // namespace sinew::usarsim
