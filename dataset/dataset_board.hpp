#pragma once
#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <string_view>

#include "dataset/dataset_folder.hpp"
#include "hal/board.hpp"
#include "hal/os.hpp"

namespace sinew::dataset {

struct DatasetOptions {
  std::string folder;
  hal::Duration from{0};              // begin this long after the first sample: in mid-flight
  const hal::Clock* clock = nullptr;  // the executor's; in virtual time its ManualClock. Not null
  hal::Os* os = nullptr;              // real time: for the thread that wakes waiting threads; null: virtual time
  std::size_t max_decoded_bytes = std::size_t{256} << 20;  // of images in memory
  hal::Duration tail = std::chrono::milliseconds(10);      // the run ends this long after the last sample
};

/// A board made of a recorded folder: an IMU ("imu" or "imu0") and, if there are images, a camera ("camera" or "cam0").
/// Samples are ready at their stamp; the first sample is ready at the run's start.
///
/// open() decodes the images when they fit into max_decoded_bytes. Else, in virtual time read() decodes (only the
/// executor waits for it), and in real time open() refuses, because a step's thread may not wait for a disk. Rows of an
/// image go to the message in the format of the PNG, mono8 or rgb8.
///     auto board = DatasetBoard::open({.folder = dir, .clock = &clock}, why);
///     ... configure the graph with it ...; (*board)->start();
/// In virtual time the record begins in open() at the clock's time, start() is not needed, and next_grant() grants
/// everything up to the next sample, in the end up to end().
/// Frames:  IMU samples are in the frame of the recorded IMU, taken as base.
/// Thread:  owner; each device on one thread.
/// RT:      devices yes, after start() (but for decoding, see above).
/// Errors:  open(): not_found, bad_data, io, not_supported, bad_argument (nothing left after `from`), each in words in
///          `why`. Look-ups: not_found. Devices: closed after the last sample; bad_data for an image that cannot be
///          decoded, bad_argument for one that does not fit (both are dropped and counted).
class DatasetBoard final : public hal::Board, public hal::GrantSource {
 public:
  static hal::Result<std::unique_ptr<DatasetBoard>> open(const DatasetOptions& options, std::string& why);
  ~DatasetBoard() override;

  hal::Result<hal::Device*> open_sensor(hal::SensorKind kind, std::string_view name) override;
  hal::Result<hal::Camera*> camera(std::string_view name) override;
  hal::Result<hal::Radio*> radio(std::string_view name) override;
  hal::Result<hal::Actuators*> actuators(std::string_view name) override;

  /// Real time: the record begins now. Errors: those of starting a thread.
  hal::Status start();
  hal::Result<hal::Time> next_grant(hal::Time done_to) override;
  /// After start(): when the run is over.
  hal::Time end() const { return at(last_ns_) + options_.tail; }
  /// The dataset's own stamp for a time of this run, for the ground truth. After start().
  std::int64_t dataset_stamp(hal::Time t) const { return t.ns - zero_.ns + origin_ns_; }

  std::size_t imu_samples() const;
  std::size_t images() const;
  /// Images that could not be handed over, and the last reason.
  std::size_t images_lost() const;
  std::string image_problem() const;

 private:
  class Cursor;
  class ImuPlayer;
  class CameraPlayer;

  DatasetBoard(const DatasetOptions& options, DatasetFolder folder);
  hal::Status make_devices(std::string& why);
  hal::Time at(std::int64_t stamp_ns) const { return {zero_.ns + (stamp_ns - origin_ns_)}; }
  void wake_loop();

  DatasetOptions options_;
  DatasetFolder folder_;
  std::int64_t origin_ns_ = 0, last_ns_ = 0;  // dataset stamps: of the run's begin, of the last sample
  hal::Time zero_{};                          // when the run began
  std::atomic<bool> started_{false};          // release after zero_, acquire before its use on device threads
  std::unique_ptr<ImuPlayer> imu_;
  std::unique_ptr<CameraPlayer> camera_;
  hal::WakeWord stop_{0};
  std::unique_ptr<hal::Thread> waker_;
};

}  // namespace sinew::dataset
