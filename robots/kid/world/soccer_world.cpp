#include "robots/kid/world/soccer_world.hpp"

#include <algorithm>
#include <bit>

#include "robots/kid/world/ball_score.hpp"
#include "robots/kid/world/game.hpp"
#include "robots/kid/world/walk_score.hpp"
#include "sim_hil/pitch/painter.hpp"
#include "sim_hil/worlds/json_object.hpp"
#include "sim_hil/worlds/sensors.hpp"

namespace sinew::plant {
namespace {

constexpr std::int64_t kStepsOfPitch = kPitchStepNs / kStepNs;
constexpr std::int64_t kFirstPushNs = 3'000'000'000, kPushEveryNs = 10'000'000'000, kPushNs = 100'000'000;
constexpr double kBattery_v = 12, kAmpere_per_nm = 0.56;  // XM430-W350: 2.3 A at its stall torque of 4.1 N m
constexpr double kBattery_ohm = 0.08, kIdle_a = 1.2, kBattery_as = 1.8 * 3600;

double heading_of(const kinematics::Pose& pose) {
  const math::Vec3 ahead = pose.q.rotate({1, 0, 0});
  return math::atan2(ahead.y, ahead.x);
}

/// Also where both are NaN.
bool same_bits(const std::array<double, kMostJoints>& a, const std::array<double, kMostJoints>& b) {
  return std::ranges::equal(
      a, b, [](double x, double y) { return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y); });
}

}  // namespace

class SoccerRobotSide final : public PitchRobot, public PlantJoints {
 public:
  SoccerRobotSide(const SoccerRobot& given, Pitch& pitch, const Game* game, std::size_t number, bool has_board,
                  std::uint64_t seed)
      : pitch_(pitch),
        game_(game),
        number_(number),
        limbs_(kinematics::Limbs::of(pitch.body(number))),
        push_ns_(given.push_ns),
        focal_per_height_(given.body.focal_per_height),
        has_board_(has_board),
        battery_({}, seed) {
    for (const kinematics::Place& place : pitch.body(number).places)
      if (place.name.starts_with("camera")) cameras_.push_back(place);
    target_.fill(math::kNan);
    commanded_.fill(0);  // so that the first command goes out
    taken_.resize(pitch.body(number).joints());
  }

  void act(RobotCommand command, std::int64_t now_ns) override {
    std::size_t channel = 0;
    for (std::size_t limb = 0; limb < kinematics::kLimbs; ++limb)
      for (std::size_t i = 0; i < kKidLimbJoints[limb]; ++i, ++channel)
        if (i < limbs_.joints[limb].size())
          target_[limbs_.joints[limb][i]] = channel < command.size() ? command[channel] : math::kNan;
    if (!same_bits(target_, commanded_) || released_) {
      commanded_ = target_;
      released_ = false;
      pitch_.command(number_, std::span(target_).first(count()));
      for (std::size_t joint = 0; joint < count(); ++joint)
        if (taken_[joint]) pitch_.command(number_, joint, *taken_[joint]);
    }
    const bool pushes = push_ns_.x != 0 || push_ns_.y != 0;
    if (pushes && now_ns >= kFirstPushNs && (now_ns - kFirstPushNs) % kPushEveryNs == 0)
      pitch_.push(number_, math::Quat::exp({0, 0, heading_of(pitch_.truth(number_).torso)}).rotate(push_ns_), kPushNs);
  }

