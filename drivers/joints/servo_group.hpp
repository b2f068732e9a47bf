#pragma once
// A named group of joints as the robot sees them: actuators to write, joints to read.
//
//   // Two pan/tilt joints on one bus, the way a board builds them from its configuration:
//   drivers::ServoGroup head(os, "head");
//   drivers::CanHubConfig can0{.name = "can0", .tick_hz = 500};
//   can0.thread.name = "can0", can0.thread.fifo_priority = 70;
//   drivers::CanHub hub(os, bus, can0);
//   hub.add(std::make_unique<drivers::CanopenMaster>());                       // once a bus with CANopen drives
//   drivers::ServoConfig pan{.name = "pan", .node_id = 1, .counts_per_turn = 65536};
//   drivers::ServoConfig tilt{.name = "tilt", .node_id = 2, .counts_per_turn = 65536};
//   for (const auto& c : {pan, tilt}) {
//     if (auto wrong = drivers::check_cia402(c, {.tick_hz = 500}); !wrong.empty()) return to_string(wrong);
//     head.add(hub, std::make_unique<drivers::Cia402Servo>(c, drivers::Cia402Options{.tick_hz = 500}));
//   }
//   std::string why;
//   if (!hub.configure(why)) return why;                                      // numbers twice, bus load
//   hub.start();                                                              // all hubs of all groups
//   hal::Actuators& actuators = head; hal::Joints& joints = head;             // what hal::Board answers with
//
// A group outlives the threads of its hubs: declare it before them, or stop() them first.
#include <array>

#include "drivers/joints/can_hub.hpp"
#include "drivers/seq_lock.hpp"
#include "hal/device.hpp"
#include "hal/wake_slot.hpp"

namespace sinew::drivers {

/// Up to msg::kMaxChannels joints, on one bus or several. Setpoints are in the unit of each joint's mode, channel by
/// channel in the order of add(). When their lease runs out each joint does its stop action.
/// Samples come when all joints on the first joint's bus have measured anew, at least once a tick of that bus. A reader
/// that was away for long gets the newest one alone.
/// Bit i of JointState::ready: joint i is enabled, and nothing is wrong with it but that it is warm or at a limit.
/// Thread:  add(): owner, configure only. write(), stop(): one at a time (the guardian). read(): one. request(): any.
/// RT:      yes, none of them waits.
class ServoGroup final : public hal::Actuators, public hal::Joints, private ServoOwner {
 public:
  ServoGroup(hal::Os& os, std::string name) : os_(os), name_(std::move(name)) {}

  /// The next channel. Errors: bad_argument when there are kMaxChannels already.
  template <class Hub, class Servo>
  hal::Status add(Hub& hub, std::unique_ptr<Servo> servo) {
    if (count_ == msg::kMaxChannels) return hal::Error{hal::Errc::bad_argument, "joints of a group", 0};
    const std::size_t index = place(hub);
    joints_[index].servo = &hub.add(std::move(servo), *this, index);
    return {};
  }
  const std::string& name() const { return name_; }
  std::size_t size() const { return count_; }

  /// Errors: bad_argument: another number of channels, a value that is not finite: the previous setpoints run out.
  hal::Status write(const msg::ActuatorCommand& command, Duration lease) noexcept override;
  hal::Status stop() noexcept override;
  /// own: each joint does its stop action, as at the end of a lease; limp: no torque, and no disarming.
  hal::Status fall_back(hal::FallBack how) noexcept override;

  hal::Result<bool> read(msg::JointState& out) noexcept override;
  Time ready_at() const noexcept override;
  void set_wake(hal::Wake* wake) noexcept override { wake_.change(wake); }
  std::uint64_t lost_samples() const noexcept { return lost_.value(); }

  /// Homing, or a new zero here; done once, when the joint can.
  void request(std::size_t joint, ServoCommand::Request what) noexcept;
  /// What the joint said last. False: its hub was writing all the while, look again. Thread: any. RT: yes.
  bool feedback_of(std::size_t joint, ServoFeedback& out) const noexcept { return joints_[joint].feedback.load(out); }
  /// Its servo: identity, statistics, its zero after zero_here. Thread: when its hub does not run.
  const JointServo& servo(std::size_t joint) const { return *joints_[joint].servo; }

 private:
  struct Setpoints {
    std::array<double, msg::kMaxChannels> value{};
    std::int64_t until_ns = 0;  // 0: never written
    std::uint32_t number = 0;
    bool armed = false, limp = false;
  };
  struct Joint {
    std::size_t hub = 0;  // in hubs_
    const JointServo* servo = nullptr;
    SeqLock<ServoFeedback> feedback;        // written by its hub's thread
    std::atomic<std::uint32_t> request{0};  // number * 4 + what
    std::uint32_t number = 0;               // of the feedback stored last; its hub's thread
    bool absent = true, ready = false;      // likewise
    Time ready_since{}, well_at{};          // well: ready for a second on end, or nobody wants it; its hub's thread
    Duration refusing{};                    // see ServoFeedback; its hub's thread
    std::uint32_t published = 0;            // number in the last sample; first hub's thread
    ServoFeedback last;                     // as could be read last; first hub's thread
  };

  std::size_t place(JointHub& hub);
  void latch(const JointHub& hub) noexcept override;
  ServoCommand command(std::size_t index, Time now) noexcept override;
  void feedback(std::size_t index, const ServoFeedback& feedback) noexcept override;
  void settled(const JointHub& hub, bool tick) noexcept override;
  static void watch(Joint& joint, bool wanted, Time now) noexcept;
  hal::Status hand_over(Setpoints setpoints) noexcept;
  bool all_measured_anew() const noexcept;
  void publish() noexcept;
  void compose(msg::JointState& out) noexcept;

  hal::Os& os_;
  std::string name_;
  std::array<Joint, msg::kMaxChannels> joints_;
  std::size_t count_ = 0;
  std::vector<JointHub*> hubs_;     // the first one's thread makes the samples
  std::vector<Setpoints> latched_;  // each is its hub's thread's
  SeqLock<Setpoints> setpoints_;
  Setpoints handed_;  // the last ones; writer's

  static constexpr std::uint32_t kRing = 32;
  std::array<msg::JointState, kRing> ring_{};
  struct Beside {
    msg::JointState sample;
    std::uint32_t head = 0;  // of the ring that was full
    bool any = false;
  };
  Beside beside_;                                 // the newest that the ring had no room for; first hub's thread
  SeqLock<Beside> newest_;                        // the same, for the reader
  std::atomic<std::uint32_t> head_{0}, tail_{0};  // first hub's thread; reader's
  hal::Tally lost_;
  bool published_this_tick_ = false;
  hal::WakeSlot wake_;
};

}  // namespace sinew::drivers
