#include "apps/flight/verdict.hpp"

namespace sinew::app {

RunVerdict judge(const WorldReport& report, MissionWatch& mission) {
  const auto* state = mission.look();
  const bool done = state && state->phase == msg::MissionPhase::done;
  if (!report.verdict) {  // this simulator does not judge
    if (!mission.exists()) return {"", true};
    return {done ? "mission done" : "mission not done", done};
  }
  RunVerdict verdict{report.verdict->outcome, report.verdict->good};
  if (mission.exists()) {
    if (verdict.good && !done) return {verdict.outcome + ", but the mission does not know", false};
    return verdict;
  }
  if (!report.verdict->begun) return {"", true};
  const msg::SafetyState& safety = mission.safety();
  if (verdict.good && (safety.acted != 0 || safety.mode == msg::GuardianMode::safe))
    return {verdict.outcome + ", but a fault stopped it", false};
  return verdict;
}

}  // namespace sinew::app
