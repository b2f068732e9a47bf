#pragma once
#include <array>
#include <memory>
#include <string>

#include "hal/buses.hpp"
#include "msg/sensors.hpp"
#include "wire/iio.hpp"

namespace sinew::sim_hil {

/// A device of a simulated IIO tree.
struct IioTreeSpec {
  std::string root;                     // the folder that stands for "/"; made where it is missing
  unsigned number = 0;                  // iio:deviceN
  std::string name = "mpu6050", label;  // label: no file when empty
  bool accel = true, gyro = true, stamps = true, buffer = true;
  std::string form = "be:s16/16>>0";  // of the axes
  double accel_scale = 0.000598550;   // m/s^2 a count: +-2 g
  double gyro_scale = 0.001064724;    // rad/s a count: +-2000 deg/s
  double offset = 0;                  // counts
  std::string mount_matrix;           // no file when empty
};

/// The files under which Linux shows an IMU, fed with samples: the real driver reads them as it reads the kernel's.
/// Nothing here checks what the driver writes: a value that the kernel would refuse is taken.
/// Thread:  owner.   RT: no.
class IioTree {
 public:
  /// Makes the folders and files. Errors: io (the folder cannot be written), bad_argument (form, mount matrix).
  static hal::Result<std::unique_ptr<IioTree>> make(const IioTreeSpec& spec);
  ~IioTree();
  IioTree(const IioTree&) = delete;
  IioTree& operator=(const IioTree&) = delete;

  /// Where the buffer's pipe belongs: ROOT/dev/iio:deviceN.
  std::string buffer_path() const;
  void attach(std::unique_ptr<hal::Serial> pipe) { pipe_ = std::move(pipe); }
  /// Whether the driver has switched the buffer on.
  bool enabled() const;
  /// Takes base coordinates. A scan with the switched-on elements goes into the buffer, and the raw files change.
  /// Errors:  closed after unplug(); timeout when the buffer is full (the scan is lost, as in the kernel).
  hal::Status feed(const msg::ImuSample& sample);
  /// Puts these bytes into the buffer as they are.
  hal::Status feed_raw(std::span<const std::uint8_t> bytes);
  std::size_t scan_bytes() const { return layout_.scan_bytes(); }
  /// Device and files vanish.
  void unplug();

  /// A trigger of that name in the tree.
  static void make_trigger(const std::string& root, unsigned number, const std::string& name);
  /// For tests: the content of a file of the device ("sampling_frequency"), and a setter for it; empty text: removes
  /// it.
  std::string file(const std::string& name) const;
  void set_file(const std::string& name, const std::string& text);
  const std::string& folder() const { return folder_; }

 private:
  explicit IioTree(const IioTreeSpec& spec);
  void make_files();
  std::array<std::int64_t, 3> counts(const msg::Vec3& v, double scale) const;

  IioTreeSpec spec_;
  std::string folder_;
  std::array<double, 9> mount_{1, 0, 0, 0, 1, 0, 0, 0, 1};
  wire::IioLayout layout_;
  std::unique_ptr<hal::Serial> pipe_;
  bool there_ = true;
};

}  // namespace sinew::sim_hil