  void sample(std::int64_t steps) override {
    const BodySensors& s = pitch_.sensors(number_);
    const auto every = [&](int n) { return steps % n == 0; };
    due_.imu = every(kKidImuSteps), due_.soles = due_.joints = every(kKidJointSteps);
    due_.battery = every(kKidBatterySteps), due_.truth = every(kTruthSteps);
    due_.referee = game_ && every(kKidRefereeSteps);
    if (due_.referee) {
      due_.referee_sample = game_->said_to(number_);
      due_.referee_sample.stamp = {steps * kStepNs};
    }
    due_.cameras = every(kKidCameraSteps) ? (1u << std::min<std::size_t>(cameras_.size(), 2)) - 1 : 0;
    due_.imu_sample = {{s.imu_stamp_ns}, s.gyro_radps.to<msg::Vec3>(), s.accel_mps2.to<msg::Vec3>()};
    if (due_.soles) {
      due_.soles_sample.stamp = {s.cells_stamp_ns};
      for (std::size_t i = 0; i < msg::kSoleCells; ++i) due_.soles_sample.force_n[i] = s.cell_n[i / 4][i % 4];
    }
    if (due_.joints)
      for (std::size_t limb = 0; limb < kinematics::kLimbs; ++limb) sample_limb(s, limb);
    const BodyTruth& truth = pitch_.truth(number_);
    const double now_s = 1e-9 * static_cast<double>(steps * kStepNs);
    score_.look(truth, driven(), now_s);
    const kinematics::Pose camera = cameras_.empty() ? truth.torso : truth.link[cameras_[0].link] * cameras_[0].pose;
    const bool touched = pitch_.ball().touched_by == static_cast<int>(number_);
    ball_score_.look(pitch_.ball(), touched, camera, driven() && !truth.body_down, now_s);
    current_a_ = kIdle_a;
    for (std::size_t i = 0; i < s.joints; ++i) current_a_ += kAmpere_per_nm * math::fabs(s.joint[i].effort_nm);
    used_as_ += current_a_ * 1e-9 * static_cast<double>(kPitchStepNs);
    voltage_v_ = kBattery_v - kBattery_ohm * current_a_;
    if (due_.battery) {
      due_.battery_sample = battery_.measure(voltage_v_, current_a_, std::max(0.0, 1 - used_as_ / kBattery_as));
      due_.battery_sample.stamp = {steps * kStepNs};
    }
  }
  /// The referee has put it somewhere else.
  void moved() { score_.moved(); }
  void nothing_due() override {
    due_.imu = due_.soles = due_.joints = due_.battery = due_.referee = due_.truth = false;
    due_.cameras = 0;
  }

  // ---- SimRobot
  const Due& due() const override { return due_; }
  WorldTruth ground_truth() const override {
    const BodyTruth& truth = pitch_.truth(number_);
    WorldTruth t;
    t.p_world_m = truth.torso.p_m.to<msg::Vec3>();
    t.v_world_mps = truth.v_world_mps.to<msg::Vec3>();
    t.q_world_base = truth.torso.q.to<msg::Quat>();
    t.gyro_radps = truth.gyro_radps.to<msg::Vec3>();
    t.target_world_m = pitch_.ball().p_m.to<msg::Vec3>();
    t.battery_v = voltage_v_;
    t.contact = truth.body_down;
    t.landed = truth.foot_n[0] > 0 && truth.foot_n[1] > 0;
    return t;
  }
  Scene scene(std::size_t camera) const override {
    Scene scene = pitch_scene(pitch_, number_, camera);
    scene.camera.focal_per_height = focal_per_height_;
    return scene;
  }
  bool still() const override {
    const BodyTruth& truth = pitch_.truth(number_);
    return !driven() && math::norm(truth.v_world_mps) < 0.02 && math::norm(truth.gyro_radps) < 0.1;
  }
  std::uint32_t news() const override {
    const auto decisions = static_cast<std::uint32_t>(game_ ? game_->decisions() : 0);
    return score_.falls() + (score_.has_begun() ? 1 : 0) + decisions;
  }
  void add_to(JsonObject& j) const override {
    const BodyTruth& truth = pitch_.truth(number_);
    score_.add_to(j);
    j.number("x_m", truth.torso.p_m.x);
    j.number("y_m", truth.torso.p_m.y);
    j.number("heading_deg", heading_of(truth.torso) * 180 / math::kPi);
    j.boolean("fallen", truth.fallen);
    j.boolean("on_its_feet", !truth.body_down);
    j.number("ball_x_m", pitch_.ball().p_m.x);
    j.number("ball_y_m", pitch_.ball().p_m.y);
    ball_score_.add_to(j);
    // What a calibration has to find.
    const kinematics::Body& body = pitch_.body(number_);
    for (std::size_t joint = 0; joint < count(); ++joint)
      if (const double zero = pitch_.joint_zero_rad(number_, joint); zero != 0)
        j.number(("zero_deg_" + body.links[joint + 1].name).c_str(), zero * 180 / math::kPi);
    j.number("command_delay_ms", 1e-6 * static_cast<double>(pitch_.command_delay_ns(number_)));
    j.integer("physics_warnings", pitch_.trouble());
    j.boolean("at_rest", still());
    j.boolean("motors_stopped", !driven());
    if (game_) j.integer("penalties", game_->penalties(number_));
    if (game_) game_->add_to(j);
  }
  Verdict verdict() const override {
    Verdict verdict = score_.verdict(pitch_.truth(number_), ball_score_.touched());
    if (ball_score_.touched())
      verdict.measures.push_back({"ball_left_mps", "ball left with", "m/s", ball_score_.left_mps()});
    if (has_board_) {  // it need not have walked
      const BodyTruth& truth = pitch_.truth(number_);
      verdict.good = verdict.begun && score_.falls() == 0 && !truth.fallen && !truth.body_down;
      verdict.outcome = verdict.good ? "stood before the board" : "did not stay on its feet";
    }
    if (!game_) return verdict;
    const msg::RefereeState said = game_->said_to(number_);
    verdict.measures.push_back({"own_goals", "goals of its team", "", static_cast<double>(said.own_goals)});
    verdict.measures.push_back({"other_goals", "goals against it", "", static_cast<double>(said.other_goals)});
    verdict.measures.push_back({"penalties", "penalties", "", static_cast<double>(game_->penalties(number_))});
    return verdict;
  }
  std::string outcome() const override { return score_.text(pitch_.truth(number_), ball_score_.touched()); }
  PlantJoints* joints() override { return this; }

