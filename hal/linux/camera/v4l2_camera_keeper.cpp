// The camera's own thread: opens the device again, sets controls, looks for silence. See v4l2_camera.hpp.
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "hal/linux/camera/v4l2_camera.hpp"

namespace sinew::hal {
namespace {

constexpr double kSlow = 0.8;  // of the asked rate: a lower rate is reported
constexpr auto kSilenceWorthSaying = std::chrono::seconds(1);
constexpr auto kAskForMemory = std::chrono::milliseconds(10);  // until the reader has lent enough for a stream
constexpr auto kUntilReadEnds = std::chrono::microseconds(100);

std::string short_number(double v) {
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
        // Requests do not shorten the wait for a device that is gone.
        while (!stop_.load(std::memory_order_acquire) && os_.now() < next)
          os_.wait(bell_, bell_.load(std::memory_order_acquire), next);
        retry = std::min(retry * 2, options_.longest_retry);
        continue;
      }
      next = os_.now();
    } else {
      retry = options_.first_retry;
      look_after();
      if (holder_.load(std::memory_order_acquire) == kKeeper) continue;  // it was silent for too long, or broke
      if (!streams_.load(std::memory_order_relaxed)) {                   // no descriptor wakes the reader now
        line_.ring();
        if (!resting_.load(std::memory_order_relaxed)) next = std::min(next, os_.now() + kAskForMemory);
      }
    }
    os_.wait(bell_, seen, next);
  }
}

/// Closes a broken session and tries once to open it. Answers how long to wait after a failure.
Duration V4l2Camera::open_again(Duration retry) {
  if (session_) {
    if (watch_) watch_->remove(session_->fd());
    session_.reset();
    kernel_has_lent_.store(false, std::memory_order_release);
    wish_.store(Wish::none, std::memory_order_release);  // the wish was about that stream
  }
  count_.tried();
  set_requested();
  std::string why;
  auto session = V4l2Session::open(port_, spec_, why, room_bytes_.load(std::memory_order_relaxed));
  if (!session) {
    const std::lock_guard lock(mutex_);
    trouble_ = why;
    return retry;
  }
  adopt(std::move(*session));
  return options_.first_retry;
}

