#pragma once
// A small robot around one device: its source module, a controller that moves actuators, a guardian with conditions on
// the device, all on the real graph in virtual time.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/board/device_board.hpp"
#include "rig.hpp"
#include "rt/exec/discrete_executor.hpp"
#include "rt/latch.hpp"

namespace sinew::test {

/// Counts of the samples that came through the graph since the last clear.
struct Seen {
  std::uint64_t samples = 0;
  std::uint64_t same_stamp = 0;  // as the sample before
  std::uint64_t old = 0;         // taken longer ago than a sample of this kind may be
  Time last{};                   // arrival of the last one
  Time first{};                  // arrival of the first one since cleared; 0: none
  msg::JointState joints;        // the last one
};

/// Actuators that remember what the guardian did to them.
class RecordedActuators final : public hal::Actuators {
 public:
  hal::Status write(const msg::ActuatorCommand& command, Duration) noexcept override {
    ++writes;
    last_was_stop = false;
    moving = command.armed != 0 && command.value[0] != 0;
    return {};
  }
  hal::Status stop() noexcept override {
    last_was_stop = true;
    moving = false;
    return {};
  }
  std::uint64_t writes = 0;
  bool last_was_stop = false, moving = false;
};

/// Calls back between grants.
class Script {
 public:
  virtual ~Script() = default;
  /// Everything up to `now` has happened. False: the run ends.
  virtual bool at(Time now) = 0;
};

class Robot final : private hal::EmptyBoard, private hal::GrantSource {
 public:
  explicit Robot(Rig& rig);
  ~Robot() override;
  /// Opens the devices, configures the graph, starts the buses. Returns nothing when all went well, else the texts for
  /// the user.
  std::vector<std::string> open();
  void run(Script& script);

  std::vector<std::string> complaints() const { return board_->complaints(); }
  const msg::SafetyState& safety() const { return state_; }
  /// Why arming is not permitted, in the guardian's words.
  std::vector<std::string> reasons() const;
  void arm() { (void)graph_->arm(); }  // a full mailbox: asked again
  void disarm() { (void)graph_->disarm(); }
  rt::GraphSpec& spec() { return spec_; }

  static constexpr Duration kStep = 2ms;
  Seen seen;
  RecordedActuators motors;
  double setpoint = 0;  // of all channels, now

 private:
  hal::Result<hal::Device*> open_sensor(hal::SensorKind kind, std::string_view name) override {
    return board_->open_sensor(kind, name);
  }
  hal::Result<hal::Camera*> camera(std::string_view name) override { return board_->camera(name); }
  hal::Result<hal::Actuators*> actuators(std::string_view name) override;
  hal::Result<Time> next_grant(Time done_to) override;
  void add_modules();
  void add_failsafes();

  Rig& rig_;
  rt::GraphSpec spec_;
  rt::ModuleTypes types_;
  std::unique_ptr<drivers::DeviceBoard> board_;
  std::unique_ptr<rt::Graph> graph_;
  std::unique_ptr<rt::Latch> latch_;
  rt::In<msg::SafetyState> safety_;
  msg::SafetyState state_;
  Script* script_ = nullptr;
};

}  // namespace sinew::test
