// Pictures into memory of the caller: V4L2_MEMORY_USERPTR. See v4l2_session.hpp.
// Source:  Linux Media Infrastructure userspace API, part I, 3.3 Streaming I/O (User Pointers), VIDIOC_REQBUFS,
//          VIDIOC_QBUF; kernel 6.1, drivers/media/common/videobuf2: memory is pinned at the first VIDIOC_QBUF of an
//          index and stays so while that index comes with the same pointer and length.
#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "hal/linux/camera/v4l2_session.hpp"

namespace sinew::hal {
namespace {

constexpr std::uint32_t kMostLent = 32;  // VIDEO_MAX_FRAME
// Offset of a slot's pixels within its 64 bytes: too little alignment for some drivers.
constexpr std::size_t kSlotAlignment = 64, kPixelsAt = sizeof(msg::Image) % kSlotAlignment;

}  // namespace

/// Checks that pictures can be right in lent memory: no row is moved, none is decoded.
Status V4l2Session::may_lend(const CameraSpec& spec, std::uint32_t room_bytes, std::string& why) const {
  const std::uint32_t row = picture_.width * msg::bytes_per_pixel(picture_.format);
  if (spec.memory == CameraSpec::Memory::mapped)
    why = "memory = \"mmap\"";
  else if (picture_.is_jpeg)
    why = "the camera has this picture as MJPEG only, which is decoded";
  else if (picture_.bytes_per_line != row)
    why = "the driver's rows are " + std::to_string(picture_.bytes_per_line) + " bytes long, an image's " +
          std::to_string(row);
  else if (picture_.image_bytes > room_bytes)
    why = "the driver wants " + std::to_string(picture_.image_bytes) +
          " bytes for a picture, the topic's images have " + std::to_string(room_bytes);
  else
    return {};
  return Error{Errc::not_supported, "camera memory", room_bytes};
}

Status V4l2Session::begin_lending(const CameraSpec& spec, std::uint32_t room_bytes, std::string& why) {
  if (const Status may = may_lend(spec, room_bytes, why); !may) return may;
  if (streaming_) stop();
  end_mapping();
  lends_ = true;
  const Status taken = take_user_pointers(spec.buffers, why);
  if (taken) return {};
  stop();
  std::uint32_t none = 0;
  request_buffers(V4L2_MEMORY_USERPTR, none);
  memory_.clear(), is_queued_.clear();
  lends_ = false;
  std::string trouble;
  if (const Status started = start_stream(spec.buffers, trouble); !started) why += "; " + trouble;
  return taken;
}

Status V4l2Session::take_user_pointers(std::uint32_t buffers, std::string& why) {
  const auto refused = [&](const char* what, int said) {
    why = std::string("the driver does not take memory of the caller (") + what + ": " + std::strerror(-said) + ")";
    return Error{said == -ENODEV ? Errc::closed : Errc::not_supported, what, -said};
  };
  std::uint32_t none = 0;
  request_buffers(V4L2_MEMORY_MMAP, none);  // frees the mapped ones; none on a device just opened
  std::uint32_t fewest = buffers;
  if (const int said = request_buffers(V4L2_MEMORY_USERPTR, fewest); said < 0) return refused("VIDIOC_REQBUFS", said);
  if (fewest > buffers) {
    why = "the driver works on " + std::to_string(fewest) + " buffers at least: buffers = " + std::to_string(fewest);
    return Error{Errc::not_supported, "VIDIOC_REQBUFS", fewest};
  }
  memory_.assign(fewest, {});
  is_queued_.assign(fewest, false);
  if (const int said = try_memory(); said < 0) return refused("VIDIOC_QBUF", said);
  // An index for every piece of memory, as far as there are any: then each piece is pinned only once. Unused indices
  // cost nothing.
  std::uint32_t count = kMostLent;
  if (const int said = request_buffers(V4L2_MEMORY_USERPTR, count); said < 0) return refused("VIDIOC_REQBUFS", said);
  memory_.assign(std::clamp(count, buffers, kMostLent), {});
  is_queued_.assign(memory_.size(), false);
  queued_ = 0;
  return {};
}

/// Queues a piece of memory with the alignment of a slot's pixels, and takes it out again.
int V4l2Session::try_memory() {
  std::vector<std::uint8_t> memory(picture_.image_bytes + 2 * kSlotAlignment);
  const std::size_t beyond = reinterpret_cast<std::uintptr_t>(memory.data()) % kSlotAlignment;
  const int said = lend(memory.data() + (kSlotAlignment - beyond) + kPixelsAt);
  stop();
  std::uint32_t none = 0;
  request_buffers(V4L2_MEMORY_USERPTR, none);
  return said;
}

int V4l2Session::lend(std::uint8_t* memory) noexcept {
  std::size_t at = memory_.size();
  for (std::size_t i = 0; i < memory_.size(); ++i) {
    if (memory_[i].data() == memory) {
      if (is_queued_[i]) return 0;
      at = i;
      break;
    }
    // The first index that was never used; if there is none, an index that is not in use.
    const bool better = at == memory_.size() || (memory_[i].data() == nullptr && memory_[at].data() != nullptr);
    if (!is_queued_[i] && better) at = i;
  }
  if (at == memory_.size()) return -ENOBUFS;
  memory_[at] = {memory, picture_.image_bytes};
  return queue(static_cast<std::uint32_t>(at));
}

int V4l2Session::queue(std::uint32_t index) noexcept {
  v4l2_buffer buffer;
  std::memset(&buffer, 0, sizeof buffer);
  buffer.index = index, buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE, buffer.memory = V4L2_MEMORY_USERPTR;
  buffer.m.userptr = reinterpret_cast<unsigned long>(memory_[index].data());
  buffer.length = static_cast<std::uint32_t>(memory_[index].size());
  const int said = port_.ioctl(fd_, VIDIOC_QBUF, &buffer);
  if (said < 0) return said;
  is_queued_[index] = true, ++queued_;
  return 0;
}

}  // namespace sinew::hal
