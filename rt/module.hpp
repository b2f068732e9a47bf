#pragma once
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "hal/board.hpp"
#include "hal/result.hpp"
#include "rt/declaration.hpp"
#include "rt/step.hpp"

namespace sinew::rt {

/// What configure() may use: the board and plain facts about the robot. Allocation and files are allowed there.
class Setup {
 public:
  virtual ~Setup() = default;
  virtual hal::Board& board() = 0;
  virtual std::string_view module_name() const = 0;
  /// Most pixels that an image of this input has, as the robot file promises; 0: it is not bound.
  virtual std::uint32_t image_pixels(const InputBase& input) const = 0;
  /// Room for pixels behind the images of this output.
  virtual std::uint32_t image_bytes(const OutputBase& output) const = 0;
  /// Adds slots to a raw topic of this module, which its hooks may hold over steps: Raw<>::hold(). They come on top of
  /// all that loans and readers need, so publishing never waits for them.
  virtual void hold(const OutputBase& raw, std::uint32_t slots) = 0;
  /// Narrows a number among this module's parameters, for this run: set_param(), a test's rig and the robot's socket
  /// use the narrowed range from now on. The declaration stays as it is, so that a record of this run can be executed
  /// again, and swept, without the device.
  /// Errors:  bad_argument when the present value (the robot file's, say) is outside; the problem is then reported in
  ///          words already.
  virtual hal::Status narrow(std::string_view param, ParamRange range) = 0;
  /// Reports a problem in words besides the Error that configure() returns ("device 'imu0' is held by pid 12").
  virtual void explain(std::string text) = 0;
};

/// A unit of work with declared ports and parameters. A step is a pure function of latched messages, parameters, now,
/// dt, random and own state, so that any step of any run can be executed again elsewhere with the same result.
/// Thread:  executor (see rt/README.md).
class Module {
 public:
  virtual ~Module() = default;
  /// Declares ports and parameters; the one source for graph check, robot file, recorder and documentation.
  virtual void declare(Declaration& d) = 0;
  /// Opens devices and allocates; the last allocation of the run. Parameters have their values by now.
  virtual hal::Status configure(Setup&) { return {}; }
  /// Forgets all state: called before the first step and when the module is enabled again. RT: yes.
  virtual void reset() {}
  /// RT: yes.
  virtual StepStatus step(const Step& step) noexcept = 0;
};

/// A module with a device behind it. Replay calls neither hook.
class DriverModule : public Module {
 public:
  /// Before the latch: moves what the device has ready into the raw topic. Non-blocking, bounded. RT: yes.
  /// `now` is the instant that the following step will see.
  virtual void collect(Time /*now*/) noexcept {}
  /// After an ok step: hands committed outputs to the device; read them from Out<>::committed(). RT: yes.
  virtual void emit(Time /*now*/) noexcept {}
  /// In place of collect(), in each cycle in which the module does not run because it is switched off or was stopped
  /// after faults. Puts back what collect() holds in Raw<> as soon as the device releases it. RT: yes.
  virtual void rest(Time /*now*/) noexcept {}
  /// Called after the last cycle, before the topics are freed. When it returns, the device touches no slot any more and
  /// every held slot has been put back. Thread: owner. RT: no, may wait for the device.
  virtual void end() noexcept {}
  /// What the hooks learned and steps depend on, besides raw topics: that a device refused, say. It is recorded with
  /// the step that follows; replay, which calls no hook, hands it to the module before that step. RT: yes.
  virtual std::uint32_t device_state() const noexcept { return 0; }
  virtual void set_device_state(std::uint32_t /*state*/) noexcept {}
  /// The device whose readiness may trigger the thread (trigger = "device"); null: none.
  virtual hal::Device* device() { return nullptr; }
};

}  // namespace sinew::rt
