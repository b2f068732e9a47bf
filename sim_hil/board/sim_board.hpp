#pragma once
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "hal/board.hpp"
#include "hal/mutex.hpp"
#include "hal/os.hpp"
#include "hal/stream.hpp"
#include "hal/wide.hpp"
#include "sim_hil/board/clock_keeper.hpp"
#include "sim_hil/board/plant_connection.hpp"
#include "sim_hil/board/sim_devices.hpp"
#include "sim_hil/protocol.hpp"

namespace sinew::sim_hil {

/// A time without a plant: the connection was lost, and made anew.
struct Outage {
  Time at;             // runtime clock
  Duration length{0};  // of the runtime's clock too
  std::string why;
};

/// What happened on the connection, for the report's word on validity.
struct SimStats {
  std::vector<DeviceStats> devices;  // in the Welcome's order
  std::uint32_t grants = 0;
  std::uint32_t commands = 0;
  std::uint32_t commands_dropped = 0;  // free-running: the plant was too slow to take them
  Duration clock_offset{0};            // runtime clock minus plant time
  bool remote = false;                 // the plant runs on another machine: `clock` says how well it is known
  ClockStats clock;
  std::vector<Outage> outages;  // free-running: times without a plant
};

/// How to meet a plant.
struct SimBoardOptions {
  Mode mode = Mode::lockstep;
  std::string robot = "robot";
  std::uint64_t seed = 0;
  double rate = 1.0;                  // free-running: plant seconds per real second
  const hal::Clock* clock = nullptr;  // the executor's: in lockstep its ManualClock; free-running: runs at `rate`
  hal::Os* os = nullptr;              // free-running only
  hal::ThreadOptions reader{"sim_reader", 0, {}, 256 * 1024};  // free-running: the thread that receives
  // Free-running: makes one more connection to the same plant, for the side line that compares clocks with a plant on
  // another machine, and for coming back to a plant that was lost. Empty: neither.
  Connect connect;
  Duration relink_for{0};  // how long to look for a lost plant, with `connect`; 0: the run ends with the connection
  // Free-running: held by a thread that sends. Null: there is no radio, and all actuator groups are on one thread.
  std::shared_ptr<hal::Mutex> send_lock;
  bool accepts_shared_memory = true;
  std::size_t sensor_depth = 64;  // samples that a device keeps for its driver; then it drops the oldest
  std::size_t camera_depth = 4;
  Duration patience = std::chrono::seconds(10);  // a plant that is silent for longer is gone
  Silence silence;  // asked while open(), start() and next_grant() wait for the plant; on their thread
  Duration late_after = std::chrono::milliseconds(2);  // free-running: arrival after `ready` that counts as late
  // Ground truth and the plant's report, for the run's report only. Called on the receiving thread; in lockstep on the
  // executor's, inside next_grant().
  std::function<void(Time, const Truth&)> on_truth;
  std::function<void(const std::string& json)> on_report;
};

/// The hal's devices on a simulator's connection. In lockstep it also grants virtual time.
///     auto stream = hal::connect_stream("unix:/run/plant.sock", 5s);
///     auto board = SimBoard::open(std::move(*stream), {.clock = &clock}, why);
///     hal::Imu* imu = *(*board)->sensor<msg::ImuSample>("imu");
///     ... (*board)->start(); ...
/// Times at its devices are on the runtime's clock. While the board looks for a lost plant, devices have nothing to
/// read and actuators refuse with `closed`; the run goes on.
/// Thread:  owner; in free-running one thread per device, and all actuator groups on one.
/// RT:      after start(): the devices, and next_grant() but for its wait.
/// Errors:  see hal/board.hpp; problem() has them in words.
class SimBoard final : public hal::Board, public hal::GrantSource {
 public:
  static hal::Result<std::unique_ptr<SimBoard>> open(std::unique_ptr<hal::Stream> stream,
                                                     const SimBoardOptions& options, std::string& why);
  ~SimBoard() override;

  const Welcome& plant() const { return welcome_; }
  /// True when this camera's frames come through shared memory.
  bool shares_memory() const { return line_.memory != nullptr; }

  hal::Result<hal::Device*> open_sensor(hal::SensorKind kind, std::string_view name) override;
  hal::Result<hal::Camera*> camera(std::string_view name) override;
  hal::Result<hal::Radio*> radio(std::string_view name) override;
  hal::Result<hal::Actuators*> actuators(std::string_view name) override;