/// Makes a session the camera's and gives it to the reader. In open(), or by the keeper while it holds the session.
void V4l2Camera::adopt(std::unique_ptr<V4l2Session> session) {
  const std::int64_t exposure_ns = session->controls().exposure_ns(port_, session->fd());
  std::string trouble;
  if (watch_ && session->streams()) {
    // Only now, with buffers queued and the stream on: before that, the kernel would take the poll for a wait for
    // read(2), and report an error.
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
  streams_.store(session->streams(), std::memory_order_relaxed);
  const V4l2Picture& picture = session->picture();
  if (picture.is_jpeg && !jpeg_) jpeg_ = std::make_unique<JpegDecoder>(picture.format, picture.width, picture.height);
  last_good_ns_.store(os_.now().ns, std::memory_order_relaxed);
  session_ = std::move(session);
  const bool again = count_.stream_begins();
  line_.keep_ready();
  broken_.store(0, std::memory_order_relaxed);
  holder_.store(kNobody, std::memory_order_release);
  if (again) count_.reopened();
}

/// Sets requested values, and stores them for the next opening. Values that the device refuses are not stored: they
/// would keep the camera closed when it comes back.
void V4l2Camera::set_requested() {
  V4l2Controls::Wanted wanted, taken;
  std::string beyond;
  bool any = false;
  // Backwards: a caller that asks for an exposure by hand has asked for the mode before it, which has the smaller
  // number.
  for (std::size_t i = controls_.size(); i-- > 0;) {
    if (!requests_[i].pending.exchange(false, std::memory_order_acquire)) continue;
    const V4l2Controls::Wanted one{{controls_[i].name, requests_[i].value.load(std::memory_order_relaxed)}};
    std::string why;  // a camera that came back may have other ranges than the one that was opened
    any = true;
    if (!session_ || session_->controls().check(one, why)) {
      wanted.insert(*one.begin());
    } else {
      beyond += (beyond.empty() ? "" : "; ") + why;
    }
  }
  std::string why;  // collects every refusal
  if (session_) static_cast<void>(session_->controls().set(port_, session_->fd(), wanted, why, &taken));
  for (const auto& [name, value] : session_ ? taken : wanted) spec_.controls[name] = value;
  if (!any || !session_) return;
  if (!beyond.empty()) why += (why.empty() ? "" : "; ") + beyond;
  const std::lock_guard lock(mutex_);
  control_trouble_ = why;
}

/// While the reader streams: checks the controls, the present exposure, and whether frames come.
void V4l2Camera::look_after() {
  set_requested();
  start_or_stop();
  if (holder_.load(std::memory_order_acquire) == kKeeper) return;
  exposure_ns_.store(session_->controls().exposure_ns(port_, session_->fd()), std::memory_order_relaxed);
  Duration patience = options_.restart_after;
  if (picture_.rate_hz > 0) patience = std::max(patience, Duration(static_cast<std::int64_t>(10e9 / picture_.rate_hz)));
  if (silence() < patience || !streams_.load(std::memory_order_relaxed)) return;
  int nobody = kNobody;
  if (!holder_.compare_exchange_strong(nobody, kKeeper, std::memory_order_acquire)) return;  // the reader is reading
  broken_.store(ETIMEDOUT, std::memory_order_relaxed);
}

/// Fulfils the reader's wish to start or stop a stream into lent memory; for some cameras that takes too long for a
/// reader.
void V4l2Camera::start_or_stop() {
  if (wish_.load(std::memory_order_acquire) == Wish::none) return;
  for (int nobody = kNobody; !holder_.compare_exchange_strong(nobody, kKeeper, std::memory_order_acquire);
       nobody = kNobody) {
    if (nobody == kKeeper || stop_.load(std::memory_order_acquire)) return;  // the reader found it broken
    os_.sleep_until(os_.now() + kUntilReadEnds);
  }
  const Wish wish = wish_.exchange(Wish::none, std::memory_order_acq_rel);
  int said = 0;
  if (wish == Wish::start && session_->lends() && !session_->streams()) {
    said = session_->start();
    if (said == 0 && watch_ && !watch_->add(session_->fd(), line_)) said = -EIO;
    last_frame_ns_.store(os_.now().ns, std::memory_order_relaxed);
    last_good_ns_.store(os_.now().ns, std::memory_order_relaxed);
  } else if (wish == Wish::stop && session_->lends()) {
    end_stream();
  }
  streams_.store(session_->streams(), std::memory_order_relaxed);
  broken_.store(-said, std::memory_order_relaxed);
  if (said == 0) holder_.store(kNobody, std::memory_order_release);
}

/// Needs the session: afterwards the kernel uses no lent memory.
void V4l2Camera::end_stream() noexcept {
  if (watch_) watch_->remove(session_->fd());
  session_->stop();
  streams_.store(false, std::memory_order_relaxed);
  kernel_has_lent_.store(false, std::memory_order_release);
}

Duration V4l2Camera::silence() const { return os_.now() - Time{last_frame_ns_.load(std::memory_order_relaxed)}; }

/// How long only faulty frames have come, when that is worth a report; else 0.
Duration V4l2Camera::only_faulty() const {
  const Duration since = os_.now() - Time{last_good_ns_.load(std::memory_order_relaxed)};
  return since > kSilenceWorthSaying && since - silence() > kSilenceWorthSaying / 2 ? since : Duration{0};
}

std::string V4l2Camera::state() const {
  const std::lock_guard lock(mutex_);
  std::string text = path_ + " ('" + identity_.card + "'): ";
  if (holder_.load(std::memory_order_acquire) == kKeeper) {
    const int broken = broken_.load(std::memory_order_relaxed);
    if (broken == 0) {
      text += "begins or ends its stream";
    } else {
      text += broken == ETIMEDOUT ? "no frame came" : std::string("gone: ") + std::strerror(broken);
      text += "; tried " + std::to_string(stats().tries) + " times to open it again";
      if (!trouble_.empty()) text += "; " + trouble_;
    }
  } else if (!streams_.load(std::memory_order_relaxed)) {
    text += "waits for memory to fill";
  } else if (silence() > kSilenceWorthSaying && (picture_.rate_hz <= 0 || seconds(silence()) > 3 / picture_.rate_hz)) {
    text += "no frame for " + short_number(seconds(silence())) + " s";
  } else if (const Duration since = only_faulty(); since > Duration{0}) {
    text += "only faulty frames for " + short_number(seconds(since)) + " s (cable, supply, bandwidth of its bus?)";
  } else {
    const double asked = picture_.rate_hz, got = count_.rate_hz() > 0 ? count_.rate_hz() : asked;
    text += got < kSlow * asked ? "slow, " + short_number(got) + " frames/s of " + short_number(asked) : "streaming";
    text += " " + std::to_string(picture_.width) + "x" + std::to_string(picture_.height) + " " +
            msg::pixel_format_name(picture_.format);
    if (asked > 0 && got >= kSlow * asked) text += " at " + short_number(got) + " frames/s";
  }
  text += "; " + words_for_pixels() + count_.text();
  if (!control_trouble_.empty()) text += "; " + control_trouble_;
  return text;
}

std::string V4l2Camera::trouble() const {
  const std::lock_guard lock(mutex_);
  std::string text;
  const double asked = picture_.rate_hz;
  if (holder_.load(std::memory_order_acquire) == kKeeper) {
    const int broken = broken_.load(std::memory_order_relaxed);
    if (broken != 0)  // otherwise it only begins or ends its stream
      text = broken == ETIMEDOUT ? "no frame came, it is opened again" : std::string("gone: ") + std::strerror(broken);
    if (broken != 0 && !trouble_.empty()) text += "; " + trouble_;
  } else if (!streams_.load(std::memory_order_relaxed)) {
    // it waits for memory to fill: nothing is wrong
  } else if (silence() > kSilenceWorthSaying && (asked <= 0 || seconds(silence()) > 3 / asked)) {
    text = "is there, but sends no frames";
  } else if (only_faulty() > Duration{0}) {
    text = "only faulty frames come (cable, supply, bandwidth of its bus?)";
  } else if (count_.rate_hz() > 0 && count_.rate_hz() < kSlow * asked) {
    text = "slow: fewer than " + short_number(kSlow * asked) + " frames/s of " + short_number(asked);
  }
  if (!control_trouble_.empty()) text += (text.empty() ? "" : "; ") + control_trouble_;
  return text.empty() ? text : path_ + " ('" + identity_.card + "'): " + text;
}

}  // namespace sinew::hal
