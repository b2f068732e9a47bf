// Preloaded into a streamer of others, /dev/video0 is a camera of 640x480 yuyv at 30 Hz that sees what the camera of
// tests/monitor/monitor_robot sees (SINEW_DISCS=1: with --discs): the kernel of a virtual machine often has no V4L2.
// Its buffers hold their pictures from the beginning, so that the device itself costs the streamer nothing.
#include <dlfcn.h>
#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdarg>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <mutex>

#include "camera_scene.hpp"

namespace {

constexpr const char* kDevice = "/dev/video0";
constexpr unsigned kWidth = 640, kHeight = 480, kHz = 30, kMostBuffers = 32;
constexpr std::size_t kBytes = std::size_t{2} * kWidth * kHeight, kMap = (kBytes + 4095) / 4096 * 4096;

struct Camera {
  std::mutex mutex{};
  int fd = -1;  // a timer: each tick is a picture
  unsigned count = 0, sequence = 0;
  std::deque<unsigned> queue{};
  sinew::bench::NoisySquares squares{};
} camera;

template <class F>
F* the_real(const char* name) {
  return reinterpret_cast<F*>(dlsym(RTLD_NEXT, name));
}
bool is_camera(const char* path) { return path && std::strcmp(path, kDevice) == 0; }
bool is_camera(int fd) { return fd >= 0 && fd == camera.fd; }
int fail(int error) {
  errno = error;
  return -1;
}

int open_camera() {
  const std::lock_guard lock(camera.mutex);
  camera.fd = timerfd_create(CLOCK_MONOTONIC, 0);
  camera.count = 0;
  camera.queue.clear();
  return camera.fd;
}

void fill(v4l2_format& format) {
  format.fmt.pix = {};
  auto& pix = format.fmt.pix;
  pix.width = kWidth, pix.height = kHeight, pix.pixelformat = V4L2_PIX_FMT_YUYV, pix.field = V4L2_FIELD_NONE;
  pix.bytesperline = 2 * kWidth, pix.sizeimage = kBytes, pix.colorspace = V4L2_COLORSPACE_SRGB;
}

int dequeue(v4l2_buffer& buffer) {
  std::uint64_t ticks = 0;
  if (read(camera.fd, &ticks, sizeof ticks) != sizeof ticks) return -1;
  const std::lock_guard lock(camera.mutex);
  if (camera.queue.empty()) return fail(EAGAIN);
  buffer.index = camera.queue.front(), buffer.bytesused = kBytes, buffer.field = V4L2_FIELD_NONE;
  buffer.flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC, buffer.sequence = camera.sequence++;
  buffer.length = kMap, buffer.memory = V4L2_MEMORY_MMAP;
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  buffer.timestamp = {now.tv_sec, now.tv_nsec / 1000};
  camera.queue.pop_front();
  return 0;
}

int control(unsigned long request, void* argument) {
  // Callers that hold it in an int extend its sign.
  switch (static_cast<std::uint32_t>(request)) {
    case VIDIOC_QUERYCAP: {
      v4l2_capability& c = *static_cast<v4l2_capability*>(argument);
      c = {};
      std::memcpy(c.driver, "stand-in", 9), std::memcpy(c.card, "stand-in", 9), std::memcpy(c.bus_info, "none", 5);
      c.device_caps = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
      c.capabilities = c.device_caps | V4L2_CAP_DEVICE_CAPS;
      return 0;
    }
    case VIDIOC_ENUM_FMT: {
      v4l2_fmtdesc& f = *static_cast<v4l2_fmtdesc*>(argument);
      if (f.index > 0) return fail(EINVAL);
      f.pixelformat = V4L2_PIX_FMT_YUYV, f.flags = 0;
      std::memcpy(f.description, "yuyv", 5);
      return 0;
    }
    case VIDIOC_G_FMT:
    case VIDIOC_S_FMT:
    case VIDIOC_TRY_FMT:
      fill(*static_cast<v4l2_format*>(argument));
      return 0;
    case VIDIOC_G_PARM:
    case VIDIOC_S_PARM: {
      auto& capture = static_cast<v4l2_streamparm*>(argument)->parm.capture;
      capture.capability = V4L2_CAP_TIMEPERFRAME, capture.timeperframe = {1, kHz};
      return 0;
    }
    case VIDIOC_ENUMINPUT: {
      v4l2_input& input = *static_cast<v4l2_input*>(argument);
      if (input.index > 0) return fail(EINVAL);
      input.type = V4L2_INPUT_TYPE_CAMERA, input.status = 0;
      std::memcpy(input.name, "stand-in", 9);
      return 0;
    }
    case VIDIOC_G_INPUT:
      *static_cast<int*>(argument) = 0;
      return 0;
    case VIDIOC_S_INPUT:
      return 0;
    case VIDIOC_REQBUFS: {
      v4l2_requestbuffers& wanted = *static_cast<v4l2_requestbuffers*>(argument);
      if (wanted.memory != V4L2_MEMORY_MMAP) return fail(EINVAL);
      camera.count = wanted.count = std::min(wanted.count, kMostBuffers);
      camera.queue.clear();
      return 0;
    }
    case VIDIOC_QUERYBUF: {
      v4l2_buffer& buffer = *static_cast<v4l2_buffer*>(argument);
      if (buffer.index >= camera.count) return fail(EINVAL);
      buffer.length = kMap, buffer.m.offset = static_cast<std::uint32_t>(buffer.index * kMap);
      buffer.flags = 0, buffer.memory = V4L2_MEMORY_MMAP;
      return 0;
    }
    case VIDIOC_QBUF: {
      const std::lock_guard lock(camera.mutex);
      const unsigned index = static_cast<v4l2_buffer*>(argument)->index;
      if (index >= camera.count) return fail(EINVAL);
      camera.queue.push_back(index);
      return 0;
    }
    case VIDIOC_DQBUF:
      return dequeue(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_STREAMON:
    case VIDIOC_STREAMOFF: {
      itimerspec tick{};
      if (static_cast<std::uint32_t>(request) == VIDIOC_STREAMON)
        tick.it_interval.tv_nsec = 1'000'000'000 / kHz, tick.it_value.tv_nsec = 1'000'000;
      return timerfd_settime(camera.fd, 0, &tick, nullptr);
    }
    default:
      return fail(EINVAL);  // controls, and what else a camera need not have
  }
}

void* map_buffer(std::size_t index) {
  auto* const real = the_real<void*(void*, std::size_t, int, int, int, off_t)>("mmap");
  void* const memory = real(nullptr, kMap, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
  if (memory == MAP_FAILED || index >= kMostBuffers) return memory;
  auto* const pixels = static_cast<std::uint8_t*>(memory);
  const auto number = static_cast<std::uint32_t>(index);
  if (std::getenv("SINEW_DISCS")) {
    static const sinew::bench::ShadedDiscs discs(kWidth, kHeight);
    std::copy(discs.picture(number).begin(), discs.picture(number).end(), pixels);
  } else {
    camera.squares.paint(number, kWidth, kHeight,
                         [pixels](std::uint32_t y) { return pixels + std::size_t{2} * kWidth * y; });
  }
  return memory;
}

}  // namespace

extern "C" {
int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = va_arg(more, mode_t);
  va_end(more);
  return is_camera(path) ? open_camera() : the_real<int(const char*, int, ...)>("open")(path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = va_arg(more, mode_t);
  va_end(more);
  return is_camera(path) ? open_camera() : the_real<int(const char*, int, ...)>("open64")(path, flags, mode);
}
int __open_2(const char* path, int flags) {
  return is_camera(path) ? open_camera() : the_real<int(const char*, int)>("__open_2")(path, flags);
}
int __open64_2(const char* path, int flags) {
  return is_camera(path) ? open_camera() : the_real<int(const char*, int)>("__open64_2")(path, flags);
}
int access(const char* path, int mode) {
  return is_camera(path) ? 0 : the_real<int(const char*, int)>("access")(path, mode);
}
int stat(const char* path, struct stat* about) {
  if (!is_camera(path)) return the_real<int(const char*, struct stat*)>("stat")(path, about);
  *about = {};
  about->st_mode = S_IFCHR | 0600, about->st_rdev = 81 << 8;
  return 0;
}
int ioctl(int fd, unsigned long request, ...) {
  va_list more;
  va_start(more, request);
  void* const argument = va_arg(more, void*);
  va_end(more);
  if (is_camera(fd)) return control(request, argument);
  return the_real<int(int, unsigned long, void*)>("ioctl")(fd, request, argument);
}
void* mmap(void* at, size_t bytes, int protection, int flags, int fd, off_t offset) {
  if (is_camera(fd)) return map_buffer(static_cast<std::size_t>(offset) / kMap);
  return the_real<void*(void*, size_t, int, int, int, off_t)>("mmap")(at, bytes, protection, flags, fd, offset);
}
void* mmap64(void* at, size_t bytes, int protection, int flags, int fd, off_t offset) {
  return mmap(at, bytes, protection, flags, fd, offset);
}
int close(int fd) {
  if (is_camera(fd)) camera.fd = -1;
  return the_real<int(int)>("close")(fd);
}
}
