#pragma once
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/connectors.hpp"
#include "hal/linux/devices/iio_device.hpp"
#include "hal/linux/devices/iio_join.hpp"
#include "hal/os.hpp"
#include "hal/self_report.hpp"
#include "hal/sensor_queue.hpp"

namespace sinew::hal {

/// Counted since it was opened.
struct IioStats {
  std::uint64_t samples = 0, lost = 0;  // handed over; met a full queue
  std::uint64_t bad = 0;                // stamps that went back, raw files without a number
  std::uint64_t unjoined = 0;           // gyroscope samples without accelerometer samples around them
  std::uint64_t restarts = 0;           // it was gone and came back
};

/// How the thread that reads the device runs, and how it comes back.
struct IioOptions {
  ThreadOptions thread{.name = "iio", .fifo_priority = 0, .cpus = {}, .nice = 0};
  Duration retry_first = std::chrono::milliseconds(50), retry_most = std::chrono::seconds(2);
  Duration silent_after = std::chrono::seconds(1);  // after so long without samples trouble() says so
};

/// An IMU behind the kernel's IIO as a board's device: one IIO device with accelerometer and gyroscope, or two
/// Unless the spec says which, it is read from its buffer. A device without a buffer, or whose buffer does not start
/// for want of a trigger, is polled at rate_hz; shortfall() says so with the reason. The choice is made at the opening,
/// and stays for a device that comes back.
/// Stamps:  the kernel's (current_timestamp_clock = monotonic); the time of reading for a device without stamps, with
///          another clock, or polled.
/// Frames:  as the mount matrix has them, or the chip's own.
/// Thread:  reads on a thread of its own.   RT: read() yes.
/// Errors:  read(): closed while the device is gone; it is looked for again with growing pauses, up to retry_most.
class IioImu final : public SensorQueue<msg::ImuSample>, public SelfReport {
 public:
  /// Errors:  those of opening, with words in `why`.
  static Result<std::unique_ptr<IioImu>> open(Os& os, const IioSpec& spec, std::string& why, IioOptions options = {});
  ~IioImu() override;

  IioStats stats() const;
  /// What is wrong now, in words; empty: nothing.
  std::string trouble() const override { return trouble_.get(); }
  /// Also says that the device is polled because it could not be buffered. Does not change any more.
  std::string shortfall() const override;

 private:
  IioImu(Os& os, const IioSpec& spec, IioOptions options);
  /// In the way that open() chose; the first time, tries both.
  Status connect(std::string& why);
  Status connect_as(bool buffered, std::string& why);
  void run() noexcept;
  void retry() noexcept;
  /// Sleeps until there is data; false: stop.
  bool wait(Time deadline) noexcept;
  Status read_all() noexcept;
  Status read_buffer(std::size_t device) noexcept;
  Status poll_all() noexcept;
  void take(std::size_t device, Time stamp, const std::array<double, 3>* raw) noexcept;
  Time checked(std::size_t device, std::int64_t stamp_ns, Time now) noexcept;

  Os& os_;
  const IioSpec spec_;
  const IioOptions options_;
  std::optional<bool> buffered_;                     // empty until the first connect()
  std::string polled_because_;                       // empty: not polled, or polling was asked for
  std::vector<std::unique_ptr<IioDevice>> devices_;  // one, or accelerometer and gyroscope
  std::vector<Time> last_;
  IioJoin join_;
  std::vector<std::uint8_t> space_;
  TroubleText trouble_;
  Tally bad_, restarts_;
  Wide<std::uint64_t> unjoined_;
  Time next_poll_, heard_;
  bool silent_told_ = false, clock_told_ = false, repeats_told_ = false;
  Time doubted_;  // when a stamp was last unusable
  int stop_ = -1;
  std::unique_ptr<Thread> thread_;
};

/// The opener for hal::Connectors. `why` has errors in words.
Result<std::unique_ptr<Imu>> open_iio_imu(Os& os, const IioSpec& spec, std::string& why);

}  // namespace sinew::hal
