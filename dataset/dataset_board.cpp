#include "dataset/dataset_board.hpp"

#include <algorithm>
#include <cstring>

#include "hal/wake_slot.hpp"

namespace sinew::dataset {

using hal::Errc;
using hal::Error;
using hal::Time;

/// The shared part of both devices: a place in a list of stamps, and the clock that says which of them are due.
/// Thread:  the device's, but for wake().
class DatasetBoard::Cursor {
 public:
  explicit Cursor(const DatasetBoard& board) : board_(board) {}
  void add(std::int64_t stamp_ns) { stamps_.push_back(stamp_ns); }
  const std::vector<std::int64_t>& stamps() const { return stamps_; }

  Time ready_at() const noexcept {
    if (!board_.started_.load(std::memory_order_acquire) || next_ == stamps_.size()) return hal::kNever;
    return board_.at(stamps_[next_]);
  }
  void set_wake(hal::Wake* wake) noexcept { wake_.change(wake); }
  void wake() noexcept { wake_.ring(); }
  /// Takes the index of the sample that is due; closed after the last one.
  hal::Result<bool> take(std::size_t& index) noexcept {
    if (next_ == stamps_.size()) return Error{Errc::closed, "end of the dataset"};
    if (ready_at() > board_.options_.clock->now()) return false;
    index = next_++;
    return true;
  }
  Time time_of(std::size_t index) const { return board_.at(stamps_[index]); }

 private:
  const DatasetBoard& board_;
  std::vector<std::int64_t> stamps_;
  std::size_t next_ = 0;
  hal::WakeSlot wake_;
};

class DatasetBoard::ImuPlayer final : public hal::Imu {
 public:
  ImuPlayer(const DatasetBoard& board, std::span<const msg::ImuSample> samples) : cursor(board), samples_(samples) {
    for (const auto& s : samples_) cursor.add(s.stamp.ns);
  }
  Time ready_at() const noexcept override { return cursor.ready_at(); }
  void set_wake(hal::Wake* wake) noexcept override { cursor.set_wake(wake); }
  hal::Result<bool> read(msg::ImuSample& out) noexcept override {
    std::size_t i = 0;
    auto taken = cursor.take(i);
    if (!taken || !*taken) return taken;
    out = samples_[i];
    out.stamp = cursor.time_of(i);
    return true;
  }
  Cursor cursor;

 private:
  std::span<const msg::ImuSample> samples_;
};

class DatasetBoard::CameraPlayer final : public hal::Camera {
 public:
  CameraPlayer(const DatasetBoard& board, std::span<const ImageEntry> entries)
      : cursor(board), folder_(board.folder_), entries_(entries) {
    for (const auto& e : entries_) cursor.add(e.stamp_ns);
  }
  /// Decodes all images, if they fit. False, with nothing kept, when they do not.
  hal::Result<bool> decode_ahead(std::size_t max_bytes, std::string& why) {
    std::size_t bytes = 0;
    for (const ImageEntry& entry : entries_) {
      DecodedImage image;
      if (const auto s = folder_.decode(entry, image, why); !s) return s.error();
      bytes += image.pixels.size();
      if (bytes > max_bytes) {
        decoded_.clear();
        return false;
      }
      decoded_.push_back(std::move(image));
    }
    return true;
  }

  Time ready_at() const noexcept override { return cursor.ready_at(); }
  void set_wake(hal::Wake* wake) noexcept override { cursor.set_wake(wake); }
  hal::Result<bool> read(msg::Image& out) noexcept override {
    std::size_t i = 0;
    auto taken = cursor.take(i);
    if (!taken || !*taken) return taken;
    if (!decoded_.empty()) return hand_over(decoded_[i], i, out);
    if (const auto s = folder_.decode(entries_[i], scratch_, problem); !s) {
      ++lost;
      return s.error();
    }
    return hand_over(scratch_, i, out);
  }
  Cursor cursor;
  std::size_t lost = 0;
  std::string problem;

 private:
  hal::Result<bool> hand_over(const DecodedImage& image, std::size_t i, msg::Image& out) noexcept {
    if (!out.format_as(image.format, image.width, image.height)) {
      ++lost;
      problem = "an image does not fit the topic's capacity";
      return Error{Errc::bad_argument, "DatasetBoard: camera", static_cast<std::int64_t>(image.pixels.size())};
    }
    std::memcpy(out.pixels(), image.pixels.data(), image.pixels.size());
    out.stamp = cursor.time_of(i);
    out.frame_number = static_cast<std::uint32_t>(i);
    return true;
  }