  // ---- PlantJoints
  std::size_t count() const override { return pitch_.body(number_).joints(); }
  JointMotion motion(std::size_t joint) const override {
    const BodyTruth& truth = pitch_.truth(number_);
    const JointReading& reading = pitch_.sensors(number_).joint[joint];
    JointMotion m{truth.joint_rad[joint] + pitch_.joint_zero_rad(number_, joint),
                  truth.joint_radps[joint],
                  reading.effort_nm,
                  reading.temperature_c,
                  {}};
    if (taken_[joint]) {
      m.drive = *taken_[joint];
    } else if (math::is_finite(commanded_[joint])) {
      m.drive.mode = DriveMode::position;
      m.drive.position_rad = commanded_[joint];
    }
    return m;
  }
  JointLimits limits(std::size_t joint) const override {
    const kinematics::Body& body = pitch_.body(number_);
    const kinematics::Link& link = body.links[joint + 1];
    const kinematics::ServoType& servo = body.servos[link.servo];
    return {link.least_rad, link.most_rad, servo.no_load_radps, servo.stall_nm};
  }
  void drive(std::size_t joint, const JointDrive& drive) override {
    taken_[joint] = drive;
    pitch_.command(number_, joint, drive);
  }
  void release(std::size_t joint) override {
    taken_[joint].reset();
    released_ = true;
  }

 private:
  bool driven() const {
    for (std::size_t i = 0; i < count(); ++i)
      if (math::is_finite(commanded_[i]) || (taken_[i] && taken_[i]->mode != DriveMode::off)) return true;
    return false;
  }
  void sample_limb(const BodySensors& sensors, std::size_t limb) {
    msg::JointState& s = due_.joints_samples[limb];
    s = {};
    s.stamp = {sensors.joints_stamp_ns};
    s.count = kKidLimbJoints[limb];
    for (std::size_t i = 0; i < s.count; ++i) {
      if (i >= limbs_.joints[limb].size()) {
        s.position_rad[i] = s.velocity_radps[i] = s.effort_nm[i] = s.temperature_c[i] = s.voltage_v[i] = math::kNan;
        continue;
      }
      const std::size_t joint = limbs_.joints[limb][i];
      const JointReading& reading = sensors.joint[joint];
      s.measured[i] = s.stamp;
      s.position_rad[i] = reading.position_rad;
      s.velocity_radps[i] = reading.velocity_radps;
      s.effort_nm[i] = reading.effort_nm;
      s.temperature_c[i] = reading.temperature_c;
      s.voltage_v[i] = voltage_v_;
      const bool on = math::is_finite(commanded_[joint]) || (taken_[joint] && taken_[joint]->mode != DriveMode::off);
      s.mode[i] = on ? msg::JointMode::enabled : msg::JointMode::disabled;
      s.ready |= (on ? 1u : 0u) << i;
    }
  }

