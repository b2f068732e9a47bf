#include "hal/linux/camera/v4l2_session.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace sinew::hal {
namespace {

constexpr const char* kByIdFolder = "/dev/v4l/by-id";
constexpr std::uint32_t kFewestBuffers = 2, kMostBuffers = 32;  // VIDEO_MAX_FRAME

Errc open_error_kind(int error) {
  switch (error) {
    case ENOENT:
    case ENXIO:
      return Errc::not_found;
    case EACCES:
    case EPERM:
      return Errc::denied;
    case EBUSY:
      return Errc::busy;
    case ENODEV:
      return Errc::closed;
    case ENOMEM:
      return Errc::out_of_memory;
    default:
      return Errc::io;
  }
}

/// The remedy for an error, where one is known.
std::string advice(int error, const std::string& path) {
  switch (error) {
    case EACCES:
    case EPERM:
      return ": permission denied; add the user to the device's group (usually `usermod -aG video USER`, then log in "
             "again) or set a udev rule for " +
             path;
    case EBUSY:
      return ": busy: another program uses it; `fuser " + path + "` says which";
    case ENOENT:
      return ": there is no such device";
    case ENODEV:
    case ENXIO:
      return ": the device is gone";
    default:
      return std::string(": ") + std::strerror(error);
  }
}

struct Known {
  std::string path;
  V4l2Identity identity;
};

/// All nodes that capture and that this user may open.
std::vector<Known> capture_nodes(V4l2Port& port) {
  std::vector<Known> all;
  for (const std::string& path : port.nodes()) {
    const int fd = port.open(path);
    if (fd < 0) continue;
    if (const auto identity = v4l2_identify(port, fd); identity && identity->captures) all.push_back({path, *identity});
    port.close(fd);
  }
  return all;
}

std::string text_of(const std::vector<Known>& nodes) {
  std::string text;
  for (const Known& n : nodes)
    text += (text.empty() ? "" : "; ") + n.path + " '" + n.identity.card + "' at " + n.identity.bus_info;
  return text.empty() ? "no camera is there (or none may be opened by this user)" : "there is " + text;
}

}  // namespace

Result<std::string> v4l2_find(V4l2Port& port, const std::string& name, std::string& why) {
  if (name.starts_with("/")) return name;
  const auto by_id = port.links(kByIdFolder);
  for (const std::string& full : {name, name + "-video-index0"})
    if (!name.empty() && std::find(by_id.begin(), by_id.end(), full) != by_id.end())
      return std::string(kByIdFolder) + "/" + full;
  const auto nodes = capture_nodes(port);
  std::vector<std::string> found;
  for (const Known& n : nodes)
    if (!name.empty() && (n.identity.bus_info == name || n.identity.card == name)) found.push_back(n.path);
  if (found.size() == 1) return found.front();
  why = found.empty() ? "no camera '" + name + "': " : "more than one camera is '" + name + "', use the bus or path: ";
  why += text_of(nodes);
  return Error{Errc::not_found, "camera name", static_cast<std::int64_t>(found.size())};
}

Result<std::unique_ptr<V4l2Session>> V4l2Session::open(V4l2Port& port, const CameraSpec& spec, std::string& why,
                                                       std::uint32_t room_bytes) {
  std::unique_ptr<V4l2Session> session(new V4l2Session(port));
  if (const Status begun = session->begin(spec, room_bytes, why); !begun) return begun.error();
  return session;
}

Status V4l2Session::begin(const CameraSpec& spec, std::uint32_t room_bytes, std::string& why) {
  if (const Status opened = open_node(spec.path, why); !opened) return opened;
  std::string reason;
  const auto told = [&](const Status& failed) {
    why = path_ + " ('" + identity_.card + "'): " + reason;
    return failed;
  };
  if (spec.buffers < kFewestBuffers || spec.buffers > kMostBuffers) {
    reason = "buffers = " + std::to_string(spec.buffers) + ": 2 to 32 are allowed";
    return told(Error{Errc::bad_argument, "camera buffers", spec.buffers});
  }
  const auto picture = v4l2_agree(port_, fd_, spec, reason);
  if (!picture) return told(picture.error());
  picture_ = *picture;
  controls_ = V4l2Controls::enumerate(port_, fd_);  // only now: a sensor's longest exposure follows from size and rate
  if (const Status known = controls_.check(spec.controls, reason); !known) return told(known);
  if (const Status set = controls_.set(port_, fd_, spec.controls, reason); !set) return told(set);
  const Status started = room_bytes != 0 ? begin_lending(spec, room_bytes, reason) : start_stream(spec.buffers, reason);
  return started ? started : told(started);
}