  const DatasetFolder& folder_;
  std::span<const ImageEntry> entries_;
  std::vector<DecodedImage> decoded_;  // all, or none
  DecodedImage scratch_;
};

namespace {

template <class T, class Stamp>
std::span<const T> from(const std::vector<T>& all, std::int64_t origin_ns, const Stamp& stamp) {
  const auto first = std::partition_point(all.begin(), all.end(), [&](const T& v) { return stamp(v) < origin_ns; });
  return {first, all.end()};
}

}  // namespace

DatasetBoard::DatasetBoard(const DatasetOptions& options, DatasetFolder folder)
    : options_(options), folder_(std::move(folder)) {}

DatasetBoard::~DatasetBoard() {
  stop_.store(1, std::memory_order_release);
  if (options_.os != nullptr) options_.os->wake(stop_);
}

hal::Result<std::unique_ptr<DatasetBoard>> DatasetBoard::open(const DatasetOptions& options, std::string& why) {
  const char* const where = "DatasetBoard::open";
  if (options.clock == nullptr) {
    why = "no clock";
    return Error{Errc::bad_argument, where};
  }
  auto folder = DatasetFolder::open(options.folder, why);
  if (!folder) return folder.error();
  std::unique_ptr<DatasetBoard> board(new DatasetBoard(options, std::move(*folder)));
  if (const auto s = board->make_devices(why); !s) return s.error();
  if (options.os == nullptr) {
    board->zero_ = options.clock->now();
    board->started_.store(true, std::memory_order_release);
  }
  return board;
}

hal::Status DatasetBoard::make_devices(std::string& why) {
  const auto& [imu, images, image_folder] = folder_;
  std::int64_t first = INT64_MAX;
  if (!imu.empty()) first = imu.front().stamp.ns, last_ns_ = imu.back().stamp.ns;
  if (!images.empty()) {
    first = std::min(first, images.front().stamp_ns);
    last_ns_ = std::max(last_ns_, images.back().stamp_ns);
  }
  origin_ns_ = first + options_.from.count();
  if (options_.from.count() < 0 || origin_ns_ > last_ns_) {
    why = options_.folder + ": begins " + std::to_string(msg::seconds(options_.from)) +
          " s after its first sample, but is " + std::to_string(static_cast<double>(last_ns_ - first) * 1e-9) +
          " s long";
    return Error{Errc::bad_argument, "DatasetBoard::open"};
  }
  if (!imu.empty())
    imu_ = std::make_unique<ImuPlayer>(*this, from(imu, origin_ns_, [](const auto& s) { return s.stamp.ns; }));
  if (images.empty()) return {};
  camera_ = std::make_unique<CameraPlayer>(*this, from(images, origin_ns_, [](const auto& e) { return e.stamp_ns; }));
  const auto fits = camera_->decode_ahead(options_.max_decoded_bytes, why);
  if (!fits) return fits.error();
  if (!*fits && options_.os != nullptr) {
    why = options_.folder + ": " + std::to_string(camera_->cursor.stamps().size()) + " images need more than " +
          std::to_string(options_.max_decoded_bytes >> 20) +
          " MiB decoded; in real time a step cannot wait for decoding: use virtual time, or allow more memory";
    return Error{Errc::not_supported, "DatasetBoard::open"};
  }
  return {};
}

hal::Result<hal::Device*> DatasetBoard::open_sensor(hal::SensorKind kind, std::string_view name) {
  if (kind != hal::SensorKind::imu || !imu_ || (name != "imu" && name != "imu0"))
    return Error{Errc::not_found, "DatasetBoard: a sensor of this kind and name"};
  return imu_.get();
}
hal::Result<hal::Camera*> DatasetBoard::camera(std::string_view name) {
  if (!camera_ || (name != "camera" && name != "cam0")) return Error{Errc::not_found, "DatasetBoard::camera"};
  return camera_.get();
}
hal::Result<hal::Radio*> DatasetBoard::radio(std::string_view) {
  return Error{Errc::not_found, "a recorded folder has no radio"};
}
hal::Result<hal::Actuators*> DatasetBoard::actuators(std::string_view) {
  return Error{Errc::not_found, "DatasetBoard::actuators"};
}

std::size_t DatasetBoard::imu_samples() const { return imu_ ? imu_->cursor.stamps().size() : 0; }
std::size_t DatasetBoard::images() const { return camera_ ? camera_->cursor.stamps().size() : 0; }
std::size_t DatasetBoard::images_lost() const { return camera_ ? camera_->lost : 0; }
std::string DatasetBoard::image_problem() const { return camera_ ? camera_->problem : std::string(); }

hal::Result<Time> DatasetBoard::next_grant(Time done_to) {
  if (done_to >= end()) return Error{Errc::closed, "end of the dataset"};
  Time next = end();
  const std::int64_t done_ns = dataset_stamp(done_to);
  const auto look = [&](const Cursor& cursor) {
    const auto it = std::upper_bound(cursor.stamps().begin(), cursor.stamps().end(), done_ns);
    if (it != cursor.stamps().end()) next = std::min(next, at(*it));
  };
  if (imu_) look(imu_->cursor);
  if (camera_) look(camera_->cursor);
  return next;
}

hal::Status DatasetBoard::start() {
  if (started_.load(std::memory_order_relaxed)) return {};
  zero_ = options_.clock->now();
  started_.store(true, std::memory_order_release);
  auto thread = options_.os->start_thread({"dataset", 0, {}, 64 * 1024}, [this] { wake_loop(); });
  if (!thread) return thread.error();
  waker_ = std::move(*thread);
  return {};
}

/// Wakes the threads that wait for a device when its next sample is due.
void DatasetBoard::wake_loop() {
  std::size_t next_imu = 0, next_image = 0;
  const auto due = [&](const auto& player, std::size_t i) {
    return player && i < player->cursor.stamps().size() ? player->cursor.time_of(i) : hal::kNever;
  };
  while (stop_.load(std::memory_order_acquire) == 0) {
    const Time imu = due(imu_, next_imu), image = due(camera_, next_image), next = std::min(imu, image);
    if (next == hal::kNever) return;
    if (options_.os->now() < next) {
      options_.os->wait(stop_, 0, next);
      continue;
    }
    if (imu == next) imu_->cursor.wake(), ++next_imu;
    if (image == next) camera_->cursor.wake(), ++next_image;
  }
}

}  // namespace sinew::dataset
