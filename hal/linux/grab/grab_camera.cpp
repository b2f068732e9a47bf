#include "hal/linux/grab/grab_camera.hpp"

#include <algorithm>

#include "hal/linux/grab/grab_session.hpp"

namespace sinew::hal {
namespace {

using namespace std::chrono_literals;

constexpr Duration kSeekEvery = 200ms;
constexpr Duration kLookEvery = 200ms;      // whether it should stop, and whether the session is there
constexpr Duration kHandOverPause = 200us;  // until a read() ends
constexpr Duration kSilenceWorthSaying = 2s;
constexpr int kPriority = 88;  // above the loops that wait for a picture, as an IIO device's thread

}  // namespace

Result<std::unique_ptr<Camera>> GrabCamera::open(const GrabSpec& spec, Os& os, std::string& why) {
  if (const auto path = grab_socket_path(spec.name, why); !path) return path.error();
  std::unique_ptr<GrabCamera> camera(new GrabCamera(spec, os));
  camera->pixels_.reserve(spec.width, spec.height);
  ThreadOptions options;
  options.name = "grab", options.fifo_priority = kPriority, options.stack_bytes = std::size_t{128} * 1024;
  auto thread = os.start_thread(options, [c = camera.get()] { c->run(); });
  if (!thread) {
    why = "no thread for the camera could be started";
    return thread.error();
  }
  camera->thread_ = std::move(*thread);
  return std::unique_ptr<Camera>(std::move(camera));
}

GrabCamera::~GrabCamera() {
  stop_.store(1, std::memory_order_release);
  os_.wake(stop_);
  if (thread_) thread_->join();
}

/// Needs the view. kNoNumber: any, or with a title none.
std::uint32_t GrabCamera::wanted_window() const noexcept {
  if (!spec_.title.empty()) return view_->titled(spec_.title).window;
  return spec_.window < 0 ? GrabView::kAnyWindow : static_cast<std::uint32_t>(spec_.window);
}

/// The thread's: looks whether another window has the title now, and says when none has. Titles come after their
/// windows and change; a window that is gone answers no request.
void GrabCamera::follow_title() {
  int nobody = kNobody;
  if (spec_.title.empty() || !holder_.compare_exchange_strong(nobody, kKeeper, std::memory_order_acquire)) return;
  const TitledWindow found = view_->titled(spec_.title);
  if (found.window == grab::kNoNumber) {
    const std::string all = titles_of(view_->windows());
    untitled_.set(found.count == 0 ? "no window has '" + spec_.title + "' in its title; there are: " + all
                                   : "several windows have '" + spec_.title + "' in their titles: " + all);
  } else {
    ask_next(os_.now());
  }
  holder_.store(kNobody, std::memory_order_release);
}

/// Needs the view. One request a period, at most two open.
void GrabCamera::ask_next(Time now) noexcept {
  const Duration period{spec_.rate_hz > 0 ? static_cast<std::int64_t>(1e9 / spec_.rate_hz) : 0};
  const std::uint32_t window = wanted_window();
  if (!spec_.title.empty()) {
    has_titled_.store(window != grab::kNoNumber, std::memory_order_relaxed);
    if (window == grab::kNoNumber) return;  // follow_title() asks when there is one
    view_->point_at(window);                // what was asked of the window that had the title before
  }
  while (view_->open_asks() < grab::kSlots) {
    // A program that stood still for a while owes no pictures.
    due_ = period > Duration{0} ? std::max(due_ + period, now - period) : Time{0};
    view_->ask(window, {spec_.x, spec_.y, spec_.region_width, spec_.region_height}, due_);
  }
}

// ---- the robot's threads

Result<bool> GrabCamera::read(msg::Image& out) noexcept {
  line_.begin_read();
  int nobody = kNobody;
  if (!holder_.compare_exchange_strong(nobody, kReader, std::memory_order_acquire))
    return Error{Errc::closed, "grabbed program"};
  Result<bool> result = false;
  if (const auto picture = view_->oldest()) {
    result = take_over(*picture, out);
    view_->take();
    line_.keep_ready();  // another one may wait
  }
  ask_next(os_.now());
  holder_.store(kNobody, std::memory_order_release);
  return result;
}

Result<bool> GrabCamera::take_over(const GrabPicture& picture, msg::Image& out) noexcept {
  last_ns_.store(os_.now().ns);
  const std::uint32_t number = number_++;
  last_status_.store(static_cast<std::uint32_t>(picture.status), std::memory_order_relaxed);
  if (picture.status != grab::AnswerStatus::ok) {
    refused_.add();
    return Error{Errc::bad_data, "a grabbed picture", static_cast<std::int64_t>(picture.status)};
  }
  if (last_width_ != 0 && (picture.window_width != last_width_ || picture.window_height != last_height_))
    resized_.add();
  last_width_ = picture.window_width, last_height_ = picture.window_height;
  if (!out.format_as(spec_.format, spec_.width, spec_.height)) {
    refused_.add();
    return Error{Errc::bad_argument, "camera: the topic's images are too small", out.capacity_bytes};
  }
  pixels_.convert(picture, {spec_.x, spec_.y, spec_.region_width, spec_.region_height}, out);
  out.stamp = std::min(picture.shown, os_.now());
  out.exposure_ns = 0;
  out.frame_number = number;
  pictures_.add();
  return true;
}

// ---- its own thread

void GrabCamera::run() noexcept {
  bool before = false;
  while (stop_.load(std::memory_order_acquire) == 0) {
    if (!view_) {
      if (!connect_now()) {
        os_.wait(stop_, 0, os_.now() + kSeekEvery);
        continue;
      }
      if (before) restarts_.add();
      before = true;
    }
    view_->wait(os_.now() + kLookEvery);
    if (view_->has_come()) {
      line_.ring();
      // Until it is taken there is nothing to wait for.
      while (view_->has_come() && view_->open_asks() >= 1 && stop_.load(std::memory_order_acquire) == 0 &&
             line_.ready())
        os_.wait(stop_, 0, os_.now() + 1ms);
    } else if (!view_->is_connected()) {
      lose();
    } else {
      follow_title();
    }
  }
}

bool GrabCamera::connect_now() {
  std::string why;
  auto view = GrabView::open(spec_.name, why);
  if (!view) {
    missing_.set(why);
    return false;
  }
  missing_.set({}), untitled_.set({});
  view_ = std::move(*view);
  due_ = os_.now();
  last_ns_.store(os_.now().ns);
  ask_next(os_.now());
  connected_.store(true, std::memory_order_relaxed);
  holder_.store(kNobody, std::memory_order_release);
  return true;
}

void GrabCamera::lose() {
  int nobody = kNobody;
  while (!holder_.compare_exchange_strong(nobody, kKeeper, std::memory_order_acquire)) {
    nobody = kNobody;
    os_.sleep_until(os_.now() + kHandOverPause);
  }
  connected_.store(false, std::memory_order_relaxed);
  view_.reset();
}

GrabStats GrabCamera::stats() const {
  return {pictures_.value(), refused_.value(), resized_.value(), restarts_.value()};
}

std::string GrabCamera::trouble() const {
  const std::string camera = "grabbed program '" + spec_.name + "': ";
  if (!connected_.load(std::memory_order_relaxed)) {
    const std::string why = missing_.get();
    return why.empty() ? std::string() : camera + why;
  }
  if (!spec_.title.empty() && !has_titled_.load(std::memory_order_relaxed))
    if (const std::string why = untitled_.get(); !why.empty()) return camera + why;
  const auto status = static_cast<grab::AnswerStatus>(last_status_.load(std::memory_order_relaxed));
  if (const std::string words = words_of(status); !words.empty()) return camera + words;
  if (os_.now() - Time{last_ns_.load()} > kSilenceWorthSaying) return camera + "it shows no pictures";
  return {};
}

}  // namespace sinew::hal
