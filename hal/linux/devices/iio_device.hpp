#pragma once
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/connectors.hpp"
#include "wire/iio.hpp"

namespace sinew::hal {

/// The three axes of one sensor in an IIO device: how raw numbers become SI units in the board's axes.
struct IioAxes {
  std::array<double, 3> scale{1, 1, 1}, offset{};
  std::array<double, 9> mount{1, 0, 0, 0, 1, 0, 0, 0, 1};  // row by row
  msg::Vec3 to_board(const std::array<double, 3>& raw) const;
};

/// One device of the kernel's Industrial I/O: its files below ROOT/sys/bus/iio/devices/iio:deviceN, and its buffer
/// ROOT/dev/iio:deviceN.
/// Source:  Linux Documentation/ABI/testing/sysfs-bus-iio; facts in docs/sensors.md.
/// Thread:  owner.   RT: no.
class IioDevice {
 public:
  /// Finds a device by its name, its label, or "iio:deviceN". Errors: not_found, bad_argument (two have that name),
  /// denied.
  static Result<std::unique_ptr<IioDevice>> find(const std::string& root, const std::string& name, std::string& why);
  ~IioDevice();
  IioDevice(const IioDevice&) = delete;
  IioDevice& operator=(const IioDevice&) = delete;

  /// "iio:device0 (mpu6050)".
  const std::string& title() const { return title_; }
  /// True if the device has in_SENSOR_x_raw ("accel", "anglvel").
  bool has(std::string_view sensor) const;
  /// Its channels, by the in_*_raw files; for error texts.
  std::string channels() const;

  /// Sets rate and trigger of the spec, then reads scales, offsets and mount matrices of these sensors. `buffered`: for
  /// start_buffer(), else for start_polling(), where the caller makes the rate.
  /// Errors:  not_supported (no buffer), bad_argument (rate, trigger), bad_data (a file that holds no number), denied,
  ///          io.
  Status set_up(const IioSpec& spec, bool buffered, const std::vector<std::string>& sensors, std::string& why);
  /// Switches the scan elements of those sensors and the timestamp on, and starts. Errors: not_supported (no trigger),
  /// busy, bad_data, denied, io.
  Status start_buffer(const IioSpec& spec, std::string& why);
  /// Opens the raw files instead.
  Status start_polling(std::string& why);
  bool buffered() const { return fd_ >= 0; }

  const IioAxes& axes(std::size_t sensor) const { return sensors_[sensor].axes; }
  /// The buffer's descriptor, for poll().
  int fd() const { return fd_; }
  /// Bytes of whole scans that are there now; 0: none. Errors: closed (unplugged), io.
  Result<std::size_t> read(std::span<std::uint8_t> into) noexcept;
  std::size_t scan_bytes() const { return layout_.scan_bytes(); }
  /// Raw numbers of the i-th sensor in a scan.
  std::array<double, 3> raw(std::span<const std::uint8_t> scan, std::size_t sensor) const noexcept;
  /// In the kernel's clock; nothing: the device gives no stamps.
  std::optional<std::int64_t> stamp(std::span<const std::uint8_t> scan) const noexcept;
  bool monotonic() const { return monotonic_; }
  /// Reads the raw files of the i-th sensor. Errors: closed, bad_data, io.
  Result<std::array<double, 3>> poll(std::size_t sensor) noexcept;

 private:
  struct Sensor3 {
    std::string name;
    IioAxes axes;
    std::array<const wire::IioChannel*, 3> channel{};
    std::array<int, 3> raw_fd{-1, -1, -1};
  };
  IioDevice(std::string root, std::string entry, std::string title);
  std::string file(std::string_view name) const { return folder_ + "/" + std::string(name); }
  Status set_rate(const IioSpec& spec, bool buffered, std::string& why);
  Status set_trigger(const IioSpec& spec, std::string& why);
  Status read_axes(Sensor3& sensor, std::string& why);
  /// The number in the first of these files that exists; `otherwise` when there is none.
  Result<double> number_of(std::initializer_list<std::string> names, double otherwise, std::string& why);
  Status choose_elements(std::string& why);
  Status read_layout(std::string& why);
  Status open_node(std::string& why);
  Status end_left_stream(bool keep_node, std::string& why);

  std::string root_, entry_, title_, folder_;
  std::vector<Sensor3> sensors_;
  wire::IioLayout layout_;
  const wire::IioChannel* stamp_ = nullptr;
  bool monotonic_ = false;
  int fd_ = -1;
  std::array<std::uint8_t, 256> part_{};  // beginning of a scan that has not come whole
  std::size_t part_size_ = 0;
};

}  // namespace sinew::hal
