#pragma once
#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "hal/buses.hpp"
#include "hal/os.hpp"
#include "math/random.hpp"
#include "sim_hil/wire/sim_serial_servo.hpp"
#include "sim_hil/worlds/joints.hpp"

namespace sinew::plant {

/// A serial line of a world and its faults: "PATH[,KEY=VALUE...]".
struct WireLineSpec {
  std::string path;                 // where the host finds it
  sim_hil::SimLineOptions line;     // bit_rate, echo, latency_ms
  double lost = 0;                  // share of the bytes that reach nobody
  std::uint8_t return_delay = 250;  // of its servos at first, in 2 us: delay_us
  /// reboot=ID@S, off=ID@S: the servo is without power from then on; overload=ID@S: whenever it has torque from then
  /// on; hot=ID@S: too hot from then on; gone@S: the adapter is unplugged. At S of plant time, once; may be repeated.
  struct Event {
    enum class Kind : std::uint8_t { reboot, off, overload, hot, gone } kind = Kind::reboot;
    std::uint32_t id = 0;
    double at_s = 0;
  };
  std::vector<Event> events;
};
/// Nothing: `why` says what is allowed.
std::optional<WireLineSpec> parse_wire_line(const std::string& text, std::string& why);

/// A half-duplex line of simulated servos behind a serial port of this machine, on a thread of its own, so that bytes
/// take their time as on a real line, to within the thread's wake-ups. The servos' loops run on that thread, too: they
/// see a joint as the world's last step left it.
/// Thread:  owner: the world's. The line's thread touches nothing of the world.
class WireLine {
 public:
  /// `end`: the far end of what the host opens. `fifo_priority`: of its thread; 0: an ordinary one.
  WireLine(hal::Os& os, std::unique_ptr<hal::Serial> end, WireLineSpec spec, int fifo_priority);
  ~WireLine();
  WireLine(const WireLine&) = delete;
  WireLine& operator=(const WireLine&) = delete;

  /// No servos, and no world; ends the thread.
  void clear();
  /// A servo on the world's joint `index`; the line keeps it.
  sim_hil::SimDrive& add(PlantJoints& joints, std::size_t index, const wire::ServoModel& model, std::uint32_t id,
                         double zero_rad);
  /// Starts the thread. Errors: those of starting one.
  hal::Status start();
  /// After each step of the world: the servos see their joints and move them; faults begin.
  void step(hal::Time plant_now);
  /// Held while its servos are changed from another thread than the line's.
  std::mutex& mutex() { return mutex_; }

 private:
  class Joint;
  struct Servo {
    std::unique_ptr<Joint> joint;
    std::unique_ptr<sim_hil::SimSerialServo> servo;
    std::uint32_t id = 0;
    const wire::ServoModel* model = nullptr;
  };
  void run();
  void act(const WireLineSpec::Event& event, bool first);

  hal::Os& os_;
  std::unique_ptr<hal::Serial> end_;
  const WireLineSpec spec_;
  const int fifo_priority_;
  std::mutex mutex_;
  std::unique_ptr<sim_hil::SimSerialLine> line_;
  std::vector<Servo> servos_;
  std::vector<bool> happened_;  // as spec_.events
  bool gone_ = false;
  math::Random random_{1};
  std::atomic<bool> ending_{false};
  std::unique_ptr<hal::Thread> thread_;
};

}  // namespace sinew::plant
