#include "hal/linux/camera/v4l2_camera.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

namespace sinew::hal {
namespace {

void copy_rows(std::span<const std::uint8_t> from, std::size_t line, msg::Image& out) noexcept {
  const std::size_t row = out.stride;
  if (row == line) {
    std::memcpy(out.pixels(), from.data(), row * out.height);
  } else {
    for (std::uint32_t y = 0; y < out.height; ++y) std::memcpy(out.row(y), from.data() + y * line, row);
  }
}

}  // namespace

Result<std::unique_ptr<V4l2Camera>> open_v4l2_camera(const CameraSpec& spec, Os& os, std::shared_ptr<FdWatch> watch,
                                                     std::string& why) {
  return V4l2Camera::open(kernel_v4l2_port(), spec, os, std::move(watch), {}, why);
}

Result<std::unique_ptr<V4l2Camera>> V4l2Camera::open(V4l2Port& port, const CameraSpec& spec, Os& os,
                                                     std::shared_ptr<FdWatch> watch, const V4l2CameraOptions& options,
                                                     std::string& why) {
  auto session = V4l2Session::open(port, spec, why);
  if (!session) return session.error();
  std::unique_ptr<V4l2Camera> camera(new V4l2Camera(port, spec, os, std::move(watch), options));
  camera->identity_ = (*session)->identity();
  camera->picture_ = (*session)->picture();
  camera->controls_ = (*session)->controls().list();
  camera->requests_ = std::make_unique<Request[]>(camera->controls_.size());
  camera->adopt(std::move(*session));
  if (!camera->trouble_.empty()) {
    why = camera->trouble_;
    return Error{Errc::io, "camera watch"};
  }
  ThreadOptions thread_options;
  thread_options.name = "camera";
  thread_options.nice = 5;
  auto thread = os.start_thread(thread_options, [c = camera.get()] { c->keep(); });
  if (!thread) {
    why = "no thread for the camera could be started";
    return thread.error();
  }
  camera->keeper_ = std::move(*thread);
  return camera;
}

V4l2Camera::V4l2Camera(V4l2Port& port, CameraSpec spec, Os& os, std::shared_ptr<FdWatch> watch,
                       const V4l2CameraOptions& options)
    : port_(port), spec_(std::move(spec)), os_(os), watch_(std::move(watch)), options_(options) {}

V4l2Camera::~V4l2Camera() {
  stop_.store(true, std::memory_order_release);
  call_keeper();
  keeper_.reset();
  if (session_ && watch_) watch_->remove(session_->fd());
}

void V4l2Camera::call_keeper() noexcept {
  bell_.fetch_add(1, std::memory_order_release);
  os_.wake(bell_);
}

bool V4l2Camera::take_session() noexcept {
  int nobody = kNobody;
  return holder_.compare_exchange_strong(nobody, kReader, std::memory_order_acquire);
}

/// `broken`: errno when the stream must be begun anew.
void V4l2Camera::leave_session(int broken) noexcept {
  if (broken == 0) {
    holder_.store(kNobody, std::memory_order_release);
  } else {
    broken_.store(broken, std::memory_order_relaxed);
    holder_.store(kKeeper, std::memory_order_release);
    call_keeper();
  }
}

Result<bool> V4l2Camera::read(msg::Image& out) noexcept {
  line_.begin_read();
  if (!take_session()) return Error{Errc::closed, "camera", broken_.load(std::memory_order_relaxed)};
  if (session_->lends()) {
    leave_session(0);
    return Error{Errc::not_supported, "camera: its pictures go into lent memory"};
  }
  int broken = 0;
  V4l2Session::Filled filled;
  Result<bool> result = next_frame(filled, broken);
  if (result && *result) {
    result = copy(filled, out);
    if (const int said = session_->give_back(filled.index); said < 0) broken = -said;
  }
  leave_session(broken);
  return result;
}

/// Needs the session: the oldest usable frame. `broken`: errno when the stream must be begun anew.
Result<bool> V4l2Camera::next_frame(V4l2Session::Filled& filled, int& broken) noexcept {
  bool faulty = false;
  for (std::uint32_t i = 0; i < session_->buffers(); ++i) {  // no more than can have waited
    const int taken = session_->take(filled);
    if (taken < 0) {
      broken = -taken;
      return Error{Errc::closed, "VIDIOC_DQBUF", broken};
    }
    if (taken == 0) {
      if (faulty) return Error{Errc::bad_data, "camera frame"};
      return false;
    }
    last_frame_ns_.store(os_.now().ns, std::memory_order_relaxed);
    const bool good = usable(filled);
    if (!good)
      if (const int said = session_->give_back(filled.index); said < 0) broken = -said;
    if (good || broken != 0) {
      line_.keep_ready();  // another one may wait
      return good;
    }
    faulty = true;
  }
  line_.keep_ready();
  return Error{Errc::bad_data, "camera frame"};
}

/// Counts the frame. False: do not hand it on.
bool V4l2Camera::usable(const V4l2Session::Filled& filled) noexcept {
  std::optional<Time> stamp;
  if ((filled.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) stamp = Time{filled.stamp_ns};
  if (!count_.arrived(filled.sequence, stamp)) return false;
  const std::size_t row = std::size_t{picture_.width} * msg::bytes_per_pixel(picture_.format);
  const V4l2Picture& comes = session_->picture();
  const std::size_t least = comes.is_jpeg ? 1 : std::size_t{comes.bytes_per_line} * (picture_.height - 1) + row;
  if ((filled.flags & V4L2_BUF_FLAG_ERROR) == 0 && filled.bytes.size() >= least) return true;
  count_.corrupted();
  return false;
}

/// Fills in everything of an image but its pixels. False: it has no room for them.
bool V4l2Camera::describe(const V4l2Session::Filled& filled, msg::Image& out) noexcept {
  if (!out.format_as(picture_.format, picture_.width, picture_.height)) {
    count_.too_large();
    return false;
  }
  const std::int64_t exposure_ns = exposure_ns_.load(std::memory_order_relaxed);
  out.stamp = middle(filled, exposure_ns);
  out.exposure_ns = exposure_ns;
  out.frame_number = count_.number();
  return true;
}

Result<bool> V4l2Camera::copy(const V4l2Session::Filled& filled, msg::Image& out) noexcept {
  if (!describe(filled, out))
    return Error{Errc::bad_argument, "camera: the topic's images are too small", out.capacity_bytes};
  if (session_->picture().is_jpeg) {
    if (!jpeg_->decode(filled.bytes, out)) {
      count_.corrupted();
      return Error{Errc::bad_data, "camera: a broken JPEG"};
    }
  } else {
    copy_rows(filled.bytes, session_->picture().bytes_per_line, out);
  }
  count_.handed_on();
  last_good_ns_.store(os_.now().ns, std::memory_order_relaxed);
  return true;
}

/// Source:  V4L2 API, "Buffers": V4L2_BUF_FLAG_TSTAMP_SRC_SOE is when the exposure of the frame began, _EOF when its
///          last pixel was received; V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC is CLOCK_MONOTONIC, which is this system's time.
Time V4l2Camera::middle(const V4l2Session::Filled& filled, std::int64_t exposure_ns) noexcept {
  const std::int64_t half = exposure_ns / 2;
  const bool start = (filled.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  const Time stamp{filled.stamp_ns + (start ? half : -half)}, now = os_.now();
  // A frame that is here was exposed before: vivid computes its end of frame ahead by most of a period.
  if ((filled.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC && stamp <= now) return stamp;
  count_.unstamped();
  return now;
}

Status V4l2Camera::request(std::size_t control, double value) noexcept {
  if (control >= controls_.size()) return Error{Errc::bad_argument, "camera control"};
  const CameraControl& c = controls_[control];
  if (c.read_only || !(value >= c.min && value <= c.max)) return Error{Errc::bad_argument, "camera control"};
  const double step = c.step > 1 ? c.step : 1.0;  // tuning hits the nearest value; the largest may be no step
  const double steps = std::min(std::round((value - c.min) / step), std::floor((c.max - c.min) / step));
  requests_[control].value.store(static_cast<AnybodysNumber::value_type>(c.min + steps * step),
                                 std::memory_order_relaxed);
  requests_[control].pending.store(true, std::memory_order_release);
  call_keeper();
  return {};
}

std::optional<CameraControls::Exposure> V4l2Camera::exposure() const {
  const auto time = find("exposure_time_absolute");
  if (!time) return std::nullopt;
  return Exposure{*time, std::chrono::microseconds(100), find("auto_exposure"), V4L2_EXPOSURE_MANUAL};
}

std::optional<std::size_t> V4l2Camera::gain() const {
  const auto gain = find("gain");
  return gain ? gain : find("analogue_gain");
}

}  // namespace sinew::hal
