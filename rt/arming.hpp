#pragma once
#include <type_traits>
#include <vector>

#include "rt/declaration.hpp"
#include "rt/graph_spec.hpp"

namespace sinew::rt {

/// Permission to arm, and what the failsafe conditions did to it. No ports, no devices: the guardian passes it the
/// facts of each step and obeys.
///
/// arm() gives permission when everything is ready; with `automatic`, readiness alone does. Permission ends with
/// disarm(), with the controllers' own disarming after a flight, with a stop, and when a condition begins to hold while
/// no command is armed. A condition that begins to hold in flight acts and is latched, also when it ends again.
/// `land` keeps the permission, so that a controller can land; `stop` ends it. disarm() clears what is latched; with
/// automatic arming the controllers' own disarming clears it too, and disarm() then means "not before arm()".
/// Ready:   no condition holds, nothing is latched, every group has a fresh and valid command and a device that obeys,
///          and none is commanded to move (automatic arming asks for this only after a stop and after disarm()).
/// Thread:  executor.   RT: yes.
class Arming {
 public:
  struct Facts {
    Time now;
    std::uint32_t conditions = 0;  // conditions that hold, one bit each
    bool groups_good = false;      // fresh and valid commands, devices that obey
    bool commanded = false;        // some group's newest command is armed
    bool idle = false;             // no group is commanded to move
  };
  Arming(GuardianSpec::Arming mode, const std::vector<FailsafeSpec>& failsafes);

  void declare_state(Declaration& d);
  void reset();
  /// Call between two steps: judges the facts of the last one. False: not ready, nothing has changed.
  bool arm() noexcept;
  void disarm() noexcept;
  void step(const Facts& facts) noexcept;

  bool permitted() const { return is_.permitted; }
  bool ready() const { return is_.ready; }
  /// True when arming also requires that no group is commanded to move.
  bool wants_idle() const { return mode_ == GuardianSpec::Arming::manual || is_.held || is_.latched != 0; }
  msg::FailsafeAction action() const { return is_.action; }
  std::uint32_t latched() const { return is_.latched; }
  std::uint32_t acted() const { return is_.acted; }
  /// The step that saw the last disarm() in flight; 0: there was none.
  Time disarmed() const { return is_.disarmed; }

 private:
  void act(const Facts& facts) noexcept;
  void forget() noexcept;

  struct State {
    bool permitted = false, ready = false, live = false;
    bool held = false;            // by disarm(), until arm()
    bool cut_off = false;         // by a disarm() in flight that no step has seen yet
    std::uint8_t unused[3] = {};  // in place of padding: a saved state has the same bytes in every run
    Time disarmed{};
    std::uint32_t latched = 0, acted = 0;
    msg::FailsafeAction action = msg::FailsafeAction::none;
    std::uint32_t unused_end = 0;
  };
  static_assert(std::has_unique_object_representations_v<State>);
  const GuardianSpec::Arming mode_;
  const std::vector<FailsafeSpec> failsafes_;
  State is_;
  std::vector<Time> latched_at_;  // valid for latched conditions
};

}  // namespace sinew::rt
