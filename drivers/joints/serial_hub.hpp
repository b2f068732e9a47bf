#pragma once
// One half-duplex serial line and the servos on it: the line's only user, on a thread of its own.
#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "drivers/joints/joint_hub.hpp"
#include "drivers/joints/serial_plan.hpp"
#include "hal/buses.hpp"
#include "hal/os.hpp"
#include "hal/wide.hpp"

namespace sinew::drivers {

struct SerialHubConfig {
  std::string name = "servos";
  SerialLineRate rate;
  hal::ThreadOptions thread{};
};

struct SerialHubStats {
  std::uint64_t ticks = 0, late_ticks = 0;  // late: by more than a period
  std::uint64_t asked = 0, answered = 0;    // questions to one or several servos; answers of one servo
  std::uint64_t missed = 0;                 // answers that did not come in time
  std::uint64_t late = 0;                   // of these, answers that came afterwards
  std::uint64_t foreign = 0;                // packets that nobody waited for
  std::uint64_t broken = 0;                 // packets with a wrong check
  std::uint64_t echoed = 0;                 // bytes of our own that came back
  std::uint64_t errors = 0;                 // of the line itself
  double longest_cycle_s = 0;               // from a tick to its last answer
};

/// In each tick: the goals of all servos in one packet, then all are asked for position, velocity and effort (sync,
/// fast or bulk read, or one by one, as the models can), then one question to one servo: slow registers in turn,
/// set-up, servos that are not there. More such questions follow where the cycle has time left. A servo that does not
/// answer silences those behind it; after two cycles it is asked alone until it is back. Echo of our own bytes is
/// dropped, where the adapter has one. Where most answers come too late, each could be taken for that to a later
/// question: then nothing is asked until the line has been silent. A servo that answers what nobody asked is one of two
/// with its number. A line that is unplugged is opened again each half second. Ticks follow the loop that makes
/// setpoints, as CanHub's. Thread:  add(), configure(), start(), stop(): owner. poke(), stats(), trouble(): any.
/// step(): its thread, or a test's. RT:      step() yes, but for the opening of a line that was gone.
class SerialHub final : public JointHub {
 public:
  /// Opens the line anew; `why` in words.
  using Opener = std::function<hal::Result<std::unique_ptr<hal::Serial>>(std::string& why)>;
  /// `line`: open already; null: `reopen` opens it.
  SerialHub(hal::Os& os, std::unique_ptr<hal::Serial> line, Opener reopen, const SerialHubConfig& config);
  ~SerialHub() override;
  SerialHub(const SerialHub&) = delete;
  SerialHub& operator=(const SerialHub&) = delete;

  /// Before configure(). The owner outlives the hub's thread.
  JointServo& add(std::unique_ptr<SerialServo> servo, ServoOwner& owner, std::size_t index);
  /// Errors: bad_argument: a number twice, packets of both protocols, a cycle that the line cannot hold; `why` says
  /// which.
  hal::Status configure(std::string& why);
  hal::Status start();
  /// Ends the thread, and leaves all servos without torque.
  void stop();
  void poke() noexcept override;
  std::uint64_t ticks() const noexcept override { return counters_.ticks.value(); }
  double tick_hz() const noexcept override { return config_.rate.tick_hz; }

  SerialHubStats stats() const noexcept;
  /// What is wrong with the line itself now; empty: nothing.
  std::string trouble() const;
  std::string shortfall() const { return thread_ ? thread_->shortfall() : std::string(); }
  const SerialHubConfig& config() const noexcept { return config_; }
  std::size_t servos() const noexcept { return servos_.size(); }

  /// Does everything that is due at `now`; answers when to call it again at the latest. For start()'s thread, and
  /// tests.
  Time step(Time now) noexcept;
  /// Opens a line that is gone, each half second. RT: no. Thread: as step(), between two.
  void recover(Time now) noexcept;

 private:
  struct Entry {
    std::unique_ptr<SerialServo> servo;
    ServoOwner* owner = nullptr;
    std::size_t index = 0;
    int owed = 0;    // answers that did not come in time
    Time owed_at{};  // since the last of them
  };
  /// Servos that are read by one packet; of `single` each by its own.
  struct Group {
    CycleRead how = CycleRead::sync;
    wire::ServoRegister reg;
    std::vector<std::size_t> members;
  };
  /// Who is to answer now.
  struct Waiting {
    enum class For : std::uint8_t { nobody, cycle, question } what = For::nobody;
    CycleRead how = CycleRead::sync;
    std::vector<std::size_t> members;  // in the order of their answers
    std::size_t at = 0;                // answered so far
    std::size_t size = 0;              // bytes of each answer
    Time deadline{};
  };

  void ring() noexcept;
  void run();
  void read_line(Time now) noexcept;
  void take_byte(std::uint8_t byte, Time now) noexcept;
  void on_packet(const wire::DxlPacket& packet, Time now) noexcept;
  void on_answer(std::size_t servo, std::uint8_t error, std::span<const std::uint8_t> data, Time now) noexcept;
  void on_stray(const wire::DxlPacket& packet, Time now) noexcept;
  void note_late(Time now) noexcept;
  bool is_late(Time now) const noexcept;
  void miss(std::size_t servo, Time now) noexcept;
  bool is_echo(const wire::DxlPacket& packet) const noexcept;
  void wait_is_over(Time now) noexcept;
  void tick(Time now) noexcept;
  void write_goals() noexcept;
  void take_torque(bool (*from)(const SerialServo&)) noexcept;
  bool ask_next_group(Time now) noexcept;
  bool ask_one(Time now, bool first) noexcept;
  bool send(wire::DxlBuilder& packet, Time now) noexcept;
  void line_is_gone(Time now) noexcept;
  bool has_line() const noexcept { return line_ && !gone_.load(std::memory_order_relaxed); }
  void report(std::size_t servo) noexcept;
  Duration bytes_time(std::size_t bytes) const noexcept;
  wire::DxlVersion version() const noexcept { return servos_.front().servo->model().version; }

  hal::Os& os_;
  std::unique_ptr<hal::Serial> line_;
  Opener open_;
  SerialHubConfig config_;
  Duration period_;
  std::vector<Entry> servos_;
  std::vector<ServoOwner*> owners_;
  std::vector<Group> groups_;
  std::vector<wire::ServoRegister> goals_, torques_;  // each once
  std::unique_ptr<wire::DxlReader> reader_;
  Waiting waiting_;
  std::size_t group_ = 0, member_ = 0, turn_ = 0;
  bool cycle_open_ = false, slow_done_ = false, fast_failed_ = false;
  std::array<std::uint8_t, 4096> sent_{};  // what may come back as an echo
  std::size_t sent_size_ = 0, echo_at_ = 0;
  Time busy_until_{};  // the line carries what we sent
  Time quiet_until_{}, late_at_{};
  std::uint32_t lates_ = 0, in_time_ = 0;  // answers since the first late one, none of which was a second apart
  LineQuestion question_;                  // the last one to one servo
  hal::Wide<std::int64_t> line_late_ns_{0};

  hal::WakeWord word_{0};
  std::atomic<bool> sleeping_{false}, ending_{false}, poked_{false}, gone_{false};
  std::unique_ptr<hal::Thread> thread_;
  Time next_tick_{}, last_tick_{}, next_open_{};
  struct Counters {
    hal::Tally ticks, late_ticks, asked, answered, missed, late, foreign, broken, echoed, errors;
    hal::Wide<double> longest_s;
  } counters_;
  std::uint64_t broken_seen_ = 0;
};

}  // namespace sinew::drivers
