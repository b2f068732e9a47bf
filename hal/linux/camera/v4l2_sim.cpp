#include "hal/linux/camera/v4l2_sim.hpp"

#include <fcntl.h>
#include <linux/videodev2.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "hal/linux/camera/v4l2_format.hpp"

namespace sinew::hal {
namespace {

constexpr std::uint32_t kMostSimBuffers = 8, kMostUserBuffers = 32;

}  // namespace

V4l2SimCamera::V4l2SimCamera()
    : offers{{v4l2_code(msg::PixelFormat::yuyv), "YUYV 4:2:2", {{640, 480}, {320, 240}}, {30, 15}},
             {V4L2_PIX_FMT_MJPEG, "Motion-JPEG", {{1280, 720}}, {30}}},
      controls{{V4L2_CID_GAIN, V4L2_CTRL_TYPE_INTEGER, "Gain", 0, 100, 1, 20},
               {V4L2_CID_EXPOSURE_AUTO, V4L2_CTRL_TYPE_MENU, "Auto Exposure", 0, 3, 1, 3},
               {V4L2_CID_EXPOSURE_ABSOLUTE, V4L2_CTRL_TYPE_INTEGER, "Exposure Time, Absolute", 1, 5000, 1, 156}},
      capabilities(V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING),
      stamp_flags(V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE) {}

V4l2Sim::V4l2Sim(V4l2SimCamera camera) : camera_(std::move(camera)) {}

V4l2Sim::~V4l2Sim() {
  for (auto& [fd, file] : files_) {
    ::close(fd);
    if (file.pipe_in >= 0) ::close(file.pipe_in);
  }
}

// ---- the world's side

V4l2Sim::File* V4l2Sim::streaming() {
  for (auto& [fd, file] : files_)
    if (file.streaming && !file.gone) return &file;
  return nullptr;
}

bool V4l2Sim::deliver(const msg::Image& picture, Time stamp) {
  return deliver(
      [&picture](const File& file, std::uint8_t* memory, std::uint32_t room) -> std::uint32_t {
        if (v4l2_code(picture.format) != file.code || picture.width != file.width || picture.height != file.height)
          return 0;
        const std::uint32_t row = picture.width * msg::bytes_per_pixel(picture.format);
        for (std::uint32_t y = 0; y < picture.height; ++y)
          std::memcpy(memory + std::size_t{y} * file.line, picture.row(y), row);
        return room;
      },
      stamp);
}

bool V4l2Sim::deliver_jpeg(std::span<const std::uint8_t> jpeg, Time stamp) {
  return deliver(
      [jpeg](const File& file, std::uint8_t* memory, std::uint32_t room) -> std::uint32_t {
        if (file.code != V4L2_PIX_FMT_MJPEG || jpeg.size() > room) return 0;
        std::copy(jpeg.begin(), jpeg.end(), memory);
        return static_cast<std::uint32_t>(jpeg.size());
      },
      stamp);
}

bool V4l2Sim::deliver(const Fill& fill, Time stamp) {
  const std::lock_guard lock(mutex_);
  File* file = streaming();
  if (!file || fault_ == V4l2Fault::silent) return false;
  const std::uint32_t made = file->made++;
  if (fault_ == V4l2Fault::slow && made % 4 != 0) return false;
  if (fault_ == V4l2Fault::stuck) return put(*file, fill, last_stamp_, last_sequence_);
  const std::uint32_t sequence = file->sequence++;
  if (fault_ == V4l2Fault::loses && made % 2 != 0) return false;
  last_stamp_ = stamp, last_sequence_ = sequence;
  return put(*file, fill, stamp, sequence);
}

bool V4l2Sim::put(File& file, const Fill& fill, Time stamp, std::uint32_t sequence) {
  if (file.queued.empty()) return false;
  const std::uint32_t index = file.queued.front();
  std::uint8_t* memory = file.users.empty() ? file.buffers[index]->data() : file.users[index];
  const std::uint32_t filled = fill(file, memory, file.image_bytes);
  if (filled == 0) return false;
  file.queued.pop_front();
  filled_ = memory;
  const std::uint32_t used = filled / (fault_ == V4l2Fault::short_frame ? 2 : 1);
  const std::uint32_t flags = camera_.stamp_flags | (fault_ == V4l2Fault::corrupt ? V4L2_BUF_FLAG_ERROR : 0);
  file.done.push_back({index, used, flags, sequence, stamp});
  return ::write(file.pipe_in, "f", 1) == 1;
}

void V4l2Sim::lose(std::uint32_t frames) {
  const std::lock_guard lock(mutex_);
  if (File* file = streaming()) file->sequence += frames;
}

void V4l2Sim::set_fault(V4l2Fault fault) {
  const std::lock_guard lock(mutex_);
  fault_ = fault;
  File* file = streaming();
  if (fault == V4l2Fault::io_error && file) static_cast<void>(::write(file->pipe_in, "e", 1) == 1);
}

void V4l2Sim::unplug() {
  const std::lock_guard lock(mutex_);
  plugged_ = false;
  for (auto& [fd, file] : files_) {
    file.gone = true;
    if (file.pipe_in >= 0) ::close(file.pipe_in);  // hangs up
    file.pipe_in = -1;
  }
}

void V4l2Sim::plug_in(const std::string& node) {
  const std::lock_guard lock(mutex_);
  camera_.node = node;
  plugged_ = true;
}

void V4l2Sim::refuse(unsigned long request, int error) {
  const std::lock_guard lock(mutex_);
  refused_[request] = error;
}

void V4l2Sim::set_range(const std::string& name, std::int64_t min, std::int64_t max) {
  const std::lock_guard lock(mutex_);
  for (auto& c : camera_.controls)
    if (c.name == name) c.min = min, c.max = max, c.value = std::clamp(c.value, min, max);
}

void V4l2Sim::set_busy(bool busy) {
  const std::lock_guard lock(mutex_);
  busy_ = busy;
}

std::int64_t V4l2Sim::control(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  for (const auto& c : camera_.controls)
    if (c.name == name) return c.value;
  return -1;
}
bool V4l2Sim::streams() const {
  const std::lock_guard lock(mutex_);
  return std::any_of(files_.begin(), files_.end(), [](const auto& f) { return f.second.streaming; });
}
std::size_t V4l2Sim::descriptors() const {
  const std::lock_guard lock(mutex_);
  return files_.size();
}
std::size_t V4l2Sim::mapped() const {
  const std::lock_guard lock(mutex_);
  return mapped_.size();
}
std::size_t V4l2Sim::queued() const {
  const std::lock_guard lock(mutex_);
  for (const auto& [fd, file] : files_)
    if (!file.gone) return file.queued.size();
  return 0;
}

const std::uint8_t* V4l2Sim::filled() const {
  const std::lock_guard lock(mutex_);
  return filled_;
}

// ---- the driver's side

std::vector<std::string> V4l2Sim::nodes() {
  const std::lock_guard lock(mutex_);
  return plugged_ ? std::vector<std::string>{camera_.node} : std::vector<std::string>{};
}

std::vector<std::string> V4l2Sim::links(const std::string& folder) {
  const std::lock_guard lock(mutex_);
  if (!plugged_ || folder != "/dev/v4l/by-id") return {};
  return {camera_.by_id};
}

int V4l2Sim::open(const std::string& path) {
  const std::lock_guard lock(mutex_);
  if (!plugged_ || (path != camera_.node && path != "/dev/v4l/by-id/" + camera_.by_id)) return -ENOENT;
  if (const auto refused = refused_.find(0); refused != refused_.end() && refused->second) return -refused->second;
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_NONBLOCK | O_CLOEXEC) != 0) return -errno;
  files_[ends[0]].pipe_in = ends[1];
  return ends[0];
}

