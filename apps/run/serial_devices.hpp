#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "apps/command/json.hpp"
#include "drivers/joints/serial_buses.hpp"
#include "drivers/joints/serial_scan.hpp"

namespace sinew::app {

/// A joint of the robot file on a serial line.
struct ExpectedServo {
  std::string name, bus;
  wire::ServoMaker maker{};
  std::uint8_t id = 0;
};

/// The part of `sinew devices` that asks serial lines. Nothing is written into a servo, and none gets torque.
/// Thread: owner.
class SerialDevices {
 public:
  /// A line of the robot file.
  void add(const std::string& name, const drivers::SerialBusConfig& config);
  /// A line of the command line.
  void add(const std::string& path);
  /// Asks all lines, prints what answers or adds it to `all`. False, after printing why: a joint does not answer, or a
  /// line cannot be asked.
  bool scan(Json& all) const;

  bool dynamixel = true, feetech = true;  // whom to ask for
  bool json = false;
  bool with_robot = false;               // there is a robot file: who is not in it is said
  std::vector<std::uint32_t> bit_rates;  // --bit-rate; empty: each line's own
  std::vector<ExpectedServo> joints;

 private:
  struct Line {
    std::string name;
    hal::SerialSpec spec;
    hal::Duration latency{};
    bool of_robot = false;
  };
  bool scan(const Line& line, Json& all) const;
  std::vector<drivers::SerialFound> ask_again(hal::Serial& port, const Line& line, std::uint8_t id) const;
  bool tell(const Line& line, const std::string& title, const std::vector<drivers::SerialFound>& found,
            const std::vector<std::uint32_t>& skipped, double took_s, Json& all) const;
  drivers::SerialScan::Options options(const Line& line, bool slow_adapter) const;
  const ExpectedServo* joint(const Line& line, const drivers::SerialFound& found) const;

  std::vector<Line> lines_;
};

}  // namespace sinew::app
