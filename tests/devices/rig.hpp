#pragma once
// One device of the matrix: its table in a robot file, the simulated hardware behind it, and a way to play each fault.
#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "drivers/device_spec.hpp"
#include "fault.hpp"
#include "hal/connectors.hpp"
#include "msg/safety.hpp"
#include "sim_kernel.hpp"
#include "virtual_os.hpp"

namespace sinew::test {

using namespace std::chrono_literals;
using hal::Duration, hal::Time;

/// hal/linux's own openers on the simulated kernel; a rig replaces those that need more than nodes.
class BenchConnectors final : public hal::Connectors {
 public:
  template <class T, class... A>
  using Opener = std::function<hal::Result<std::unique_ptr<T>>(A..., std::string& why)>;
  Opener<hal::CanBus, const hal::CanSpec&> open_can;
  Opener<hal::Imu, const hal::IioSpec&> open_iio;
  Opener<hal::Camera, const hal::CameraSpec&> open_v4l2, open_libcamera;

  hal::Result<std::unique_ptr<hal::CanBus>> can(const hal::CanSpec& spec, std::string& why) override {
    return open_can(spec, why);
  }
  hal::Result<std::unique_ptr<hal::I2cBus>> i2c(const std::string& path, std::string& why) override;
  hal::Result<std::unique_ptr<hal::SpiBus>> spi(const hal::SpiSpec& spec, std::string& why) override;
  hal::Result<std::unique_ptr<hal::Serial>> serial(const hal::SerialSpec& spec, std::string& why) override;
  hal::Result<std::unique_ptr<hal::Gpio>> gpio(const hal::GpioSpec& spec, std::string& why) override;
  hal::Result<std::unique_ptr<hal::Imu>> iio_imu(const hal::IioSpec& spec, std::string& why) override {
    return open_iio(spec, why);
  }
  hal::Result<std::unique_ptr<hal::Camera>> v4l2_camera(const hal::CameraSpec& spec, std::string& why) override {
    return open_v4l2(spec, why);
  }
  hal::Result<std::unique_ptr<hal::Camera>> libcamera_camera(const hal::CameraSpec& spec, std::string& why) override {
    return open_libcamera(spec, why);
  }
  hal::Result<std::unique_ptr<hal::Radio>> radio(const hal::RadioSpec&, std::string& why) override {
    why = "a radio has tests of its own";
    return hal::Error{hal::Errc::not_supported, "radio"};
  }
};

/// A device under test. A new one for each cell.
class Rig {
 public:
  virtual ~Rig() = default;
  /// What is played: each of kFaults, and what this device has beside them.
  virtual std::vector<Fault> faults() const { return {kFaults.begin(), kFaults.end()}; }
  /// The ways in which a fault can be played here; one way without a label where there is only one.
  virtual std::vector<Way> ways(Fault) const { return {{}}; }
  virtual void inject(Fault fault, std::size_t way) = 0;
  virtual void heal() = 0;
  /// The world goes on to `now`: the hardware measures, moves and sends.
  virtual void advance(Time now) = 0;

  /// Replaces paths of the test in a fault's texts by paths of a robot.
  virtual std::string as_on_a_robot(std::string text) const { return text; }

  std::string kind, title;           // of the registry; for the page
  std::string device, measures;      // name in the robot file; "imu", "camera", "joints" ...
  std::vector<std::string> names{};  // an error text must name one of these beside the device: path, bus
  drivers::DeviceSpecs specs;
  bool heals = true;      // false: a test cannot supply what is missing
  bool is_group = false;  // it is the robot's actuator group, too
  SimKernel kernel;
  VirtualOs os;
  BenchConnectors connectors;
};

/// The rigs of one driver kind: one for each bus or protocol that differs.
struct RigKind {
  std::string kind, title;
  std::function<std::unique_ptr<Rig>()> make;
  friend void PrintTo(const RigKind& rig, std::ostream* out) { *out << rig.title; }  // gtest's name for the parameter
};
std::vector<RigKind> chip_rigs();
std::vector<RigKind> serial_rigs();
std::vector<RigKind> iio_rigs();
std::vector<RigKind> camera_rigs();
std::vector<RigKind> joint_rigs();
std::vector<RigKind> serial_joint_rigs();

/// A table of a robot file.
inline drivers::DeviceSpec table(const std::string& name, const std::string& driver,
                                 std::map<std::string, rt::ParamValue> keys) {
  drivers::DeviceSpec spec;
  spec.name = name, spec.driver = driver;
  for (auto& [key, value] : keys) spec.keys[key] = {value, 0};
  return spec;
}

}  // namespace sinew::test
