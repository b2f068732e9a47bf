#pragma once
// A pitch of RoboCup's 3D soccer simulation: bodies that clients take and leave, a ball, play modes, what is heard.
// It knows bytes of no client (session.hpp does), and no socket and no clock (server.hpp).
//
//   auto arena = SparkArena::create({.body = body, .players = 2, .seed = 1}, why);
//   const auto slot = (*arena)->enter("RED", 1, why);
//   (*arena)->drive(*slot, joint, 1.5);                     // rad/s, until it is told otherwise
//   (*arena)->step();                                       // 20 ms
//   (*arena)->sense(*slot, percepts);
//
// Motors:  SimSpark's turn at the speed that they are told and hold where they are told to stand, with at most 10 N m.
//          Here a servo of speed is drawn to the integral of the speed, too, which stays within kMostAhead_rad of the
//          joint. Robots that no client has stand behind the line at y = -10.
// Thread:  owner.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/result.hpp"
#include "kinematics/body.hpp"
#include "math/random.hpp"
#include "sim_hil/pitch/pitch.hpp"
#include "sim_hil/pitch/stance.hpp"
#include "sim_hil/simspark/game.hpp"
#include "sim_hil/simspark/joints.hpp"
#include "sim_hil/simspark/vision.hpp"
#include "wire/text/simspark.hpp"

namespace sinew::simspark {

inline constexpr std::size_t kMostPlayers = 22, kMostOfTeam = 11;
inline constexpr std::size_t kMostSaid = 20;  // characters of a (say)
inline constexpr double kMostAhead_rad = 0.25;

struct ArenaOptions {
  const kinematics::Body* body = nullptr;  // of all players; copied
  std::size_t players = 2;                 // bodies that are there
  std::uint64_t seed = 1;
  GameRules rules{};
  bool beam_noise = true;  // as the server: up to 5 cm and 10 degrees
};

/// What became of a player, for the report.
struct PlayerCounts {
  std::uint64_t cycles = 0;
  double walked_m = 0;
  std::uint32_t falls = 0, beams = 0;
};

class SparkArena {
 public:
  /// Errors:  nothing, and `why`: the body is not of the class of Nao, or MuJoCo refuses it.
  static std::unique_ptr<SparkArena> create(const ArenaOptions& options, std::string& why);

  // ---- clients
  /// `number` 0: the lowest that is free. Errors: nothing, and `why`: no body or number is free, a third team.
  std::optional<std::size_t> enter(std::string_view team, std::uint32_t number, std::string& why);
  void leave(std::size_t slot);
  void drive(std::size_t slot, std::size_t joint, double radps);
  /// In the team's own frame, its goal at -x. False: not in this play mode.
  bool beam(std::size_t slot, double x_m, double y_m, double degrees);
  void say(std::size_t slot, std::string_view text);

  /// One cycle.
  void step();
  /// All that this player feels and sees now. Texts live until the next call on the arena.
  void sense(std::size_t slot, wire::SparkPercepts& out);
  /// What a client without a player gets.
  void sense_nobody(wire::SparkPercepts& out) const;

  // ---- monitors
  SparkGame& game() { return game_; }
  const SparkGame& game() const { return game_; }
  void put_ball(const math::Vec3& p_m, const math::Vec3& v_mps);
  void put_player(std::size_t slot, double x_m, double y_m, double heading_rad);
  std::optional<std::size_t> find(Team team, std::uint32_t number) const;
  std::string_view team_name(Team team) const { return team_[index(team)]; }

  double now_s() const { return kStart_s + 1e-9 * static_cast<double>(pitch_->now_ns()); }
  const plant::Pitch& pitch() const { return *pitch_; }
  const PlayerCounts& counts(std::size_t slot) const { return slot_[slot].counts; }
  std::size_t players() const { return slot_.size(); }

 private:
  static constexpr double kStart_s = 0;
  struct Slot {
    bool taken = false, told = false;  // told: its number and side
    Team team = Team::left;
    std::uint32_t number = 0;
    std::array<double, kJoints> speed_radps{}, target_rad{};
    std::optional<SparkVision> vision{};
    math::Random random{0};
    math::Vec3 v_before_mps, accel_mps2;
    std::string said{}, saying{};
    int heard_before[2] = {-10, -10};  // cycle in which it heard its own team, the other one
    bool down = false;
    math::Vec3 mark_m;
    double mark_s = -1;
    PlayerCounts counts{};
  };
  SparkArena(const ArenaOptions& options, const SparkJointMap& map)
      : options_(options), game_(options.rules), map_(map) {}
  void park(std::size_t slot);
  void stand_at(std::size_t slot, double x_m, double y_m, double heading_rad);
  void count(Slot& slot, const plant::BodyTruth& truth);
  void feel(std::size_t slot, wire::SparkPercepts& out) const;
  void hear(std::size_t slot, wire::SparkPercepts& out);
  kinematics::Pose eye(std::size_t slot) const;
  SeenPlayer seen(std::size_t slot) const;

  ArenaOptions options_;
  kinematics::Body body_;
  SparkGame game_;
  SparkJointMap map_;
  std::unique_ptr<plant::Pitch> pitch_;
  std::vector<Slot> slot_;
  std::array<std::string, 2> team_;
  std::array<std::optional<plant::Sole>, 2> sole_{};
  std::size_t eye_link_ = 0;
  kinematics::Pose eye_in_link_;
  std::int64_t cycle_ = 0;
  std::uint64_t entered_ = 0;
};

}  // namespace sinew::simspark
