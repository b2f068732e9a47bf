#include "hal/linux/libcamera/libcamera_camera.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "hal/linux/libcamera/libcamera_session.hpp"

namespace sinew::hal {
namespace {

using namespace std::chrono_literals;

constexpr Duration kFirstRetry = 100ms, kLongestRetry = 2s, kRestartAfter = 5s, kLookEvery = 500ms,
                   kSilenceWorthSaying = 1s;

}  // namespace

std::vector<std::string> libcamera_names() {
  std::vector<std::string> names;
  if (const auto manager = libcamera_manager())
    for (const auto& camera : manager->cameras()) names.push_back(camera->id());
  return names;
}

Result<std::unique_ptr<LibcameraCamera>> open_libcamera_camera(const CameraSpec& spec, Os& os, std::string& why) {
  return LibcameraCamera::open(spec, os, why);
}

Result<std::unique_ptr<LibcameraCamera>> LibcameraCamera::open(const CameraSpec& spec, Os& os, std::string& why) {
  std::unique_ptr<LibcameraCamera> camera(new LibcameraCamera(spec, os));
  auto session = camera->open_session(why);
  if (!session) return session.error();
  camera->controls_ = (*session)->controls();
  camera->rate_set_ = (*session)->rate_set();
  camera->requests_ = std::make_unique<Request[]>(camera->controls_.size());
  camera->adopt(std::move(*session));
  ThreadOptions options;
  options.name = "libcamera";
  options.nice = 0;  // requests come round on it; it sleeps in between
  auto thread = os.start_thread(options, [c = camera.get()] { c->keep(); });
  if (!thread) {
    why = "no thread for the camera could be started";
    return thread.error();
  }
  camera->keeper_ = std::move(*thread);
  return camera;
}

Result<std::unique_ptr<LibcameraSession>> LibcameraCamera::open_session(std::string& why) {
  return LibcameraSession::open(
      spec_,
      [this] {
        ready_.store(true, std::memory_order_release);
        wake_.ring();
      },
      why);
}

LibcameraCamera::LibcameraCamera(CameraSpec spec, Os& os) : spec_(std::move(spec)), os_(os) {}

LibcameraCamera::~LibcameraCamera() {
  stop_.store(true, std::memory_order_release);
  call_keeper();
  keeper_.reset();
  session_.reset();  // while the object that its thread rings still exists
}

void LibcameraCamera::call_keeper() noexcept {
  bell_.fetch_add(1, std::memory_order_release);
  os_.wake(bell_);
}

Result<bool> LibcameraCamera::read(msg::Image& out) noexcept {
  ready_.exchange(false, std::memory_order_acq_rel);
  int nobody = kNobody;
  if (!holder_.compare_exchange_strong(nobody, kReader, std::memory_order_acquire))
    return Error{Errc::closed, "camera", ENODEV};
  const bool gone = session_->gone();
  const Result<bool> result = gone ? Error{Errc::closed, "camera", ENODEV} : read_held(out);
  holder_.store(gone ? kKeeper : kNobody, std::memory_order_release);
  if (gone || !result || *result) call_keeper();  // to send requests round again, or to look for the camera
  return result;
}

Result<bool> LibcameraCamera::read_held(msg::Image& out) noexcept {
  LibcameraSession::Frame frame;
  if (!session_->take(frame)) return false;
  ready_.store(true, std::memory_order_release);  // another one may wait
  last_frame_ns_.store(os_.now().ns, std::memory_order_relaxed);
  const auto stamp = frame.stamp_ns > 0 ? std::optional(Time{frame.stamp_ns}) : std::nullopt;
  Result<bool> result = true;
  if (!count_.arrived(frame.sequence, stamp)) {
    result = Error{Errc::bad_data, "camera frame"};
  } else if (!frame.good) {
    count_.corrupted();
    result = Error{Errc::bad_data, "camera frame"};
  } else if (!out.format_as(spec_.format, spec_.width, spec_.height)) {
    count_.too_large();
    result = Error{Errc::bad_argument, "camera: the topic's images are too small", out.capacity_bytes};
  }
  if (result) {
    const Time middle{frame.stamp_ns + frame.exposure_ns / 2}, now = os_.now();
    const bool usable = stamp && middle <= now;
    if (!usable) count_.unstamped();
    out.stamp = usable ? middle : now;
    out.exposure_ns = frame.exposure_ns;
    out.frame_number = count_.number();
    session_->begin_access(frame.request);
    const std::size_t row = out.stride, line = session_->stride();
    if (row == line) {
      std::memcpy(out.pixels(), frame.bytes.data(), row * out.height);
    } else {
      for (std::uint32_t y = 0; y < out.height; ++y) std::memcpy(out.row(y), frame.bytes.data() + y * line, row);
    }
    session_->end_access(frame.request);
    count_.handed_on();
  }
  session_->give_back(frame.request);
  return result;
}

Status LibcameraCamera::request(std::size_t control, double value) noexcept {
  if (control >= controls_.size()) return Error{Errc::bad_argument, "camera control"};
  const CameraControl& c = controls_[control];
  if (!(value >= c.min && value <= c.max)) return Error{Errc::bad_argument, "camera control"};
  requests_[control].value.store(static_cast<AnybodysNumber::value_type>(c.step >= 1 ? std::round(value) : value),
                                 std::memory_order_relaxed);
  requests_[control].pending.store(true, std::memory_order_release);
  call_keeper();
  return {};
}

std::optional<CameraControls::Exposure> LibcameraCamera::exposure() const {
  const auto at = find("ExposureTime");
  if (!at) return std::nullopt;
  return Exposure{*at, std::chrono::microseconds(1), find("AeEnable"), 0};
}

void LibcameraCamera::adopt(std::unique_ptr<LibcameraSession> session) {
  {
    const std::lock_guard lock(mutex_);
    trouble_.clear();
  }
  session_ = std::move(session);
  const bool again = count_.stream_begins();
  last_frame_ns_.store(os_.now().ns, std::memory_order_relaxed);
  holder_.store(kNobody, std::memory_order_release);
  if (again) count_.reopened();
}

void LibcameraCamera::keep() noexcept {
  Duration retry = kFirstRetry;
  for (;;) {
    const std::uint32_t seen = bell_.load(std::memory_order_acquire);
    if (stop_.load(std::memory_order_acquire)) return;
    if (holder_.load(std::memory_order_acquire) != kKeeper) {
      retry = kFirstRetry;
      if (serve()) os_.wait(bell_, seen, os_.now() + kLookEvery);
      continue;
    }
    if (session_ && session_->vanished()) {  // not to be stopped before libcamera knows of it
      {
        const std::lock_guard lock(mutex_);
        trouble_ =
            "the device left, and libcamera has not heard of it (it does of USB cameras, from udevd): start again";
      }
      os_.wait(bell_, seen, os_.now() + kLookEvery);
      continue;
    }
    session_.reset();
    count_.tried();
    std::string why;
    auto session = open_session(why);
    if (session) {
      adopt(std::move(*session));
      continue;
    }
    {
      const std::lock_guard lock(mutex_);
      trouble_ = why;
    }
    const Time next = os_.now() + retry;
    while (!stop_.load(std::memory_order_acquire) && os_.now() < next)
      os_.wait(bell_, bell_.load(std::memory_order_acquire), next);
    retry = std::min(retry * 2, kLongestRetry);
  }
}

/// Sends requests round again, checks controls and silence. False: the session has just become the keeper's.
bool LibcameraCamera::serve() {
  for (std::size_t i = 0; i < controls_.size(); ++i) {
    if (!requests_[i].pending.exchange(false, std::memory_order_acquire)) continue;
    unsent_[controls_[i].name] = requests_[i].value.load(std::memory_order_relaxed);
  }
  for (const auto& [name, value] : unsent_) spec_.controls[name] = value;
  const Status sent = session_->requeue(unsent_);
  const Duration silence = os_.now() - Time{last_frame_ns_.load(std::memory_order_relaxed)};
  const bool vanished = silence > kLookEvery && session_->vanished();
  if (sent && !session_->gone() && !vanished && silence < kRestartAfter) return true;
  int nobody = kNobody;
  if (!holder_.compare_exchange_strong(nobody, kKeeper, std::memory_order_acquire)) return true;  // it is being read
  return false;
}

std::string LibcameraCamera::state() const {
  const std::lock_guard lock(mutex_);
  std::string text = "'" + spec_.path + "': ";
  if (holder_.load(std::memory_order_acquire) == kKeeper) {
    text += "gone";
    if (stats().tries > 0) text += "; tried " + std::to_string(stats().tries) + " times to open it again";
    if (!trouble_.empty()) text += "; " + trouble_;
  } else {
    text += "streaming " + std::to_string(spec_.width) + "x" + std::to_string(spec_.height);
    if (count_.rate_hz() > 0) text += " at " + std::to_string(std::lround(count_.rate_hz())) + " frames/s";
    if (spec_.rate_hz > 0 && !rate_set_) text += " (its rate cannot be set)";
  }
  return text + count_.text();
}

std::string LibcameraCamera::trouble() const {
  const std::lock_guard lock(mutex_);
  const std::string who = "'" + spec_.path + "': ";
  if (holder_.load(std::memory_order_acquire) == kKeeper)
    return who + "gone" + (trouble_.empty() ? "" : "; " + trouble_);
  const Duration silence = os_.now() - Time{last_frame_ns_.load(std::memory_order_relaxed)};
  if (silence > kSilenceWorthSaying && (spec_.rate_hz <= 0 || msg::seconds(silence) > 3 / spec_.rate_hz))
    return who + "is there, but sends no frames";
  return {};
}

}  // namespace sinew::hal