void V4l2Sim::close(int fd) noexcept {
  const std::lock_guard lock(mutex_);
  const auto file = files_.find(fd);
  if (file == files_.end()) return;
  ::close(fd);
  if (file->second.pipe_in >= 0) ::close(file->second.pipe_in);
  files_.erase(file);
}

int V4l2Sim::ioctl(int fd, unsigned long request, void* argument) noexcept {
  const std::lock_guard lock(mutex_);
  const auto file = files_.find(fd);
  if (file == files_.end()) return -EBADF;
  if (file->second.gone) return -ENODEV;
  if (const auto refused = refused_.find(request); refused != refused_.end() && refused->second)
    return -refused->second;
  const int said = answer(file->second, request, argument);
  char byte = 0;
  if (request == VIDIOC_DQBUF && said == 0) static_cast<void>(::read(fd, &byte, 1) == 1);
  return said;
}

void* V4l2Sim::map(int fd, std::size_t bytes, std::int64_t offset) {
  const std::lock_guard lock(mutex_);
  const auto file = files_.find(fd);
  if (file == files_.end()) return nullptr;
  const auto index = static_cast<std::size_t>(offset);  // an index is enough of an offset here
  if (index >= file->second.buffers.size() || file->second.buffers[index]->size() != bytes) return nullptr;
  mapped_[file->second.buffers[index]->data()] = file->second.buffers[index];
  return file->second.buffers[index]->data();
}