  Pitch& pitch_;
  const Game* const game_;  // null: nobody leads one
  const std::size_t number_;
  const kinematics::Limbs limbs_;
  const math::Vec3 push_ns_;
  const double focal_per_height_;
  const bool has_board_;
  std::vector<kinematics::Place> cameras_;
  std::array<double, kMostJoints> target_{}, commanded_{};
  std::vector<std::optional<JointDrive>> taken_;  // by drives at the wire
  bool released_ = false;
  BatteryModel battery_;
  double current_a_ = 0, used_as_ = 0, voltage_v_ = kBattery_v;
  WalkScore score_;
  BallScore ball_score_;
  Due due_;
};

std::unique_ptr<PitchRobot> kid_on_pitch(const SoccerRobot& robot, Pitch& pitch, std::size_t number,
                                         std::uint64_t seed) {
  return std::make_unique<SoccerRobotSide>(robot, pitch, nullptr, number, false, seed);
}

struct SoccerWorld::Impl {
  std::unique_ptr<Pitch> pitch;
  std::optional<Game> game;
  std::vector<std::unique_ptr<SoccerRobotSide>> robots;
  std::int64_t steps = 0;
  double roll_mps = 0, roll_rad = 0;  // of the ball, once, when it is set rolling
  std::int64_t roll_at_ns = 0;

  void roll_ball() {
    if (roll_mps == 0 || pitch->now_ns() < roll_at_ns) return;
    pitch->place_ball(pitch->ball().p_m, {roll_mps * math::cos(roll_rad), roll_mps * math::sin(roll_rad), 0});
    roll_mps = 0;
  }
};

