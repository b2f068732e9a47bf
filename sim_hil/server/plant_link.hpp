#pragma once
// The plant's end of the simulator protocol: any simulator in C++ speaks it through this class.
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/stream.hpp"
#include "sim_hil/caller.hpp"
#include "sim_hil/message_io.hpp"
#include "sim_hil/protocol.hpp"
#include "sim_hil/server/robot_clock.hpp"

namespace sinew::sim_hil {

/// A plant's description of itself. A device's id is its place in `devices`.
struct PlantDescription {
  std::string name;
  Duration step{0};
  std::optional<std::uint64_t> seed;  // used instead of the one that the runtime asks for
  std::vector<DeviceInfo> devices;    // slots* of cameras are filled in by the link
};

/// The setpoints of one actuator group in the plant step that starts at a given time.
struct Setpoints {
  bool valid = false;  // false: safe action (no command yet, lease over, stopped, not armed)
  bool lease_over = false;
  std::uint32_t count = 0;
  std::array<double, msg::kMaxChannels> value{};
  Time commit{-1}, stamp{-1};  // of the newest command or stop, valid or not; stamp: of its measurement
  Duration lease{0};
};

/// Room for one camera frame; the renderer writes it, on any thread, until send_frame().
struct FrameSlot {
  std::uint32_t index = 0;
  std::span<std::uint8_t> pixels;  // exactly width * height * bytes per pixel
};

struct FrameMeta {
  Time stamp, ready;
  std::int64_t exposure_ns = 0;
  std::uint32_t number = 0;
};

/// The loop of a plant in lockstep, which lets commands act exactly at their commit:
///     link.wait_start();
///     for (Time t{0}; ; t = t + step) {
///       ... send() what is due by t ...
///       if (!link.grant(t)) break;                 // one write, one read
///       world.step(link.setpoints_at(motors, t));
///     }
/// Free-running: start_clock() once, then send() when due and exchange() after each plant step.
/// Thread:  owner, except the pixels of a FrameSlot.
/// RT:      no allocation after accept(); blocking as said.
/// Errors:  closed when the runtime went away (reason() has its words); bad_data when it broke the protocol. Every
///          later call says so again.
class PlantLink {
 public:
  /// Shakes hands over a fresh connection. `frames` (may be null) must be at least frame_memory_bytes() large; it is
  /// used when the runtime is local and accepts it, else frames go through the stream. On failure tells the peer, and
  /// `why` has it in words.
  static hal::Result<std::unique_ptr<PlantLink>> accept(std::unique_ptr<hal::Stream> stream, PlantDescription plant,
                                                        hal::SharedMemory* frames, std::string& why);
  /// The same with a runtime that has said its Hello already (plant_listener.hpp).
  static hal::Result<std::unique_ptr<PlantLink>> accept(Caller caller, PlantDescription plant,
                                                        hal::SharedMemory* frames, std::string& why);
  static std::size_t frame_memory_bytes(const PlantDescription& plant);

  const Hello& hello() const { return hello_; }
  bool frames_in_shared_memory() const { return frames_ != nullptr; }

  /// Waits until the runtime is configured. Errors: closed, timeout.
  hal::Status wait_start();
  /// Lockstep, before the first grant: all times on the wire are of this clock, all times here are the plant's. Samples
  /// that are a nanosecond apart may get equal stamps.
  void set_robot_clock(const RobotClock& clock) { clock_ = clock; }
  /// Free-running only, right after wait_start(): plant time `now` is now, when the host's clock shows `host_now`.
  hal::Status start_clock(Time now, Time host_now);

  // Samples go out with the next grant(), exchange() or when the buffer is full. Stamp and ready of a device never
  // decrease. A sample may be sent early: the runtime's driver sees it at `ready`.
  hal::Status send(std::uint16_t device, const msg::ImuSample& sample, Time ready);
  hal::Status send(std::uint16_t device, const msg::RangeSample& sample, Time ready);
  hal::Status send(std::uint16_t device, const msg::BaroSample& sample, Time ready);
  hal::Status send(std::uint16_t device, const msg::BatterySample& sample, Time ready);
  hal::Status send(std::uint16_t device, const msg::SolePressure& sample, Time ready);
  hal::Status send(std::uint16_t device, const msg::RefereeState& sample, Time ready);
  hal::Status send(std::uint16_t device, const msg::JointState& state, Time ready);
  hal::Status send(std::uint16_t device, const msg::Datagram& datagram, Time ready);
  hal::Status send_truth(Time now, const Truth& truth);
  hal::Status send_report(Time now, std::string_view json);

  /// The next slot of this camera, round robin. Begin at most two before sending them (in that order); the runtime
  /// relies on it for the frames that it has not read yet.
  FrameSlot begin_frame(std::uint16_t camera);
  hal::Status send_frame(std::uint16_t camera, const FrameSlot& slot, const FrameMeta& meta);