void V4l2Sim::unmap(void* memory, std::size_t) noexcept {
  const std::lock_guard lock(mutex_);
  mapped_.erase(memory);
}

int V4l2Sim::buffers(File& file, unsigned long request, void* argument) {
  switch (request) {
    case VIDIOC_REQBUFS: {
      auto& wanted = *static_cast<v4l2_requestbuffers*>(argument);
      if (busy_) return -EBUSY;
      const bool users = wanted.memory == V4L2_MEMORY_USERPTR && camera_.user_pointers;
      if ((wanted.memory != V4L2_MEMORY_MMAP && !users) || file.streaming) return -EINVAL;
      if (wanted.count != 0) wanted.count = std::max(wanted.count, camera_.fewest_buffers);
      wanted.count = std::min(wanted.count, users ? kMostUserBuffers : kMostSimBuffers);
      file.buffers.clear();
      file.users.clear();
      file.queued.clear();
      if (users) {
        file.users.resize(wanted.count);
        return 0;
      }
      for (std::uint32_t i = 0; i < wanted.count; ++i)
        file.buffers.push_back(std::make_shared<std::vector<std::uint8_t>>(file.image_bytes));
      return 0;
    }
    case VIDIOC_QUERYBUF: {
      auto& buffer = *static_cast<v4l2_buffer*>(argument);
      if (buffer.index >= file.buffers.size()) return -EINVAL;
      buffer.length = static_cast<std::uint32_t>(file.buffers[buffer.index]->size());
      buffer.m.offset = buffer.index;
      return 0;
    }
    case VIDIOC_QBUF: {
      const auto& buffer = *static_cast<const v4l2_buffer*>(argument);
      const auto here = [&buffer](std::uint32_t index) { return index == buffer.index; };
      if (buffer.index >= std::max(file.buffers.size(), file.users.size()) ||
          std::any_of(file.queued.begin(), file.queued.end(), here) ||
          std::any_of(file.done.begin(), file.done.end(), [&](const Done& d) { return here(d.index); }))
        return -EINVAL;
      if (buffer.memory != (file.users.empty() ? V4L2_MEMORY_MMAP : V4L2_MEMORY_USERPTR)) return -EINVAL;
      if (!file.users.empty()) {
        if (buffer.length < file.image_bytes || buffer.m.userptr % camera_.pointer_alignment != 0) return -EINVAL;
        file.users[buffer.index] = reinterpret_cast<std::uint8_t*>(buffer.m.userptr);
      }
      file.queued.push_back(buffer.index);
      return 0;
    }
    case VIDIOC_DQBUF: {
      auto& buffer = *static_cast<v4l2_buffer*>(argument);
      if (!file.streaming) return -EINVAL;
      if (fault_ == V4l2Fault::io_error) return -EIO;
      if (file.done.empty()) return -EAGAIN;
      const Done done = file.done.front();
      file.done.pop_front();
      buffer.index = done.index, buffer.bytesused = done.used, buffer.flags = done.flags;
      buffer.sequence = done.sequence;
      buffer.timestamp.tv_sec = static_cast<decltype(buffer.timestamp.tv_sec)>(done.stamp.ns / 1'000'000'000);
      buffer.timestamp.tv_usec = static_cast<decltype(buffer.timestamp.tv_usec)>(done.stamp.ns % 1'000'000'000 / 1000);
      return 0;
    }
    case VIDIOC_STREAMON:
      if (file.buffers.empty() && file.users.empty()) return -EINVAL;
      if (busy_) return -EBUSY;
      if (fault_ == V4l2Fault::io_error) fault_ = V4l2Fault::none;
      file.streaming = true;
      return 0;
    case VIDIOC_STREAMOFF:
      file.streaming = false;
      file.queued.clear(), file.done.clear();
      return 0;
    default:
      return -ENOTTY;
  }
}

}  // namespace sinew::hal
