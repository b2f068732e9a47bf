#pragma once
// What SimSpark (rcssserver3d, RoboCup's 3D soccer simulation) and its agents say to each other over TCP (port 3100):
// frames of a length and a text of S-expressions. One message of percepts from the server each cycle of 20 ms; one of
// effectors, "(he1 1.5)(lle1 0)(syn)", from the agent.
//
//   SparkFrames frames(buffer);                          // bytes in, texts out
//   if (frames.push(c)) parse_spark_percepts(frames.text(), percepts);
//   percepts.joint[0].degrees;
//
//   SparkWriter out(buffer);                             // and back
//   out.effector("he1", 1.5).sync();
//   send(out.frame());                                   // with its length; empty: it did not fit
//
// The league's MuJoCo server (rcsssmj, port 60000, monitors 60001) has the same frames and expressions, but for these:
// no scene, "(init T1 RED 2)" is the first message and percepts come behind it; motors take "(he1 q dq kp kd tau)" in
// degrees; joints say their speed, too, "(HJ (n hj1) (ax 1.43) (vx 0.03))"; "(pos ...)" and "(quat ...)" say where the
// torso is; GS has both teams' names and not the own number; its axes are x ahead, y left, z up.
//
// Frames:  torso: x right, y ahead, z up (SimSpark's); pol: distance (m), azimuth (left positive) and elevation (up
//          positive) in degrees from the camera.
// Source:  the SimSpark wiki (Network Protocol, Perceptors, Effectors); rcssserver3d 0.7.3 as it was seen on the wire;
//          the user guide of rcsssmj (Agent Protocol).
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace sinew::wire {

inline constexpr std::size_t kSparkDepth = 12;  // of parentheses; percepts need 5

/// Cuts a stream into the texts of its frames. A frame longer than the buffer is skipped as a whole and counted.
/// RT: yes; a character costs a store.
class SparkFrames {
 public:
  explicit SparkFrames(std::span<char> buffer) noexcept : buffer_(buffer) {}
  /// True: text() is a new one.
  bool push(char c) noexcept;
  /// Until the next push(). May be empty.
  std::string_view text() const noexcept { return {buffer_.data(), size_}; }
  std::uint64_t dropped() const noexcept { return dropped_; }
  /// The connection is a new one.
  void reset() noexcept { *this = SparkFrames(buffer_, dropped_); }

 private:
  SparkFrames(std::span<char> buffer, std::uint64_t dropped) noexcept : buffer_(buffer), dropped_(dropped) {}

  std::span<char> buffer_;
  std::uint64_t dropped_ = 0;
  std::size_t size_ = 0;
  std::uint32_t length_ = 0, head_bytes_ = 0, taken_ = 0;
  bool complete_ = false;
};

enum class SparkError : std::uint8_t {
  none,
  parenthesis,  // one that does not close, or that was not opened
  depth,        // more than kSparkDepth
  text,         // a word outside of parentheses, or a byte that is no printable character
  number,       // a word where a finite number has to be
  missing,      // a value is not there: "(GYR (n torso))"
  too_many,     // more joints, sightings, ... than there is room for
};

struct SparkPolar {
  double distance_m = 0, azimuth_deg = 0, elevation_deg = 0;
};

struct SparkJoint {
  std::string_view name;  // "hj1", "rlj3"
  double degrees = 0;
  bool has_speed = false;  // MuJoCo server
  double degrees_per_s = 0;
};

/// MuJoCo server: where a thing is in the world, or how it is turned there.
struct SparkPlace {
  std::string_view name;  // "torso_pos", "torso_quat"
  bool is_turn = false;
  std::array<double, 3> position_m{};
  std::array<double, 4> q{1, 0, 0, 0};  // w, x, y, z
};

/// One foot in contact; coordinates of the foot's own frame.
struct SparkForce {
  std::string_view name;  // "lf", "rf"
  std::array<double, 3> center_m{}, force_n{};
};

struct SparkSeen {
  enum class Kind : std::uint8_t {
    landmark,  // `name`: F1L F1R F2L F2R flags at the corners, G1L ... the goals' posts
    ball,
    player,  // one part of it: `name` is head, rlowerarm, llowerarm, rfoot or lfoot
    line     // from `at` to `to`
  };
  Kind kind = Kind::landmark;
  std::string_view name, team;
  std::uint32_t number = 0;  // of a player; 0: not said
  SparkPolar at, to;
};

struct SparkHeard {
  double time_s = 0;
  std::string_view team, text;  // team: empty when the server does not say it
  bool self = false;
  double direction_deg = 0;  // without `self`
};

/// "(TopCameraIMG (s 320 240)(d ...))": raw RGB as base64.
struct SparkImage {
  std::string_view name, base64;
  std::uint32_t width = 0, height = 0;
};

/// One message of the server. Texts point into the message. What a message does not have is as here; whether there is a
/// gyro, an accelerometer and a game state say the flags.
struct SparkPercepts {
  double now_s = 0;
  bool has_game = false, has_gyro = false, has_acceleration = false;

  std::uint32_t number = 0;  // own; 0: not yet known
  std::string_view side;     // "left", "right"; empty: not yet known
  std::uint32_t left_goals = 0, right_goals = 0;
  double game_s = 0;
  std::string_view play_mode;
  std::string_view left_team, right_team;  // MuJoCo server

  std::array<double, 3> gyro_dps{}, acceleration_mps2{};

  std::array<SparkJoint, 32> joint{};
  std::array<SparkForce, 4> force{};
  std::array<SparkSeen, 160> seen{};  // 8 landmarks, a ball, 21 players of 5 parts, lines
  std::array<SparkHeard, 8> heard{};
  std::array<SparkImage, 2> image{};
  std::array<SparkPlace, 4> place{};
  std::size_t places = 0;
  std::size_t joints = 0, forces = 0, sightings = 0, hears = 0, images = 0;
  bool has_see = false;       // the server sends it each third cycle
  std::uint32_t unknown = 0;  // expressions that are not among these: left out

  /// Null: there is none of this name.
  const SparkJoint* find_joint(std::string_view name) const noexcept;
};

/// RT: yes.   Errors: `out` then has what stood before the error.
SparkError parse_spark_percepts(std::string_view text, SparkPercepts& out) noexcept;

/// One expression of an agent's message.
struct SparkEffector {
  enum class Kind : std::uint8_t {
    scene,  // the body to be made: `name` is its file, `type` its number ("nao_hetero.rsg 3"), 0 where none is said
    init,   // `name` of the team, `number` of the player; 0: the server chooses; MuJoCo server: `model` of the body
    joint,  // `name` and value[0]: rad/s
    motor,  // MuJoCo server: `name` and motor: position (degrees), speed (degrees/s), both gains, torque (N m)
    beam,   // value: x, y (m), degrees
    say,    // `name`: the text
    pass,
    sync,
    other  // not among these: `name` is its first word
  };
  Kind kind = Kind::other;
  std::string_view name;
  std::uint32_t number = 0, type = 0;
  std::array<double, 3> value{};
  std::string_view model{};
  std::array<double, 5> motor{};
};

/// Reads an agent's message one expression after another.
///   for (SparkEffectors in(text); in.next(effector);) ...
/// RT: yes.
class SparkEffectors {
 public:
  explicit SparkEffectors(std::string_view text) noexcept : rest_(text) {}
  /// False: the end, or an error.
  bool next(SparkEffector& out) noexcept;
  SparkError error() const noexcept { return error_; }

 private:
  std::string_view rest_;
  SparkError error_ = SparkError::none;
};

/// One order of a monitor (port 3200), which leads a game as a trainer.
struct SparkOrder {
  enum class Kind : std::uint8_t {
    kick_off,   // `name`: Left or Right
    play_mode,  // `name`: "PlayOn"
    ball,       // to `position`, with `velocity` (m, m/s; the field's frame), each where it is said
    player,     // `number` of the side `name` (Left, Right) to `position`, and to `degrees` where it says so ("move")
    time,       // `value`[0]: s
    score,      // `value`: of the left and the right team
    drop_ball,
    kill_player,    // `number` of the side `name`
    kill_server,    // "killsim"
    request_state,  // "reqfullstate"
    other           // not among these: `name` is its first word
  };
  Kind kind = Kind::other;
  std::string_view name;
  std::uint32_t number = 0;
  std::array<double, 3> position{}, velocity{};
  std::array<double, 2> value{};
  double degrees = 0;  // of SimSpark's y axis, which is ahead: 0 looks at the left side line
  bool has_position = false, has_velocity = false, has_degrees = false;
};

/// Reads a monitor's message one order after another. RT: yes.
class SparkOrders {
 public:
  explicit SparkOrders(std::string_view text) noexcept : rest_(text) {}
  /// False: the end, or an error.
  bool next(SparkOrder& out) noexcept;
  SparkError error() const noexcept { return error_; }

 private:
  std::string_view rest_;
  SparkError error_ = SparkError::none;
};
/// "parenthesis", "too_many".
std::string_view to_string(SparkError error) noexcept;

/// Writes one message behind its length. Numbers are written without a locale; what is not finite is written as 0.
/// RT: yes.
class SparkWriter {
 public:
  explicit SparkWriter(std::span<char> into) noexcept : into_(into) {}

  // What an agent says.
  SparkWriter& scene(std::string_view file) noexcept { return open("scene").word(file).close(); }
  SparkWriter& init(std::uint32_t number, std::string_view team) noexcept;
  SparkWriter& effector(std::string_view joint, double radps) noexcept;
  /// MuJoCo server.
  SparkWriter& init(std::string_view model, std::string_view team, std::uint32_t number) noexcept;
  SparkWriter& motor(std::string_view name, const std::array<double, 5>& values) noexcept;
  SparkWriter& beam(double x_m, double y_m, double degrees) noexcept;
  SparkWriter& say(std::string_view text) noexcept { return open("say").word(text).close(); }
  SparkWriter& sync() noexcept { return open("syn").close(); }

  /// What the server says: all that `percepts` has.
  SparkWriter& percepts(const SparkPercepts& percepts) noexcept;

  SparkWriter& open(std::string_view name) noexcept;
  SparkWriter& word(std::string_view word) noexcept;
  SparkWriter& number(double value, int decimals = 2) noexcept;
  SparkWriter& close() noexcept;

  /// The whole message with its length; empty: it did not fit.
  std::span<const char> frame() noexcept;

 private:
  SparkWriter& put(std::string_view text) noexcept;
  SparkWriter& polar(const SparkPolar& polar) noexcept;

  std::span<char> into_;
  std::size_t used_ = 4;
  bool fits_ = true;
};

}  // namespace sinew::wire
