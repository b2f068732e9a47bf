#include "sim_hil/usarsim/session.hpp"

#include <algorithm>

#include "sim_hil/usarsim/values.hpp"

namespace sinew::usarsim {

using math::Vec3;
using plant::kMostRobots;
using plant::Locomotion;
using wire::UsarLine;
using wire::UsarPart;
using wire::UsarWriter;

namespace {

/// Names as clients have them, in the order of plant::kThingKinds. Source: robocup-usarsim, USARPhysObj.
constexpr const char* kThingClasses[] = {"WCCrate", "WCCrateRed", "WCCrateGreen", "WCCrateBlue"};
static_assert(std::size(kThingClasses) == std::size(plant::kThingKinds));
constexpr const char* kTargetName = "Target";
constexpr double kLeastFov_rad = 0.3491, kMostFov_rad = 2.0944;  // DefaultUSAR.ini, [USARSensor.USARCamera]
constexpr std::size_t kLongestName = 40;
constexpr double kFarthest_m = 1e4;  // of a position that a client may name

std::array<double, 3> items(const Vec3& v) { return {v.x, v.y, v.z}; }

bool is_near(const Vec3& v) {
  return math::fabs(v.x) < kFarthest_m && math::fabs(v.y) < kFarthest_m && math::fabs(v.z) < kFarthest_m;
}

std::string short_name(std::string name, std::string otherwise) {
  name = clean(name.substr(0, kLongestName));
  return name.empty() ? std::move(otherwise) : name;
}

std::string_view class_part(std::string_view name) {
  const auto dot = name.rfind('.');
  return dot == std::string_view::npos ? name : name.substr(dot + 1);
}

}  // namespace

Session::Session(Game& game, std::string address, std::uint64_t number)
    : game_(game), address_(std::move(address)), number_(number) {
  ++game_.counts().connections;
  std::array<char, 256> buffer;
  UsarWriter out(buffer);
  out.type("NFO").text("Gametype", "BotDeathMatch").text("Level", game_.place().map().name).integer("TimeLimit", 0);
  say(out.line());
}

Session::~Session() {
  if (lines_.reset()) ++game_.counts().dropped;  // half a line: it is not obeyed
  if (!robot_) return;
  game_.add_visit(robot_->visit());
  game_.remove(robot_->bot().slot);
  game_.place().leave(robot_->bot().slot);
}

void Session::say(std::string_view line) {
  if (sent_ == out_.size()) out_.clear(), sent_ = 0;
  if (line.empty() || out_.size() - sent_ + line.size() > kMostWaiting) {
    ++game_.counts().unsent;
    return;
  }
  out_ += line;
  ++game_.counts().sent;
}

void Session::drop_sent(std::size_t bytes) {
  sent_ = std::min(sent_ + bytes, out_.size());
  if (sent_ < out_.size() && sent_ < kMostWaiting) return;
  out_.erase(0, sent_);
  sent_ = 0;
}

void Session::receive(std::span<const std::byte> bytes) {
  for (const std::byte b : bytes) {
    if (!lines_.push(static_cast<char>(b))) continue;
    ++game_.counts().lines;
    switch (parse_usarsim(lines_.line(), line_)) {
      case wire::UsarError::none:
        obey(line_);
        break;
      case wire::UsarError::empty:
        break;
      case wire::UsarError::text:
      case wire::UsarError::brace:
      case wire::UsarError::too_many:
        ++game_.counts().torn;
        break;
    }
  }
  game_.counts().dropped += lines_.dropped() - dropped_before_;
  dropped_before_ = lines_.dropped();
}

void Session::tick() {
  if (robot_) robot_->tell([&](std::string_view line) { say(line); });
}

void Session::refuse(const std::string& what, const std::string& why) {
  std::array<char, 1024> buffer;
  UsarWriter out(buffer);
  out.type("NFO").text("Error", what).text("Reason", clean(why));
  say(out.line());
}

// ---- commands

void Session::obey(const UsarLine& line) {
  using Command = void (Session::*)(const UsarLine&);
  struct Known {
    const char* type;
    Command command;
    bool needs_robot;
  };
  static constexpr Known kKnown[] = {
      {"DRIVE", &Session::drive, true},        {"MULTIDRIVE", &Session::drive_joints, true},
      {"CAMERA", &Session::turn_camera, true}, {"MISPKG", &Session::move_links, true},
      {"ACT", &Session::move_links, true},     {"SET", &Session::set, true},
      {"CONTROL", &Session::control, false},   {"INIT", &Session::init, false},
  };
  for (const Known& k : kKnown) {
    if (!same_word(line.type, k.type)) continue;
    if (k.needs_robot && !robot_) return unusable();
    return (this->*k.command)(line);
  }
  if (same_word(line.type, "GETSTARTPOSES")) return tell_start_poses();
  const bool configuration = same_word(line.type, "GETCONF");
  if (configuration || same_word(line.type, "GETGEO")) {
    if (!robot_) return unusable();
    return answer(line, configuration);
  }
  Counts& counts = game_.counts();
  ++counts.unknown;
  std::string type(line.type.substr(0, kLongestName));
  for (char& c : type)  // it is a key of the report
    if (!((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_')) c = '?';
  if (counts.of_type.size() < Counts::kMostTypes || counts.of_type.contains(type)) ++counts.of_type[type];
}

void Session::tell_start_poses() {
  const plant::Place& place = game_.place();
  std::array<char, wire::kUsarLine> buffer;
  UsarWriter out(buffer);
  out.type("NFO").integer("StartPoses", static_cast<std::int64_t>(place.map().starts.size())).open();
  const auto three = [](const Vec3& v) {
    std::string all;
    for (const double x : items(v)) {
      std::array<char, 32> text{};
      all += (all.empty() ? "" : ",") + std::string(text.data(), wire::write_fixed(x, 4, text));
    }
    return all;
  };
  for (const plant::StartPose& pose : place.map().starts)
    out.word(pose.name)
        .word(three(game_.options().frame.turned(pose.ground_m)))
        .word(three(Frame::angles(math::YawPitchRoll{pose.yaw_rad, 0, 0})));
  out.close();
  say(out.line());
}

void Session::init(const UsarLine& line) {
  const std::string wanted = text_of(line, "ClassName");
  if (robot_) {
    ++game_.counts().refused;
    return refuse("INIT",
                  "this connection has its robot, " + robot_->bot().name + "; another needs another connection");
  }
  if (same_word(class_part(wanted), "WorldController")) return;  // CONTROL needs no robot here
  const RobotClass* kind = find_class(wanted);
  if (!kind) {
    ++game_.counts().refused;
    return refuse("INIT",
                  (wanted.empty() ? "no ClassName" : "no class '" + wanted + "'") + "; there are " + class_names());
  }
  const auto slot = enter(*kind, line);
  if (!slot) {
    ++game_.counts().refused;
    return refuse("INIT", slot.error().where);
  }
  const Game::Bot bot{short_name(text_of(line, "Name"), "Robot" + std::to_string(number_)), kind, *slot};
  game_.add(bot);
  ++game_.counts().robots;
  robot_ = std::make_unique<Robot>(game_, bot, number_);
}

/// Where its client says: a start pose or a location. A start pose that is taken gives way to the next free one.
hal::Result<std::size_t> Session::enter(const RobotClass& kind, const UsarLine& line) {
  plant::Place& place = game_.place();
  const plant::Vehicle::Options options{number_, place.options().sensor_errors, 1};
  if (const auto location = vector_of(line, "Location"); location && !value_of(line, "Start")) {
    if (!is_near(*location)) return hal::Error{hal::Errc::bad_argument, "Location: farther than 10 km"};
    Vec3 p = game_.options().frame.turned(*location);
    p.z = std::max(p.z, kind.kind->rest_m);
    const Vec3 rotation = vector_of(line, "Rotation").value_or(Vec3{});
    return place.enter(*kind.kind, {p, Frame::angles(rotation).yaw}, options);
  }
  const std::vector<plant::StartPose>& starts = place.map().starts;
  const std::string wanted = text_of(line, "Start");
  const auto first = std::ranges::find_if(starts, [&](const auto& s) { return same_word(s.name, wanted); });
  const auto begin = first == starts.end() ? std::size_t{0} : static_cast<std::size_t>(first - starts.begin());
  hal::Result<std::size_t> slot = hal::Error{hal::Errc::bad_argument, "the place has no start poses"};
  for (std::size_t i = 0; i < starts.size() && !slot; ++i)
    slot = place.enter(*kind.kind, plant::Place::standing(starts[(begin + i) % starts.size()], *kind.kind), options);
  return slot;
}

// ---- the camera

/// CAMERA {Rotation roll,pitch,yaw} {Order n} {Zoom fov}: the pitch tilts, the yaw pans; nothing rolls.
void Session::turn_camera(const UsarLine& line) {
  const auto rotation = vector_of(line, "Rotation");
  const auto fov = number_of(line, "Zoom");
  const auto by_rate = is_rate(number_of(line, "Order"));
  if ((!rotation && !fov) || !by_rate) return unusable();
  if (fov) zoom(*fov);
  if (!rotation) return;
  const math::YawPitchRoll a = Frame::angles(*rotation);
  vehicle().aim(plant::kTilt, {*by_rate, a.pitch});
  vehicle().aim(plant::kPan, {*by_rate, a.yaw});
}

void Session::zoom(double fov_rad) {
  if (fov_rad == 0) return vehicle().zoom(0);
  const math::SinCos half = math::sincos(std::clamp(fov_rad, kLeastFov_rad, kMostFov_rad) / 2);
  vehicle().zoom(0.5 * half.cos / half.sin * game_.options().tile_width / game_.options().tile_height);
}

/// MISPKG {Name n} {Link i} {Value v} {Order o} ..., ACT {Name n} {Link i} {Value v} ...: in the order of the line.
void Session::move_links(const UsarLine& line) {
  const bool act = same_word(line.type, "ACT");
  if (const auto name = value_of(line, "Name"); name && !same_word(*name, kPackageName)) return unusable();
  bool any = false;
  const auto parts = line.parts();
  for (std::size_t i = 0; i + 1 < parts.size(); ++i) {
    if (!same_word(parts[i].key, "Link") || !same_word(parts[i + 1].key, "Value")) continue;
    const auto link = number_in(parts[i].value), value = number_in(parts[i + 1].value);
    const bool ordered = i + 2 < parts.size() && same_word(parts[i + 2].key, "Order");
    const auto by_rate = is_rate(ordered ? number_in(parts[i + 2].value) : std::optional<double>(0));
    if (!link || !value || !by_rate || *link < 1 || *link > plant::kCameraJoints) continue;
    vehicle().aim(static_cast<plant::CameraJoint>(static_cast<std::size_t>(*link) - 1), {*by_rate, -*value});
    any = true;
  }
  if (!any) return unusable();
  if (act) robot_->answer_acts();
}

// ---- SET

void Session::set(const UsarLine& line) {
  const std::string type = text_of(line, "Type");
  if (same_word(type, "Camera")) return set_camera(line);
  if (same_word(type, "Viewports")) return set_viewports(line);
  unusable();
}

/// {Opcode Zoom} {Params fov} (UDK); {Robot r} {Name Camera} {Client address} (UT2004): whose picture that client sees.
void Session::set_camera(const UsarLine& line) {
  const std::string opcode = text_of(line, "Opcode");
  if (same_word(opcode, "Zoom") || same_word(opcode, "FOV")) {
    const auto fov = number_of(line, "Params");
    return fov ? zoom(*fov) : unusable();
  }
  const std::string name = text_of(line, "Robot");
  const Game::Bot* bot = name.empty() ? &robot_->bot() : game_.find(name);
  if (!bot) return unusable();
  game_.show(short_name(text_of(line, "Client"), address_), {bot->slot});
}

/// {Config SingleView|QuadView} {Viewport1 Camera} {Viewport2 R2} {Viewport3 Disabled} ... [{Client address}]: a part
/// shows the own camera, or a robot's by its name.
void Session::set_viewports(const UsarLine& line) {
  const bool quad = same_word(text_of(line, "Config"), "QuadView");
  std::vector<std::size_t> slots;
  for (std::size_t i = 1; i <= (quad ? 4u : 1u); ++i) {
    const std::string shown = text_of(line, "Viewport" + std::to_string(i));
    const Game::Bot* bot = game_.find(shown);
    if (!bot && (same_word(shown, kCameraName) || (shown.empty() && i == 1))) bot = &robot_->bot();
    slots.push_back(bot ? bot->slot : kMostRobots);
  }
  if (std::ranges::all_of(slots, [](std::size_t s) { return s == kMostRobots; })) return unusable();
  game_.show(short_name(text_of(line, "Client"), address_), slots);
}

// ---- GETCONF, GETGEO

void Session::answer(const UsarLine& line, bool configuration) {
  const std::string type = text_of(line, "Type"), name = text_of(line, "Name");
  std::array<char, wire::kUsarLine> buffer;
  UsarWriter out(buffer);
  if (!(configuration ? robot_->configuration(type, name, out) : robot_->geometry(type, name, out))) unusable();
  say(out.line());
}

// ---- CONTROL

void Session::control(const UsarLine& line) {
  const std::string type = text_of(line, "Type");
  if (same_word(type, "Create")) return create(line);
  if (same_word(type, "AbsMove")) return move(line, false);
  if (same_word(type, "RelMove")) return move(line, true);
  if (same_word(type, "KillAll")) return kill_all(line);
  if (same_word(type, "GetSTA")) return tell_things(line);
  if (!same_word(type, "Kill") || !game_.place().remove(text_of(line, "Name"))) unusable();
}

void Session::create(const UsarLine& line) {
  const std::string wanted(class_part(value_of(line, "ClassName").value_or("")));
  const auto kind = std::ranges::find_if(kThingClasses, [&](const char* c) { return same_word(c, wanted); });
  if (kind == std::end(kThingClasses)) {
    std::string all;
    for (const char* c : kThingClasses) all += (all.empty() ? "" : ", ") + std::string(c);
    unusable();
    return refuse("CONTROL", "no class '" + wanted + "'; there are " + all);
  }
  Vec3 p = game_.options().frame.turned(vector_of(line, "Location").value_or(Vec3{}));
  if (const plant::StartPose* start = game_.place().find_start(text_of(line, "Start"))) p = start->ground_m;
  p.z = std::max(p.z, plant::kThing_m / 2);
  if (!is_near(p)) return unusable();
  const auto q = math::Quat::from_yaw_pitch_roll(Frame::angles(vector_of(line, "Rotation").value_or(Vec3{})));
  const hal::Status made =
      game_.place().create(static_cast<std::size_t>(kind - std::begin(kThingClasses)),
                           short_name(text_of(line, "Name"), wanted), {p.to<msg::Vec3>(), q.to<msg::Quat>()});
  if (made) return;
  unusable();
  refuse("CONTROL", made.error().where);
}

void Session::move(const UsarLine& line, bool relative) {
  plant::Place& place = game_.place();
  const std::string name = text_of(line, "Name");
  const auto location = vector_of(line, "Location");
  if (location && !is_near(*location)) return unusable();
  const Vec3 by = game_.options().frame.turned(location.value_or(Vec3{}));
  const math::YawPitchRoll turn = Frame::angles(vector_of(line, "Rotation").value_or(Vec3{}));
  if (plant::Thing* thing = place.find_thing(name)) {
    const Vec3 p = relative ? Vec3(thing->pose.p_world_m) + by : by;
    const auto q = math::Quat::from_yaw_pitch_roll(turn);
    thing->pose = {p.to<msg::Vec3>(),
                   (relative ? math::Quat(thing->pose.q_world) * q : q).normalized().to<msg::Quat>()};
    return;
  }
  if (const Game::Bot* bot = game_.find(name)) {
    plant::Vehicle& v = *place.vehicle(bot->slot);
    const plant::BodyState& body = v.body();
    v.put({relative ? body.p_world_m + by : by, relative ? body.angles_rad.yaw + turn.yaw : turn.yaw});
    return;
  }
  if (!same_word(name, kTargetName) || !place.has_target()) return unusable();
  place.put_target(relative ? place.target_m() + by : by);
}

/// All, or those within the box from MinPos to MaxPos.
void Session::kill_all(const UsarLine& line) {
  const auto from = vector_of(line, "MinPos"), to = vector_of(line, "MaxPos");
  std::vector<std::string> names;
  for (const plant::Thing& thing : game_.place().things()) {
    const Vec3 p = game_.options().frame.turned(Vec3(thing.pose.p_world_m));
    const bool inside =
        !from || !to || (p.x > from->x && p.y > from->y && p.z > from->z && p.x < to->x && p.y < to->y && p.z < to->z);
    if (inside) names.push_back(thing.name);
  }
  for (const std::string& name : names) game_.place().remove(name);
}

void Session::tell_things(const UsarLine& line) {
  const std::string name = text_of(line, "Name"), wanted(class_part(text_of(line, "ClassName")));
  std::array<char, wire::kUsarLine> buffer;
  UsarWriter out(buffer);
  out.type("STA");
  for (const plant::Thing& thing : game_.place().things()) {
    if (!name.empty() && !same_word(name, thing.name)) continue;
    if (!wanted.empty() && !same_word(wanted, kThingClasses[thing.kind])) continue;
    const math::YawPitchRoll a = math::Quat(thing.pose.q_world).yaw_pitch_roll();
    out.text("Name", thing.name)
        .vector("Size", items({plant::kThing_m, plant::kThing_m, plant::kThing_m}))
        .vector("Location", items(game_.options().frame.turned(Vec3(thing.pose.p_world_m))))
        .vector("Rotation", items(Frame::angles(a)));
  }
  say(out.line());
}

}  // namespace sinew::usarsim
