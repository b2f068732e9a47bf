// The camera's own thread: opens the device again, sets controls, looks for silence. See v4l2_camera.hpp.
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "hal/linux/v4l2_camera.hpp"

namespace sinew::hal {
namespace {

constexpr double kSlow = 0.8;  // of the asked rate: below it people are told
constexpr auto kSilenceWorthSaying = std::chrono::seconds(1);

std::string number(double v) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", v);
  return text;
}

double seconds(Duration d) { return std::chrono::duration<double>(d).count(); }

}  // namespace

void V4l2Camera::keep() noexcept {
  Duration retry = options_.first_retry;
  for (;;) {
    const std::uint32_t seen = bell_.load(std::memory_order_acquire);
    if (stop_.load(std::memory_order_acquire)) return;
    Time next = os_.now() + options_.look_every;
    if (holder_.load(std::memory_order_acquire) == kKeeper) {
      retry = open_again(retry);
      if (holder_.load(std::memory_order_relaxed) == kKeeper) {
        next = os_.now() + retry;
        // Requests do not shorten the wait for a device that is gone: sleep it out.
        while (!stop_.load(std::memory_order_acquire) && os_.now() < next)
          os_.wait(bell_, bell_.load(std::memory_order_acquire), next);
        retry = std::min(retry * 2, options_.longest_retry);
        continue;
      }
    } else {
      retry = options_.first_retry;
      look_after();
      if (holder_.load(std::memory_order_acquire) == kKeeper) continue;  // it was silent for too long
    }
    os_.wait(bell_, seen, next);
  }
}

/// Closes what is broken and tries once. Answers how long to wait when that failed.
Duration V4l2Camera::open_again(Duration retry) {
  if (session_) {
    if (watch_) watch_->remove(session_->fd());
    session_.reset();
  }
  count_.tried();
  set_requested();
  std::string why;
  auto session = V4l2Session::open(port_, spec_, why);
  if (!session) {
    const std::lock_guard lock(mutex_);
    trouble_ = why;
    return retry;
  }
  adopt(std::move(*session));
  return options_.first_retry;
}

/// Makes a session the camera's and lets the reader at it. In open() or by the keeper while it holds the session.
void V4l2Camera::adopt(std::unique_ptr<V4l2Session> session) {
  const std::int64_t exposure_ns = session->controls().exposure_ns(port_, session->fd());
  std::string trouble;
  if (watch_) {
    // Now that buffers are queued and the stream is on: polled before, the kernel would take the reader for one that
    // wants read(2), and say error.
    if (const Status added = watch_->add(session->fd(), line_); !added) {
      trouble = session->path() + ": cannot be watched: " + std::strerror(static_cast<int>(added.error().detail));
    }
  }
  {
    const std::lock_guard lock(mutex_);
    path_ = session->path();
    trouble_ = trouble;
    control_trouble_.clear();
  }
  if (!trouble.empty()) return;
  exposure_ns_.store(exposure_ns, std::memory_order_relaxed);
  last_frame_ns_.store(os_.now().ns, std::memory_order_relaxed);
  session_ = std::move(session);
  count_.stream_begins();
  line_.keep_ready();
  holder_.store(kNobody, std::memory_order_release);
}

/// What was requested becomes what the camera is opened with, and what it has now.
void V4l2Camera::set_requested() {
  V4l2Controls::Wanted wanted;
  for (std::size_t i = 0; i < controls_.size(); ++i) {
    if (!requests_[i].pending.exchange(false, std::memory_order_acquire)) continue;
    wanted[controls_[i].name] = requests_[i].value.load(std::memory_order_relaxed);
  }
  for (const auto& [name, value] : wanted) spec_.controls[name] = value;
  if (wanted.empty() || !session_) return;
  std::string why;
  static_cast<void>(session_->controls().set(port_, session_->fd(), wanted, why));  // `why` has every refusal
  const std::lock_guard lock(mutex_);
  control_trouble_ = why;
}

/// While the reader streams: the controls, the exposure as it is now, and whether anything comes at all.
void V4l2Camera::look_after() {
  set_requested();
  exposure_ns_.store(session_->controls().exposure_ns(port_, session_->fd()), std::memory_order_relaxed);
  Duration patience = options_.restart_after;
  if (picture_.rate_hz > 0) patience = std::max(patience, Duration(static_cast<std::int64_t>(10e9 / picture_.rate_hz)));
  if (silence() < patience) return;
  int nobody = kNobody;
  if (!holder_.compare_exchange_strong(nobody, kKeeper, std::memory_order_acquire)) return;  // it is being read
  broken_.store(ETIMEDOUT, std::memory_order_relaxed);
}

Duration V4l2Camera::silence() const { return os_.now() - Time{last_frame_ns_.load(std::memory_order_relaxed)}; }

std::string V4l2Camera::state() const {
  const std::lock_guard lock(mutex_);
  std::string text = path_ + " ('" + identity_.card + "'): ";
  if (holder_.load(std::memory_order_acquire) == kKeeper) {
    const int broken = broken_.load(std::memory_order_relaxed);
    text += broken == ETIMEDOUT ? "no frame came" : std::string("gone: ") + std::strerror(broken);
    text += "; tried " + std::to_string(stats().tries) + " times to open it again";
    if (!trouble_.empty()) text += "; " + trouble_;
  } else if (silence() > kSilenceWorthSaying && (picture_.rate_hz <= 0 || seconds(silence()) > 3 / picture_.rate_hz)) {
    text += "no frame for " + number(seconds(silence())) + " s";
  } else {
    const double asked = picture_.rate_hz, got = count_.rate_hz() > 0 ? count_.rate_hz() : asked;
    text += got < kSlow * asked ? "slow, " + number(got) + " frames/s of " + number(asked) : "streaming";
    text +=
        " " + std::to_string(picture_.width) + "x" + std::to_string(picture_.height) + " " + v4l2_word(picture_.format);
    if (asked > 0 && got >= kSlow * asked) text += " at " + number(got) + " frames/s";
  }
  text += count_.text();
  if (!control_trouble_.empty()) text += "; " + control_trouble_;
  return text;
}

std::string V4l2Camera::trouble() const {
  const std::lock_guard lock(mutex_);
  std::string text;
  const double asked = picture_.rate_hz;
  if (holder_.load(std::memory_order_acquire) == kKeeper) {
    const int broken = broken_.load(std::memory_order_relaxed);
    text = broken == ETIMEDOUT ? "no frame came, it is opened again" : std::string("gone: ") + std::strerror(broken);
    if (!trouble_.empty()) text += "; " + trouble_;
  } else if (silence() > kSilenceWorthSaying && (asked <= 0 || seconds(silence()) > 3 / asked)) {
    text = "is there, but sends no frames";
  } else if (count_.rate_hz() > 0 && count_.rate_hz() < kSlow * asked) {
    text = "slow: fewer than " + number(kSlow * asked) + " frames/s of " + number(asked);
  }
  if (!control_trouble_.empty()) text += (text.empty() ? "" : "; ") + control_trouble_;
  return text.empty() ? text : path_ + " ('" + identity_.card + "'): " + text;
}

}  // namespace sinew::hal