SoccerWorld::SoccerWorld(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SoccerWorld::~SoccerWorld() = default;

WorldInfo SoccerWorld::info() {
  WorldInfo info{"soccer", kKidDevices, soccer_options(), kMostRobots};
  info.has_bodies = true;
  return info;
}

PitchOptions pitch_options_of(const WorldInfo& info, const WorldValues& values) {
  PitchOptions options;
  options.kinematic = info.value(values, "kinematic").value() == 1;
  options.ground = GroundErrors::from(values);
  options.ball_at.x_m = info.value(values, "ball_x_m").value();
  options.ball_at.y_m = info.value(values, "ball_y_m").value();
  const auto value = [&](const char* key) { return info.value(values, key).value(); };
  options.board = {value("board_square_mm") / 1000, value("board_x_m"), value("board_y_m"),
                   value("board_heading_deg") * math::kPi / 180, value("board_lean_deg") * math::kPi / 180};
  options.focal_per_height = value("camera_focal");
  options.lens.k1 = value("camera_k1"), options.lens.k2 = value("camera_k2");
  return options;
}

SoccerRobot soccer_robot_of(const WorldChoice& choice, std::size_t number) {
  constexpr double kBeside_m[] = {0, 1.2, -1.2, 2.4};
  const WorldInfo& info = choice.type->info;
  const WorldValues values = choice.values_of(number);
  const auto value = [&](const char* key) { return info.value(values, key).value_or(0); };
  SoccerRobot robot;
  if (const kinematics::Body* body = choice.body_of(number)) robot.body.body = *body;
  robot.body.gain_per_rad = value("servo_gain_per_rad");
  robot.body.errors = BodyErrors::from(values);
  robot.body.focal_per_height = info.value(values, "camera_focal").value_or(kFocalPerHeight);
  robot.body.team = static_cast<std::uint8_t>(value("team"));
  PitchPlace& start = robot.body.start;
  start.x_m = info.value(values, "start_x_m").value_or(number < 4 ? -1 : 1);
  start.y_m = info.value(values, "start_y_m").value_or(kBeside_m[number % 4]);
  start.heading_rad = value("start_heading_deg") * math::kPi / 180;
  start.lie = static_cast<PitchPlace::Lie>(static_cast<int>(value("start_lie")));
  const double from = value("push_from_deg") * math::kPi / 180;
  robot.push_ns = {value("push_ns") * math::cos(from), value("push_ns") * math::sin(from), 0};
  return robot;
}

std::vector<SoccerRobot> soccer_robots_of(const WorldChoice& choice) {
  std::vector<SoccerRobot> robots;
  for (std::size_t i = 0; i < choice.robot_count(); ++i) robots.push_back(soccer_robot_of(choice, i));
  return robots;
}

hal::Result<std::unique_ptr<SoccerWorld>> SoccerWorld::create(const WorldChoice& choice, std::uint64_t seed) {
  const std::vector<SoccerRobot> robots = soccer_robots_of(choice);
  std::vector<PitchBody> bodies;
  for (const SoccerRobot& robot : robots) bodies.push_back(robot.body);
  auto pitch = Pitch::create(pitch_options_of(choice.type->info, choice.values), bodies, seed);
  if (!pitch) return pitch.error();
  auto impl = std::make_unique<Impl>();
  impl->pitch = std::move(*pitch);
  const auto value = [&](const char* key) { return choice.type->info.value(choice.values, key).value(); };
  impl->roll_mps = value("ball_roll_mps");
  impl->roll_rad = value("ball_roll_deg") * math::kPi / 180;
  impl->roll_at_ns = static_cast<std::int64_t>(1e9 * value("ball_roll_at_s"));
  if (value("referee") == 1) {
    std::vector<std::uint8_t> teams;
    for (const PitchBody& body : bodies) teams.push_back(body.team);
    impl->game.emplace(Game::rules_of(choice.type->info, choice.values), teams);
  }
  for (std::size_t i = 0; i < robots.size(); ++i)
    impl->robots.push_back(std::make_unique<SoccerRobotSide>(robots[i], *impl->pitch,
                                                             impl->game ? &*impl->game : nullptr, i,
                                                             value("board_square_mm") > 0, seed_of_robot(seed, i)));
  return std::unique_ptr<SoccerWorld>(new SoccerWorld(std::move(impl)));
}

void SoccerWorld::advance(std::span<const RobotCommand> commands) {
  Impl& w = *impl_;
  const bool moves = w.steps % kStepsOfPitch == kStepsOfPitch - 1;
  ++w.steps;
  if (!moves) {
    for (const auto& robot : w.robots) robot->nothing_due();
    return;
  }
  for (std::size_t i = 0; i < w.robots.size(); ++i) w.robots[i]->act(commands[i], w.pitch->now_ns());
  w.roll_ball();
  w.pitch->step();
  if (w.game) {
    w.game->look(*w.pitch);
    for (const std::size_t robot : w.game->moved()) w.robots[robot]->moved();
  }
  for (const auto& robot : w.robots) robot->sample(w.steps);
}

msg::Time SoccerWorld::now() const { return {impl_->steps * kStepNs}; }
std::size_t SoccerWorld::robots() const { return impl_->robots.size(); }
SimRobot& SoccerWorld::robot(std::size_t number) { return *impl_->robots[number]; }
const Pitch& SoccerWorld::pitch() const { return *impl_->pitch; }

std::unique_ptr<Painter> soccer_painter(std::uint32_t width, std::uint32_t height, const WorldChoice& choice) {
  std::vector<PitchBody> bodies;
  for (const SoccerRobot& robot : soccer_robots_of(choice)) bodies.push_back(robot.body);
  return pitch_painter(width, height, pitch_options_of(choice.type->info, choice.values), bodies);
}

}  // namespace sinew::plant
