// For any bytes, of an agent, another one and a monitor that take turns: the arena stays finite, what goes out is
// frames that the codec reads, memory is bounded. The first byte of a piece says whose it is and whether a cycle
// follows, the second how long it is.
#include <cstdlib>
#include <memory>

#include "sim_hil/simspark/frame.hpp"
#include "sim_hil/simspark/session.hpp"

using namespace sinew;
using simspark::AgentSession;
using simspark::Connection;
using simspark::MonitorSession;

namespace {

/// Nao's joints and axes, with a sphere of 0.1 kg for each link.
kinematics::Body small_body() {
  kinematics::Body body;
  body.name = "fuzz";
  body.servos.push_back({"motor", 10, 12, 0.004});
  const auto add = [&](const std::string& name, std::size_t parent, math::Vec3 at_m, math::Vec3 axis) {
    kinematics::Link link;
    link.name = name;
    link.parent = parent;
    link.at_m = at_m;
    link.axis = axis;
    link.least_rad = -2, link.most_rad = 2;
    link.servo = parent == kinematics::kNone ? kinematics::kNone : 0;
    link.mass_kg = 0.1;
    link.inertia_kgm2 = {1e-4, 1e-4, 1e-4, 0, 0, 0};
    body.links.push_back(link);
    return body.links.size() - 1;
  };
  const std::size_t torso = add("torso", kinematics::kNone, {}, {0, 0, 1});
  std::array<std::size_t, kinematics::kLimbs> last{};
  last.fill(torso);
  for (const simspark::SparkJointKind& kind : simspark::spark_joints()) {
    std::size_t& end = last[static_cast<std::size_t>(kind.limb)];
    const bool left = kind.limb == kinematics::Limb::left_arm || kind.limb == kinematics::Limb::left_leg;
    const bool leg = kind.limb == kinematics::Limb::left_leg || kind.limb == kinematics::Limb::right_leg;
    const double side = kind.limb == kinematics::Limb::head ? 0 : (left ? 1 : -1);
    const math::Vec3 at =
        end == torso ? math::Vec3{0, 0.07 * side, leg ? -0.1 : 0.1} : math::Vec3{0, 0, leg ? -0.04 : 0};
    const char* const begin = side == 0 ? "" : (left ? "l_" : "r_");
    end = add(begin + std::string(kind.perceptor), end, at, normalized(simspark::from_spark(kind.axis)));
  }
  for (const auto limb : {kinematics::Limb::left_leg, kinematics::Limb::right_leg}) {
    const std::size_t foot = last[static_cast<std::size_t>(limb)];
    kinematics::Shape sole;
    sole.at_m = {0, 0, -0.02};
    sole.size_m = {0.1, 0.06, 0.02};
    body.links[foot].shapes.push_back(sole);
    body.places.push_back({limb == kinematics::Limb::left_leg ? "l_sole" : "r_sole", foot, {{0, 0, -0.03}, {}}});
  }
  return body;
}

void check_frames(Connection& session) {
  if (session.waiting().size() > Connection::kMostWaiting) std::abort();
  static std::vector<char> buffer(Connection::kMostFrame);
  static wire::SparkPercepts percepts;
  wire::SparkFrames frames(buffer);
  const std::string all(session.waiting());
  for (const char c : all)
    if (frames.push(c) && parse_spark_percepts(frames.text(), percepts) != wire::SparkError::none &&
        !frames.text().starts_with("(("))  // a monitor's begins so
      std::abort();
  session.drop_sent(all.size());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const kinematics::Body body = small_body();
  std::string why;
  const auto arena = simspark::SparkArena::create({.body = &body, .players = 2, .seed = 1}, why);
  if (!arena) std::abort();
  simspark::DoorCounts counts;
  auto first = std::make_unique<AgentSession>(*arena, counts, "1");
  auto second = std::make_unique<AgentSession>(*arena, counts, "2");
  MonitorSession monitor(*arena, counts, "3");
  constexpr std::size_t kMostPieces = 64;
  std::size_t pieces = 0;
  for (std::size_t at = 0; at + 2 <= size && pieces < kMostPieces; ++pieces) {
    const std::uint8_t whose = data[at], length = data[at + 1];
    at += 2;
    const auto bytes = std::as_bytes(std::span(data + at, std::min<std::size_t>(length, size - at)));
    at += bytes.size();
    if (whose % 4 == 0) second->receive(bytes);
    if (whose % 4 == 1) monitor.receive(bytes);
    if (whose % 4 >= 2) first->receive(bytes);
    if (whose & 4) {
      arena->step();
      first->tell();
      second->tell();
      monitor.tell();
    }
    check_frames(*first);
    check_frames(*second);
    check_frames(monitor);
    for (std::size_t i = 0; i < arena->players(); ++i)
      if (!math::is_finite(arena->pitch().truth(i).torso.p_m)) std::abort();
    if (whose == 255) {
      first.reset();
      first = std::make_unique<AgentSession>(*arena, counts, "1");
    }
  }
  return 0;
}