  /// Everything is configured: the plant's time begins. In lockstep the first next_grant() starts it if nobody did.
  hal::Status start();
  /// Lockstep: starts it and waits for the first grant, with which the robot's time begins. The first next_grant()
  /// answers the same again.
  hal::Result<Time> begin();
  /// Lockstep: `done_to` must be the last grant (anything at the first call).
  hal::Result<Time> next_grant(Time done_to) override;
  /// Ends the run politely: when this returns, nothing is received any more and no thread woken. The destructor does it
  /// with a general reason.
  void bye(std::string_view reason);

  bool ended() const { return shared_.ended.load(std::memory_order_acquire); }
  /// Why the run ended, in the plant's words if it said any. After ended().
  const std::string& end_reason() const { return end_reason_; }
  /// The plant said Bye. After ended().
  bool ended_politely() const { return bye_came_; }
  /// It ended because the plant was silent for `patience`. After ended().
  bool silent() const { return end_error_.code == hal::Errc::timeout; }
  /// When the plant was lost or said Bye, by the runtime's clock. After ended().
  Time ended_at() const { return ended_at_; }
  /// The last failed look-up in words, or the reason of the end.
  const std::string& problem() const { return ended() ? end_reason_ : problem_; }
  SimStats stats() const;
  /// One line about a lost plant that the board looks for; empty: the plant is there. Thread: any.
  std::string link_trouble() const;
  /// Free-running: since when a plant that is there has sent nothing at all. Thread: any.
  Duration silent_for() const;

 private:
  class Group;
  class Sending;
  SimBoard(std::unique_ptr<hal::Stream> stream, const SimBoardOptions& options);
  hal::Status shake_hands(std::string& why);
  Hello hello() const;
  void make_devices();
  template <class Wanted>
  hal::Result<Wanted*> find(std::string_view name, DeviceKind kind);
  hal::Status start_plant(PlantConnection& line, std::string& why);
  hal::Status set_clock(const Message& message, Time sent, bool local);
  void read_loop();
  hal::Status read_some();
  bool relink(const hal::Error& lost);
  bool try_relink(std::string& why);
  bool take_line(PlantConnection& fresh);
  bool flush_soon();
  bool leaving() const { return leave_.load(std::memory_order_acquire) != 0; }
  void say_trouble(std::string text);
  hal::Status take(const Message& message, Time arrival);
  hal::Status take_frame(const Message& message, Time arrival);
  hal::Result<bool> read_pixels(std::span<std::uint8_t> into);
  template <class M>
  hal::Status take_sample(const Message& message, Time arrival, DeviceKind kind);
  SimDevice* device_of(std::uint16_t id, DeviceKind kind);
  Arrival arrival_of(const Header& h, Time ready, Time at);
  /// One of the two, or neither: a Stop.
  struct Outgoing {
    Type type;
    std::uint16_t device = 0;
    const Command* command = nullptr;
    const Transmission* datagram = nullptr;
  };
  hal::Status send(Outgoing out);
  hal::Status send_now(const Outgoing& out, Time commit);
  bool add(const Outgoing& out, Time commit);
  hal::Status end(const hal::Error& error);

  SimBoardOptions options_;
  SimShared shared_;
  Welcome welcome_;  // the first one's; a plant that comes back has to fit it
  PlantConnection line_;
  std::optional<ClockKeeper> keeper_;                // a plant on another machine
  std::vector<std::unique_ptr<SimDevice>> devices_;  // by id; null for actuators
  std::vector<std::unique_ptr<Group>> groups_;       // by id; null for the others
  std::unique_ptr<hal::Thread> reader_;
  bool begun_ = false;  // the first grant was asked for by begin(), and next_grant() has not answered it yet
  bool started_ = false, said_bye_ = false, bye_came_ = false;
  Time ended_at_{};
  hal::Error end_error_{hal::Errc::closed, "the plant ended the run"};
  std::string end_reason_, problem_;
  Time last_commit_{};  // of the line; who sends, or the receiver's while there is no line
  std::atomic<std::uint32_t> grants_{0}, commands_{0}, commands_dropped_{0};
  hal::Wide<std::int64_t> heard_ns_{0};  // free-running: when bytes came last, by `os`; 0: not started

  // While the receiver replaces the line, no thread may send on it. A sender sets sending_, then looks at linked_; the
  // receiver clears linked_, then looks at sending_. Sequential consistency: at least one of the two sees the other.
  std::atomic<bool> linked_{true}, sending_{false};
  hal::WakeWord leave_{0};         // the board ends: looks for no plant any more
  mutable std::mutex link_mutex_;  // the line's stream against bye(), the outages, the trouble
  std::vector<Outage> outages_;
  std::string trouble_;
  std::vector<std::unique_ptr<hal::SharedMemory>> retired_;  // frames of lost plants; somebody may still read them
};

}  // namespace sinew::sim_hil