Status V4l2Session::open_node(const std::string& name, std::string& why) {
  const auto path = v4l2_find(port_, name, why);
  if (!path) return path.error();
  path_ = *path;
  fd_ = port_.open(path_);
  if (fd_ < 0) {
    why = path_ + advice(-fd_, path_);
    if (fd_ == -ENOENT) why += "; " + text_of(capture_nodes(port_));
    return Error{open_error_kind(-fd_), "camera open", -fd_};
  }
  const auto identity = v4l2_identify(port_, fd_);
  if (!identity) {
    why = path_ + (identity.error().code == Errc::not_supported
                       ? ": is no video device"
                       : advice(static_cast<int>(identity.error().detail), path_));
    return identity.error();
  }
  identity_ = *identity;
  if (identity_.captures && identity_.streams) return {};
  why =
      path_ + " ('" + identity_.card + "') " +
      (identity_.captures      ? "cannot stream into mapped buffers"
       : identity_.multiplanar ? "gives pictures in several planes only, which is not supported; libcamera may open it"
                               : "is no capture device (a camera's second node has only its metadata)");
  return Error{Errc::not_supported, "camera capabilities"};
}

Status V4l2Session::start_stream(std::uint32_t buffers, std::string& why) {
  const auto failed = [&](const char* request, int said) {
    why = std::string(request) + advice(-said, path_);
    return Error{open_error_kind(-said), request, -said};
  };
  std::uint32_t count = buffers;
  if (const int said = request_buffers(V4L2_MEMORY_MMAP, count); said < 0) return failed("VIDIOC_REQBUFS", said);
  if (count < kFewestBuffers || count > kMostBuffers) {
    why = "the driver gives " + std::to_string(count) + " buffers, 2 to 32 are needed";
    return Error{Errc::out_of_memory, "VIDIOC_REQBUFS", count};
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    v4l2_buffer buffer;
    std::memset(&buffer, 0, sizeof buffer);
    buffer.index = i, buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE, buffer.memory = V4L2_MEMORY_MMAP;
    if (const int said = port_.ioctl(fd_, VIDIOC_QUERYBUF, &buffer); said < 0) return failed("VIDIOC_QUERYBUF", said);
    if (buffer.length < picture_.image_bytes) {
      why = "a buffer of " + std::to_string(buffer.length) + " bytes for images of " +
            std::to_string(picture_.image_bytes);
      return Error{Errc::bad_data, "VIDIOC_QUERYBUF", buffer.length};
    }
    void* memory = port_.map(fd_, buffer.length, buffer.m.offset);
    if (!memory) {
      why = "a buffer could not be mapped: " + std::string(std::strerror(errno));
      return Error{Errc::io, "mmap", errno};
    }
    memory_.push_back({static_cast<std::uint8_t*>(memory), buffer.length});
    if (const int said = give_back(i); said < 0) return failed("VIDIOC_QBUF", said);
  }
  if (const int said = start(); said < 0) return failed("VIDIOC_STREAMON", said);
  return {};
}

int V4l2Session::request_buffers(std::uint32_t memory, std::uint32_t& count) noexcept {
  v4l2_requestbuffers wanted;
  std::memset(&wanted, 0, sizeof wanted);
  wanted.count = count;
  wanted.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  wanted.memory = memory;
  const int said = port_.ioctl(fd_, VIDIOC_REQBUFS, &wanted);
  count = wanted.count;
  return said;
}

int V4l2Session::start() noexcept {
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  const int said = port_.ioctl(fd_, VIDIOC_STREAMON, &type);
  streaming_ = said == 0;
  return said;
}

void V4l2Session::stop() noexcept {
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  port_.ioctl(fd_, VIDIOC_STREAMOFF, &type);  // fails on a device that is gone: then there is nothing to stop
  streaming_ = false;
  is_queued_.assign(is_queued_.size(), false);
  queued_ = 0;
}

void V4l2Session::end_mapping() noexcept {
  if (!lends_)
    for (const auto memory : memory_) port_.unmap(memory.data(), memory.size());
  memory_.clear();
}

V4l2Session::~V4l2Session() {
  if (fd_ < 0) return;
  if (streaming_ || lends_) stop();
  end_mapping();
  port_.close(fd_);
}

int V4l2Session::take(Filled& filled) noexcept {
  v4l2_buffer buffer;
  std::memset(&buffer, 0, sizeof buffer);
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE, buffer.memory = lends_ ? V4L2_MEMORY_USERPTR : V4L2_MEMORY_MMAP;
  const int said = port_.ioctl(fd_, VIDIOC_DQBUF, &buffer);
  if (said == -EAGAIN) return 0;
  if (said < 0) return said;
  if (buffer.index >= memory_.size()) return -EIO;  // not our index: the driver is no longer trusted
  if (lends_) {
    if (!is_queued_[buffer.index]) return -EIO;
    is_queued_[buffer.index] = false, --queued_;
  }
  const auto memory = memory_[buffer.index];
  filled.index = buffer.index;
  filled.sequence = buffer.sequence;
  filled.flags = buffer.flags;
  filled.stamp_ns =
      std::int64_t{buffer.timestamp.tv_sec} * 1'000'000'000 + std::int64_t{buffer.timestamp.tv_usec} * 1000;
  filled.bytes = memory.first(std::min<std::size_t>(buffer.bytesused, memory.size()));
  return 1;
}

int V4l2Session::give_back(std::uint32_t index) noexcept {
  if (lends_) return queue(index);
  v4l2_buffer buffer;
  std::memset(&buffer, 0, sizeof buffer);
  buffer.index = index, buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE, buffer.memory = V4L2_MEMORY_MMAP;
  return port_.ioctl(fd_, VIDIOC_QBUF, &buffer);
}

}  // namespace sinew::hal
