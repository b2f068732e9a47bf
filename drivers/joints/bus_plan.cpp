#include "drivers/joints/bus_plan.hpp"

#include <cmath>
#include <optional>
#include <typeinfo>

namespace sinew::drivers {
namespace {

bool same_protocol(const ServoProtocol& a, const ServoProtocol& b) { return typeid(a) == typeid(b); }

std::string name_in_quotes(const ServoProtocol& servo) { return "'" + servo.config().name + "'"; }

/// An identifier that both listen to.
const Interest* common(const ServoProtocol& a, const ServoProtocol& b) {
  for (const Interest& i : a.interests())
    for (const Interest& k : b.interests())
      if (i.extended == k.extended && ((i.id ^ k.id) & i.mask & k.mask) == 0) return &k;
  return nullptr;
}

/// Whether `a` answers under the identifier of commands to `b`, of the same protocol.
bool answers_as_command(const ServoProtocol& a, const ServoProtocol& b) {
  for (const Interest& i : a.interests())
    if (!i.extended && i.id == b.config().node_id) return true;
  return false;
}

std::optional<BusClash> clash(const ServoProtocol& a, const ServoProtocol& b) {
  const ServoConfig &first = a.config(), &second = b.config();
  if (!same_protocol(a, b)) {
    if (!common(a, b)) return std::nullopt;
    return BusClash{0, 0, "id", second.node_id,
                    "a number whose frames are not taken for those of " + name_in_quotes(a)};
  }
  if (!a.shares().empty()) {
    if (a.shares() != b.shares() || first.actuator_id != second.actuator_id) return std::nullopt;
    return BusClash{0, 0, "actuator_id", second.actuator_id,
                    "a place that no other servo on its bus has: " + name_in_quotes(a) + " has it"};
  }
  if (first.node_id == second.node_id)
    return BusClash{0, 0, "id", second.node_id,
                    "a number that no other servo on its bus has: " + name_in_quotes(a) + " has it"};
  if (answers_as_command(b, a))
    return BusClash{0, 0, "master_id", first.node_id,
                    "no number of a motor: what it answers would be a command to " + name_in_quotes(a)};
  if (answers_as_command(a, b))
    return BusClash{0, 0, "id", second.node_id,
                    "not the master_id of " + name_in_quotes(a) + ", whose answers would be commands to it"};
  return std::nullopt;
}

}  // namespace

BusLoad plan_load(std::span<const std::unique_ptr<BusService>> services, std::span<const ServoProtocol* const> servos,
                  double tick_hz, double bit_rate) {
  double bits = 0;
  for (const auto& service : services) bits += service->need(tick_hz / kEarliestTick).bits_per_s;
  for (const ServoProtocol* servo : servos) bits += servo->need(tick_hz / kEarliestTick).bits_per_s;
  return {servos.size(), tick_hz, bit_rate, bit_rate > 0 ? bits / bit_rate : 0};
}

std::string to_string(const BusLoad& load) {
  const auto whole = [](double number) { return std::to_string(std::lround(number)); };
  return std::to_string(load.servos) + (load.servos == 1 ? " servo at " : " servos at ") + whole(load.tick_hz) +
         " Hz need " + whole(100 * load.part) + " % of " + whole(load.bit_rate / 1000) +
         " kbit/s: fewer servos, a lower tick_hz, or another bus";
}

std::vector<BusClash> find_clashes(std::span<const ServoProtocol* const> servos) {
  std::vector<BusClash> all;
  for (std::size_t second = 1; second < servos.size(); ++second)
    for (std::size_t first = 0; first < second; ++first)
      if (auto found = clash(*servos[first], *servos[second])) {
        found->first = first, found->second = second;
        all.push_back(std::move(*found));
        break;
      }
  return all;
}

}  // namespace sinew::drivers