  /// Lockstep: everything with ready <= until has been sent; returns when the runtime has answered up to there.
  hal::Status grant(Time until);
  /// The two halves of grant(), for a plant with several runtimes: all work at the same time.
  hal::Status begin_grant(Time until);
  hal::Status wait_done();
  /// Free-running: sends the buffer and takes in what has arrived; never waits for the runtime. Bytes that the runtime
  /// does not take at once wait, and go first; when too many wait, samples and frames are dropped and counted.
  hal::Status exchange();
  /// The newest command with commit <= t, while its lease lasts (t < commit + lease). Call with increasing t.
  Setpoints setpoints_at(std::uint16_t device, Time t);
  /// A datagram that a radio of the runtime has sent.
  struct Sent {
    std::uint16_t device = 0;
    Time commit;
    Transmission datagram;
  };
  /// Those that came since forget_sent(), in the order of their commits; at most kMostSent, others are counted.
  std::span<const Sent> sent() const { return {sent_.data(), sent_count_}; }
  void forget_sent() { sent_count_ = 0; }
  /// Safe action for all groups until the end of the run, whatever the runtime commands: the stop line was pulled.
  void stop_for_good() { stopped_for_good_ = true; }
  /// Free-running: the runtime is gone and the world goes on. From now on sends succeed and reach nobody; the last
  /// command runs out with its lease.
  void go_alone();

  /// The last word; the runtime reports it as the reason of the end.
  void bye(std::string_view reason);
  const std::string& reason() const { return reason_; }
  /// The runtime said Bye; false when the connection just broke.
  bool ended_politely() const { return bye_came_; }

  struct Stats {
    std::uint64_t grants = 0, commands = 0, stops = 0;
    std::uint64_t lease_expiries = 0;                       // times a running group fell back to its safe action
    std::uint64_t commands_overwritten = 0;                 // more waiting at once than kPendingCommands
    std::uint64_t samples_dropped = 0, frames_dropped = 0;  // free-running: the runtime or the network was too slow
    std::uint64_t datagrams_dropped = 0;                    // more at once than kMostSent
    std::uint64_t bytes_in = 0, bytes_out = 0;
  };
  const Stats& stats() const { return stats_; }

  static constexpr std::uint32_t kFrameSlots = 8;    // per camera, in shared memory
  static constexpr std::uint32_t kStagingSlots = 2;  // per camera, when frames go through the stream
  static constexpr std::size_t kPendingCommands = 16;
  static constexpr std::size_t kMostSent = 64;

 private:
  struct Timed {
    Time commit;
    Command command;
    bool stop = false;
  };
  struct Group {
    Timed active;
    bool any = false, running = false;
    Time last_commit{};
    std::array<Timed, kPendingCommands> pending;
    std::size_t first = 0, count = 0;
  };
  struct CameraState {
    std::uint32_t next = 0, generation = 0;
    std::vector<std::uint8_t> staging;  // frames through the stream
  };

  PlantLink(Caller caller, PlantDescription plant);
  hal::Status send_welcome();
  hal::Status fail(hal::Error error);
  hal::Status fail_write(hal::Error error);
  hal::Status flush();
  hal::Status push(Bytes head, Bytes tail);
  hal::Status push_backlog();
  bool crowded() const { return backlog_.size() - backlog_sent_ > kMaxSmallBytes; }
  hal::Status receive(Message& out);
  hal::Status take(const Message& message);
  hal::Status take_transmission(const Message& message);
  hal::Status take_timed(std::uint16_t device, const Timed& timed);
  hal::Status expect_kind(std::uint16_t device, DeviceKind kind) const;
  template <class Payload>
  hal::Status add(Type type, std::uint16_t device, Time time, const Payload& payload, std::size_t bulk = 0);

  std::unique_ptr<hal::Stream> stream_;
  PlantDescription plant_;
  Hello hello_;
  MessageReceiver in_;
  MessageWriter out_;
  hal::SharedMemory* frames_ = nullptr;
  std::vector<Group> groups_;         // by device
  std::vector<CameraState> cameras_;  // by device
  std::vector<Sent> sent_;            // room for kMostSent where there is a radio
  std::size_t sent_count_ = 0;
  Time last_sent_{};
  bool answered_ = false;  // the runtime said Done
  bool said_bye_ = false, bye_came_ = false, stopped_for_good_ = false, alone_ = false;
  bool running_ = false;            // free-running, and the clock has been started: writing must not wait
  std::vector<std::byte> backlog_;  // what the socket has not taken, from backlog_sent_ on
  std::size_t backlog_sent_ = 0;
  RobotClock clock_;
  Time granted_{-1};  // by the robot's clock
  hal::Status state_;
  std::string reason_;
  Stats stats_;
};

}  // namespace sinew::sim_hil
