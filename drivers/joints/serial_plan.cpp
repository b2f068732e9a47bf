#include "drivers/joints/serial_plan.hpp"

#include <algorithm>
#include <cstdio>
#include <map>

namespace sinew::drivers {
namespace {

using wire::dxl_instruction_bytes;
using wire::dxl_status_bytes;
using wire::DxlVersion;

std::string ms_text(Duration d) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", msg::seconds(d) * 1e3);
  return text;
}

/// The address and the number of bytes in an instruction.
std::size_t place_bytes(DxlVersion v) { return v == DxlVersion::one ? 2 : 4; }

}  // namespace

CycleRead cycle_read(const wire::ServoModel& m, bool fast) {
  if (fast && m.fast_read) return CycleRead::fast;
  if (m.sync_read) return CycleRead::sync;
  return m.bulk_read ? CycleRead::bulk : CycleRead::single;
}

SerialPlan plan_serial(std::span<const SerialServo* const> servos, const SerialLineRate& rate) {
  SerialPlan plan;
  plan.servos = servos.size();
  plan.rate = rate;
  const auto time = [&](std::size_t bytes) {
    return Duration{static_cast<std::int64_t>(bytes) * 10'000'000'000 / static_cast<std::int64_t>(rate.bit_rate)};
  };
  std::map<std::pair<std::uint16_t, std::uint8_t>, std::size_t> goals;              // servos by their goal register
  std::map<std::tuple<CycleRead, std::uint16_t, std::uint8_t>, std::size_t> reads;  // and by how they are read
  std::size_t questions = 0, slow = 0;
  for (const SerialServo* servo : servos) {
    const wire::ServoModel& m = servo->model();
    const DxlVersion v = m.version;
    const wire::ServoRegister goal = servo->goal_register(), cycle = m.cycle();
    const auto is_new = [](std::size_t& count) { return count++ == 0; };
    if (is_new(goals[{goal.address, goal.size}])) plan.goals += time(dxl_instruction_bytes(v, place_bytes(v)));
    plan.goals += time(1u + goal.size);
    const CycleRead how = cycle_read(m, rate.fast_read);
    plan.may_read_fast = plan.may_read_fast || (m.fast_read && !rate.fast_read);
    const std::size_t head = dxl_instruction_bytes(v, how == CycleRead::bulk ? 1 : place_bytes(v));
    if (is_new(reads[{how, cycle.address, cycle.size}]) || how == CycleRead::single) {
      ++questions;
      plan.answers += time(head + (how == CycleRead::fast ? wire::dxl_fast_status_bytes(0, 0) : 0));
    }
    const std::size_t each = how == CycleRead::bulk ? 3 : how == CycleRead::single ? 0 : 1;
    plan.answers += time(each + (how == CycleRead::fast ? cycle.size + 4u : dxl_status_bytes(v, cycle.size)));
    slow = std::max(slow, dxl_instruction_bytes(v, place_bytes(v)) + dxl_status_bytes(v, servo->most_slow_bytes()));
  }
  plan.slow = time(slow);
  plan.adapter = rate.latency * static_cast<std::int64_t>(servos.empty() ? 0 : questions + 1);
  return plan;
}

std::string sum_text(const SerialPlan& p) {
  char hz[32];
  std::snprintf(hz, sizeof hz, "%.4g", p.rate.tick_hz);
  const Duration period{static_cast<std::int64_t>(1e9 / p.rate.tick_hz)};
  return std::to_string(p.servos) + (p.servos == 1 ? " servo at " : " servos at ") + hz + " Hz need" +
         (p.servos == 1 ? "s " : " ") + ms_text(p.sum()) + " of " + ms_text(period) + " ms: goals " + ms_text(p.goals) +
         ", answers " + ms_text(p.answers) + ", one slow register " + ms_text(p.slow) + ", the adapter " +
         ms_text(p.adapter);
}

std::string to_string(const SerialPlan& p) {
  return sum_text(p) + ": fewer servos on the line, a lower tick_hz, or a higher bit_rate" +
         (p.may_read_fast ? ", or fast_read" : "");
}

std::vector<SerialClash> find_serial_clashes(std::span<const SerialServo* const> servos) {
  std::vector<SerialClash> all;
  for (std::size_t i = 1; i < servos.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const SerialServo &a = *servos[k], &b = *servos[i];
      if (a.id() == b.id()) {
        all.push_back({i, "id", "a number that no other servo on its line has: '" + a.config().name + "' has it"});
        break;
      }
      if (a.model().version != b.model().version) {
        all.push_back({i, "model",
                       "one with the packets of '" + a.config().name + "' on the same line, protocol " +
                           (a.model().version == DxlVersion::one ? "1.0" : "2.0")});
        break;
      }
    }
  }
  return all;
}

}  // namespace sinew::drivers
