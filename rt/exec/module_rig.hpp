#pragma once
// Runs one module alone, for tests: no threads, no schedule, no clock, but the real ports, slots, latch and commit.
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "msg/image_buffer.hpp"
#include "rt/exec/stats.hpp"
#include "rt/graph.hpp"

namespace sinew::rt {

struct RigOptions {
  std::string name = "module";                // step.random depends on it
  std::uint64_t seed = 1;                     // step.random depends on it, too
  hal::Board* board = nullptr;                // for configure(); null: a board without devices
  std::uint32_t image_bytes = 640 * 480 * 3;  // pixels behind images; image_capacity() for single ports
  std::uint32_t first_sequence = 0xFFFFFF00;  // of every topic: shortly before the wrap
};

/// One module on a bench: parameters and messages go in, one step at a time runs, messages come out.
///
///   GimbalLevel gimbal;
///   rt::ModuleRig rig(gimbal);
///   rig.set("kp", 2.0);
///   rig.put("imu", sample);
///   EXPECT_EQ(rig.step(Time{5'000'000}, 5ms), rt::StepStatus::ok);
///   const auto* tilt = rig.get<msg::JointCommand>("tilt");
///
/// A step is that of the executors, by the same code: collect(), latch, step() inside the trap, commit or discard,
/// emit(). Every input is bound, each to a topic of its own; outputs are read as another thread would read them.
/// Thread:  owner.   RT: no, but the module's step is.
/// Owner:   the module outlives the rig and is not in a graph; what get() and all() answer lives until the next step.
/// Errors:  wrong use (no such port or parameter, another type, a value out of range, configure() that fails unasked)
///          ends the program with a text that says so.
class ModuleRig {
 public:
  explicit ModuleRig(Module& module, RigOptions options = {});
  ~ModuleRig();
  ModuleRig(const ModuleRig&) = delete;
  ModuleRig& operator=(const ModuleRig&) = delete;

  // ---- before the first put() or step()
  /// Leaves an optional input without a topic.
  void leave_unbound(std::string_view input);
  /// The type of an AnyIn or AnyOut.
  template <msg::Described M>
  void carries(std::string_view name) {
    carries_erased(name, msg::type_info<M>());
  }
  /// Room for pixels behind the images of this input or output.
  void image_capacity(std::string_view name, std::uint32_t bytes);
  /// Configures and resets the module; the first put() or step() does so otherwise.
  /// Errors:  what the module said; problems() has it in words.
  hal::Status configure();
  const std::vector<Problem>& problems() const;

  // ---- parameters, between steps
  /// Allowed before and after configure(), which may have narrowed the accepted values.
  void set(std::string_view name, const ParamValue& value);
  /// Empty when the parameter accepts the value; else what is allowed, in the words of the robot file's check.
  std::string refusal(std::string_view name, const ParamValue& value) const;

  // ---- messages in: each put() is one commit; a queue input holds all since the last step, as far as its depth allows
  template <msg::Described M>
  requires(!msg::HasBulk<M>) void put(std::string_view input, const M& message, std::optional<Time> published = {}) {
    put_erased(input, msg::type_info<M>(), &message, published);
  }
  /// `published`: the commit instant; by default the instant of the last step.
  void put_image(std::string_view input, const msg::ImageBuffer& image, std::optional<Time> published = {}) {
    put_erased(input, msg::type_info<msg::Image>(), &*image, published);
  }

  // ---- one step
  /// `dt` is not 0. Repeated faults never stop the module here.
  StepStatus step(Time now, Duration dt, bool timed_out = false);
  /// The module forgets all state, as when it is enabled again; its next step has number 0.
  void reset();
  /// One cycle in which the module is switched off; step() switches it on again, and resets it.
  void rest(Time now);

  // ---- messages out, of the last step; raw topics of driver modules too
  /// The newest; null when the step published none there.
  template <msg::Described M>
  const M* get(std::string_view output) const {
    const SlotHeader* newest = nullptr;
    for (const SlotHeader* h : published(output, msg::type_info<M>())) newest = h;
    return newest ? static_cast<const M*>(newest->message()) : nullptr;
  }
  /// All, oldest first.
  template <msg::Described M>
  std::vector<const M*> all(std::string_view output) const {
    std::vector<const M*> messages;
    for (const SlotHeader* h : published(output, msg::type_info<M>()))
      messages.push_back(static_cast<const M*>(h->message()));
    return messages;
  }
  /// The slot headers of all<M>(): sequence, commit instant.
  std::vector<const SlotHeader*> headers(std::string_view output) const;
  const ModuleStats& stats() const;

 private:
  struct Run;
  class Observer;
  void put_erased(std::string_view input, const msg::TypeInfo& type, const void* message,
                  std::optional<Time> published);
  std::vector<const SlotHeader*> published(std::string_view output, const msg::TypeInfo& type) const;
  const Declaration::Port& port(std::string_view name) const;
  void carries_erased(std::string_view name, const msg::TypeInfo& type);
  const msg::TypeInfo& type_of(const Declaration::Port& port) const;
  void be_configured();
  GraphSpec spec() const;

  Module& module_;
  RigOptions options_;
  Declaration declaration_;
  std::map<std::string, std::uint32_t, std::less<>> image_bytes_;
  std::map<std::string, const msg::TypeInfo*, std::less<>> types_;  // of ports without one
  std::vector<std::string> unbound_;
  Time now_{};
  std::unique_ptr<Run> run_;  // null before configure()
};

}  // namespace sinew::rt
