#pragma once
// One CAN bus and everything on it: the bus's only reader, on a thread of its own.
#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "drivers/joints/bus_plan.hpp"
#include "drivers/joints/joint_hub.hpp"
#include "drivers/joints/servo.hpp"
#include "hal/os.hpp"
#include "hal/wide.hpp"

namespace sinew::drivers {

struct CanHubConfig {
  std::string name = "can0";
  double tick_hz = 500;   // setpoints, SYNC and questions go out so often
  double max_load = 0.9;  // of the bit rate, as planned from what its listeners need, with the most stuff bits
  hal::ThreadOptions thread{};
};

struct CanHubStats {
  std::uint64_t frames = 0;     // received and handed on
  std::uint64_t unknown = 0;    // nobody listens to their identifier
  std::uint64_t foreign = 0;    // their identifier has listeners, but none took them
  std::uint64_t malformed = 0;  // not what the protocol allows
  std::uint64_t errors = 0;     // error frames, and reads of a bus that is gone
  std::uint64_t sent = 0, send_failed = 0;
  std::uint64_t ticks = 0, late_ticks = 0;     // late: by more than a period
  double planned_load = 0, measured_load = 0;  // part of the bit rate; measured over the last second
};

/// Reads the bus, hands each frame to the listeners of its identifier (by table, not by search), ticks the servos, and
/// sends their frames. A tick comes every 1/tick_hz. A setpoint that comes when the tick is nearly due (0.9 of it)
/// triggers the tick at once, so that ticks follow the loop that makes setpoints. The bus load is planned for that.
/// Thread:  add(), configure(), start(), stop(): owner. poke(), stats(): any. step(): the hub's thread, or a test's.
/// RT:      step() yes.
class CanHub final : public JointHub {
 public:
  CanHub(hal::Os& os, hal::CanBus& bus, const CanHubConfig& config);
  ~CanHub() override;
  CanHub(const CanHub&) = delete;
  CanHub& operator=(const CanHub&) = delete;

  /// Before configure(). The owner outlives the hub's thread.
  void add(std::unique_ptr<BusService> service);
  ServoProtocol& add(std::unique_ptr<ServoProtocol> servo, ServoOwner& owner, std::size_t index);

  /// Fills the tables and plans the bus load. Errors: bad_argument; `why` says which, without the name of the bus.
  hal::Status configure(std::string& why);
  /// Errors: what starting a thread says.
  hal::Status start();
  /// Ends the thread, and leaves all drives without torque.
  void stop();
  /// A setpoint has come. RT: yes.
  void poke() noexcept override;
  std::uint64_t ticks() const noexcept override { return counters_.ticks.value(); }
  double tick_hz() const noexcept override { return config_.tick_hz; }

  CanHubStats stats() const noexcept;
  /// What its thread asked for and did not get; see hal::Thread::shortfall(). Between start() and stop().
  std::string shortfall() const { return thread_ ? thread_->shortfall() : std::string(); }
  const CanHubConfig& config() const noexcept { return config_; }
  std::size_t servos() const noexcept { return servos_.size(); }

  /// Does everything that is due at `now`; answers when to call it again at the latest. For start()'s thread, and
  /// tests.
  Time step(Time now) noexcept;

 private:
  struct Hook {  // one listener of an identifier, and the next of the same
    CanListener* listener = nullptr;
    std::uint16_t servo = kNoServo, next = kEnd;
  };
  struct MaskTable {  // extended identifiers under one mask: open addressing
    std::uint32_t mask = 0;
    std::vector<std::uint32_t> keys;
    std::vector<std::uint16_t> heads;
  };
  struct Entry {
    std::unique_ptr<ServoProtocol> servo;
    ServoOwner* owner = nullptr;
    std::size_t index = 0;
  };
  class Sink final : public FrameSink {
   public:
    explicit Sink(CanHub& hub) : hub_(hub) {}
    void send(const msg::CanFrame& frame) noexcept override;
    Time deadline{};
    bool patient = false;  // waits for room in the queue until `deadline`; false in ticks

   private:
    CanHub& hub_;
  };
  class BusWake final : public hal::Wake {
   public:
    explicit BusWake(CanHub& hub) : hub_(hub) {}
    void wake() noexcept override { hub_.ring(); }

   private:
    CanHub& hub_;
  };
  static constexpr std::uint16_t kNoServo = 0xFFFF, kEnd = 0xFFFF;

  void ring() noexcept;
  void run();
  bool hook(CanListener& listener, std::uint16_t servo);
  std::uint16_t* head(const Interest& interest);
  std::string plan();
  bool read_frames(Time now) noexcept;
  bool dispatch(std::uint16_t head, const msg::CanFrame& frame, Time now) noexcept;
  void take(const msg::CanFrame& frame, Time now) noexcept;
  void tick(Time now) noexcept;
  void measure_load(Time now) noexcept;

  hal::Os& os_;
  hal::CanBus& bus_;
  CanHubConfig config_;
  Duration period_;
  std::vector<std::unique_ptr<BusService>> services_;
  std::vector<Entry> servos_;
  std::vector<ServoOwner*> owners_;  // each once
  std::vector<Hook> hooks_;
  std::vector<std::uint16_t> standard_;  // first hook of each 11-bit identifier
  std::vector<MaskTable> extended_;
  Sink sink_{*this};
  BusWake bus_wake_{*this};

  hal::WakeWord word_{0};
  std::atomic<bool> sleeping_{false}, ending_{false}, poked_{false};
  std::unique_ptr<hal::Thread> thread_;

  Time next_tick_{}, last_tick_{};
  Time load_since_{};
  std::uint64_t load_bits_ = 0;
  struct Counters {  // written by the hub's thread alone; relaxed: no number depends on another
    hal::Tally frames, unknown, foreign, malformed, errors, sent, send_failed, ticks, late_ticks;
    hal::Wide<double> measured;
  } counters_;
  double planned_load_ = 0;
};

}  // namespace sinew::drivers
