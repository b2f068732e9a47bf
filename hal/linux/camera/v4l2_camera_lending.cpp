// The reader's side of lent memory. The keeper begins and ends the streams; see v4l2_camera.hpp.
#include <algorithm>
#include <cerrno>
#include <cstring>

#include "hal/linux/camera/v4l2_camera.hpp"

namespace sinew::hal {
namespace {

bool refuses_memory(int said) { return said == -EINVAL || said == -EFAULT || said == -ENOMEM; }

constexpr Duration kUntilKeeperIsDone = std::chrono::milliseconds(1);

}  // namespace

Result<std::uint32_t> V4l2Camera::begin_lending(std::uint32_t room_bytes, std::string& why) {
  if (!lent_.empty()) {
    why = "what was lent before has not been taken back";
    return Error{Errc::busy, "camera memory"};
  }
  while (!take_session()) {
    if (holder_.load(std::memory_order_acquire) == kKeeper && broken_.load(std::memory_order_relaxed) != 0) {
      why = state();
      return Error{Errc::closed, "camera memory"};
    }
    os_.sleep_until(os_.now() + kUntilKeeperIsDone);
  }
  if (watch_) watch_->remove(session_->fd());
  why.clear();
  const Status begun = session_->begin_lending(spec_, room_bytes, why);
  int broken = 0;
  if (session_->streams() && watch_ && !watch_->add(session_->fd(), line_)) broken = EIO;
  if (!begun && !session_->streams()) broken = EIO;
  lent_count_ = begun ? spec_.buffers : 0;
  lent_.reserve(lent_count_);
  room_bytes_.store(begun ? room_bytes : 0, std::memory_order_relaxed);
  streams_.store(session_->streams(), std::memory_order_relaxed);
  resting_.store(false, std::memory_order_relaxed);
  {
    const std::lock_guard lock(mutex_);
    copies_because_ = why;
    if (!begun) why = path_ + " ('" + identity_.card + "'): " + why;
  }
  line_.keep_ready();
  leave_session(broken);
  call_keeper();  // the keeper rings the reader until memory is there
  if (begun) return lent_count_;
  if (spec_.memory != CameraSpec::Memory::lent) return begun.error();
  why += "; memory = \"userptr\" cannot be had";
  return Error{Errc::bad_argument, "camera memory"};
}

Status V4l2Camera::lend(msg::Image& image) noexcept {
  if (room_bytes_.load(std::memory_order_relaxed) == 0) return Error{Errc::not_supported, "camera memory"};
  if (lent_.size() == lent_count_ || image.capacity_bytes < room_bytes_.load(std::memory_order_relaxed))
    return Error{Errc::bad_argument, "camera memory", static_cast<std::int64_t>(lent_.size())};
  resting_.store(false, std::memory_order_relaxed);
  if (wish_.load(std::memory_order_acquire) == Wish::stop) return Error{Errc::busy, "camera memory"};
  if (!take_session()) return Error{Errc::busy, "camera memory"};
  lent_.push_back(&image);
  const int said = queue_lent();
  if (refuses_memory(said)) {
    lent_.pop_back();
    return cannot_lend(-said);
  }
  leave_session(-said);  // the image counts as lent: the next stream gets it
  return {};
}

/// Needs the session: queues all lent images that are not queued; when all are there, the stream begins. 0 or negative
/// errno.
int V4l2Camera::queue_lent() noexcept {
  if (!lent_.empty()) kernel_has_lent_.store(true, std::memory_order_relaxed);  // published with the session
  if (session_->queued() != lent_.size())
    for (msg::Image* image : lent_)
      if (const int said = session_->lend(image->pixels()); said < 0) return said;
  if (session_->streams() || lent_.size() != lent_count_) return 0;
  wish_.store(Wish::start, std::memory_order_release);
  call_keeper();
  return 0;
}

/// Needs the session: from now on pictures are copied, in a stream that the keeper opens.
Status V4l2Camera::cannot_lend(int error) noexcept {
  room_bytes_.store(0, std::memory_order_relaxed);
  lending_error_.store(error, std::memory_order_relaxed);
  leave_session(error);
  return Error{Errc::not_supported, "VIDIOC_QBUF", error};
}

Result<msg::Image*> V4l2Camera::take_filled() noexcept {
  line_.begin_read();
  if (room_bytes_.load(std::memory_order_relaxed) == 0) return Error{Errc::not_supported, "camera memory"};
  if (!take_session()) {
    const int broken = broken_.load(std::memory_order_relaxed);
    if (broken == 0) return nullptr;  // its stream is beginning
    return Error{Errc::closed, "camera", broken};
  }
  int broken = -queue_lent();  // a stream that was begun anew has no images yet
  if (refuses_memory(-broken)) return cannot_lend(broken).error();
  msg::Image* image = nullptr;
  Result<bool> got = false;
  V4l2Session::Filled filled;
  if (broken == 0 && session_->streams()) got = next_frame(filled, broken);
  if (got && *got) {
    const auto at = std::find_if(lent_.begin(), lent_.end(),
                                 [&](const msg::Image* lent) { return lent->pixels() == filled.bytes.data(); });
    image = *at;  // always found: the session answers only queued memory
    lent_.erase(at);
    static_cast<void>(describe(filled, *image));  // there is room: lend() has checked
    count_.handed_on();
    last_good_ns_.store(os_.now().ns);
  }
  leave_session(broken);
  if (!got) return got.error();
  return image;
}

msg::Image* V4l2Camera::take_back() noexcept {
  resting_.store(true, std::memory_order_relaxed);
  if (lent_.empty()) return nullptr;
  if (kernel_has_lent_.load(std::memory_order_acquire)) {
    if (wish_.exchange(Wish::stop, std::memory_order_acq_rel) != Wish::stop) call_keeper();
    return nullptr;
  }
  msg::Image* image = lent_.back();
  lent_.pop_back();
  return image;
}

void V4l2Camera::stop_lending() noexcept {
  resting_.store(true, std::memory_order_relaxed);
  while (kernel_has_lent_.load(std::memory_order_acquire)) {
    if (take_session()) {
      end_stream();
      leave_session(0);
    } else {
      os_.sleep_until(os_.now() + kUntilKeeperIsDone);  // the keeper starts, stops or closes it
    }
  }
  wish_.store(Wish::none, std::memory_order_relaxed);
}

std::string V4l2Camera::path_of_pixels() const {
  const std::lock_guard lock(mutex_);
  return words_for_pixels();
}

std::string V4l2Camera::words_for_pixels() const {
  if (room_bytes_.load(std::memory_order_relaxed) != 0) return "the driver fills the topic's slots";
  std::string text = "pixels are copied once";
  if (const int error = lending_error_.load(std::memory_order_relaxed); error != 0)
    return text + ": the driver refuses the topic's memory (" + std::strerror(error) + ")";
  return copies_because_.empty() ? text : text + ": " + copies_because_;
}

}  // namespace sinew::hal
