#include "hal/linux/libcamera/libcamera_session.hpp"

#include <libcamera/control_ids.h>
#include <libcamera/formats.h>
#include <linux/dma-buf.h>
#include <sys/ioctl.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <mutex>

#include "hal/linux/camera/v4l2_format.hpp"

namespace sinew::hal {
namespace {

namespace fs = std::filesystem;

/// libcamera names packed RGB as DRM does, by the 24-bit word and not by the bytes: its BGR888 is red first in memory.
libcamera::PixelFormat pixel_format(msg::PixelFormat format) {
  switch (format) {
    case msg::PixelFormat::mono8:
      return libcamera::formats::R8;
    case msg::PixelFormat::rgb8:
      return libcamera::formats::BGR888;
    case msg::PixelFormat::bgr8:
      return libcamera::formats::RGB888;
    case msg::PixelFormat::yuyv:
      return libcamera::formats::YUYV;
    case msg::PixelFormat::none:
      break;
  }
  return {};
}

std::string offers(const libcamera::StreamConfiguration& stream) {
  std::string text;
  for (const auto& format : stream.formats().pixelformats())
    text += (text.empty() ? "" : ", ") + format.toString() + " " + stream.formats().range(format).toString();
  return text.empty() ? "nothing that it would say" : text;
}

Errc kind_of(int error) {
  switch (error) {
    case EBUSY:
      return Errc::busy;
    case EACCES:
    case EPERM:
      return Errc::denied;
    case ENODEV:
      return Errc::closed;
    default:
      return Errc::io;
  }
}

Error failed(int said, const char* where, std::string& why) {
  why = std::string(where) + ": " + (said == -EBUSY ? "another program uses the camera" : std::strerror(-said));
  return {kind_of(-said), where, -said};
}

}  // namespace

std::shared_ptr<libcamera::CameraManager> libcamera_manager() {
  static std::mutex mutex;
  static std::weak_ptr<libcamera::CameraManager> running;
  const std::lock_guard lock(mutex);
  if (auto manager = running.lock()) return manager;
  auto manager = std::make_shared<libcamera::CameraManager>();
  if (manager->start() != 0) return nullptr;
  running = manager;
  return manager;
}

Result<std::unique_ptr<LibcameraSession>> LibcameraSession::open(const CameraSpec& spec, std::function<void()> arrived,
                                                                 std::string& why) {
  std::unique_ptr<LibcameraSession> session(new LibcameraSession(std::move(arrived)));
  if (const Status found = session->find(spec.path, why); !found) return found.error();
  std::string reason;
  Status done = session->configure(spec, reason);
  if (done) {
    session->list_controls();
    done = session->check(spec.controls, reason);
  }
  if (done) done = session->map_buffers(reason);
  if (done) done = session->start(spec, reason);
  if (done) return session;
  why = "camera '" + session->id_ + "': " + reason;
  return done.error();
}

Status LibcameraSession::find(const std::string& name, std::string& why) {
  manager_ = libcamera_manager();
  if (!manager_) {
    why = "libcamera could not be started";
    return Error{Errc::io, "libcamera"};
  }
  camera_ = manager_->get(name);
  if (!camera_) {
    std::string there;
    for (const auto& camera : manager_->cameras()) there += (there.empty() ? "'" : ", '") + camera->id() + "'";
    why = "no camera '" + name + "' for libcamera: " +
          (there.empty() ? "it sees none; /dev/media* and /dev/video* must be open to this user (group video)"
                         : "it sees " + there);
    return Error{Errc::not_found, "libcamera"};
  }
  id_ = camera_->id();
  return {};
}

Status LibcameraSession::configure(const CameraSpec& spec, std::string& why) {
  const libcamera::PixelFormat format = pixel_format(spec.format);
  if (!format.isValid() || spec.width == 0 || spec.height == 0 || spec.width > msg::kMaxImageWidth ||
      spec.height > msg::kMaxImageHeight || spec.buffers < 2 || spec.buffers > 32 || !std::isfinite(spec.rate_hz) ||
      spec.rate_hz < 0) {
    why = "images are mono8, rgb8, bgr8 or yuyv, 1x1 to " + std::to_string(msg::kMaxImageWidth) + "x" +
          std::to_string(msg::kMaxImageHeight) + ", with 2 to 32 buffers and a rate of 0 (as it is) or more";
    return Error{Errc::bad_argument, "camera format"};
  }
  if (const int said = camera_->acquire(); said < 0) return failed(said, "acquire", why);
  acquired_ = true;
  const auto configuration = camera_->generateConfiguration({libcamera::StreamRole::Viewfinder});
  if (!configuration || configuration->empty()) {
    why = "it has no stream of its own";
    return Error{Errc::not_supported, "camera format"};
  }
  libcamera::StreamConfiguration& stream = configuration->at(0);
  stream.pixelFormat = format;
  stream.size = {spec.width, spec.height};
  stream.bufferCount = spec.buffers;
  const auto valid = configuration->validate();
  if (valid == libcamera::CameraConfiguration::Invalid || stream.pixelFormat != format ||
      stream.size != libcamera::Size(spec.width, spec.height)) {
    why = "asked for " + std::to_string(spec.width) + "x" + std::to_string(spec.height) + " " +
          msg::pixel_format_name(spec.format) + " (" + format.toString() + " to libcamera), the camera gives " +
          stream.toString() + "; it has " + offers(stream);
    return Error{stream.pixelFormat != format ? Errc::not_supported : Errc::bad_argument, "camera format"};
  }
  if (const int said = camera_->configure(configuration.get()); said < 0) return failed(said, "configure", why);
  stream_ = stream.stream();
  stride_ = stream.stride;
  const std::uint32_t row = spec.width * msg::bytes_per_pixel(spec.format);
  image_bytes_ = stride_ * (spec.height - 1) + row;
  if (stride_ >= row) return {};
  why = "rows of " + std::to_string(stride_) + " bytes for " + std::to_string(row) + " bytes of pixels";
  return Error{Errc::bad_data, "camera format"};
}

Status LibcameraSession::map_buffers(std::string& why) {
  allocator_ = std::make_unique<libcamera::FrameBufferAllocator>(camera_);
  if (const int said = allocator_->allocate(stream_); said < 0) return failed(said, "allocate", why);
  const auto& buffers = allocator_->buffers(stream_);
  back_ = std::make_unique<std::atomic<bool>[]>(buffers.size());
  for (std::size_t i = 0; i < buffers.size(); ++i) {
    const auto& plane = buffers[i]->planes().front();
    Mapping mapping;
    const std::size_t offset = plane.offset == libcamera::FrameBuffer::Plane::kInvalidOffset ? 0 : plane.offset;
    mapping.fd = plane.fd.get();
    mapping.length = offset + plane.length;
    if (plane.length < image_bytes_ || buffers.size() > kRing) {
      why = std::to_string(buffers.size()) + " buffers of " + std::to_string(plane.length) + " bytes for images of " +
            std::to_string(image_bytes_);
      return Error{Errc::bad_data, "camera buffers"};
    }
    void* memory = mmap(nullptr, mapping.length, PROT_READ, MAP_SHARED, mapping.fd, 0);
    if (memory == MAP_FAILED) return failed(-errno, "mmap", why);
    mapping.start = memory;
    mapping.bytes = {static_cast<const std::uint8_t*>(memory) + offset, plane.length};
    mapped_.push_back(mapping);
    auto request = camera_->createRequest(i);
    if (!request) return failed(-ENOMEM, "createRequest", why);
    if (const int said = request->addBuffer(stream_, buffers[i].get()); said < 0) return failed(said, "addBuffer", why);
    requests_.push_back(std::move(request));
  }
  return {};
}

Status LibcameraSession::start(const CameraSpec& spec, std::string& why) {
  camera_->requestCompleted.connect(this, &LibcameraSession::completed);
  camera_->disconnected.connect(this, &LibcameraSession::disconnected);
  libcamera::ControlList first(camera_->controls());
  put(first, spec.controls);
  if (spec.rate_hz > 0 && camera_->controls().count(libcamera::controls::FrameDurationLimits.id()) != 0) {
    const auto period_us = static_cast<std::int64_t>(std::llround(1e6 / spec.rate_hz));
    first.set(libcamera::controls::FrameDurationLimits, {period_us, period_us});
    rate_set_ = true;
  }
  if (const int said = camera_->start(&first); said < 0) return failed(said, "start", why);
  running_ = true;
  for (const auto& request : requests_)
    if (const int said = camera_->queueRequest(request.get()); said < 0) return failed(said, "queueRequest", why);
  return {};
}

bool LibcameraSession::vanished() const {
  if (gone()) return false;
  std::error_code none;
  for (fs::directory_iterator at("/proc/self/fd", none), end; !none && at != end; at.increment(none)) {
    std::error_code closed;  // meanwhile, by another thread
    const std::string to = fs::read_symlink(at->path(), closed).string();
    const bool camera = to.starts_with("/dev/video") || to.starts_with("/dev/media") || to.starts_with("/dev/v4l-");
    if (camera && to.ends_with(" (deleted)")) return true;
  }
  return false;
}

LibcameraSession::~LibcameraSession() {
  if (camera_) {
    if (running_ && vanished()) {
      camera_->requestCompleted.disconnect(this);
      camera_->disconnected.disconnect(this);
      struct Left {
        std::shared_ptr<libcamera::CameraManager> manager;
        std::shared_ptr<libcamera::Camera> camera;
        std::unique_ptr<libcamera::FrameBufferAllocator> allocator;
        std::vector<std::unique_ptr<libcamera::Request>> requests;
      };
      static_cast<void>(new Left{std::move(manager_), std::move(camera_), std::move(allocator_), std::move(requests_)});
      return;
    }
    if (running_) camera_->stop();  // all requests come back as cancelled before this returns
    camera_->requestCompleted.disconnect(this);
    camera_->disconnected.disconnect(this);
  }
  requests_.clear();
  for (const Mapping& m : mapped_) munmap(m.start, m.length);
  allocator_.reset();
  if (acquired_) camera_->release();
  camera_.reset();
}

/// In libcamera's thread.
void LibcameraSession::completed(libcamera::Request* request) {
  if (request->status() == libcamera::Request::RequestCancelled) return;
  const libcamera::FrameBuffer* buffer = request->findBuffer(stream_);
  if (!buffer) return;
  const auto& about = buffer->metadata();
  const auto index = static_cast<std::uint32_t>(request->cookie());
  Frame frame;
  frame.request = index;
  frame.sequence = about.sequence;
  std::size_t used = 0;
  for (const auto& plane : about.planes()) used += plane.bytesused;
  frame.good = about.status == libcamera::FrameMetadata::FrameSuccess && used >= image_bytes_;
  // The buffer's own stamp where the pipeline reports no other: the stamp of the V4L2 node behind it.
  const auto stamp = request->metadata().get(libcamera::controls::SensorTimestamp);
  frame.stamp_ns = stamp ? *stamp : static_cast<std::int64_t>(about.timestamp);
  if (const auto exposure_us = request->metadata().get(libcamera::controls::ExposureTime))
    frame.exposure_ns = std::int64_t{*exposure_us} * 1000;
  frame.bytes = mapped_[index].bytes;
  const std::uint32_t at = written_.load(std::memory_order_relaxed);
  ring_[at % kRing] = frame;  // never full: there are fewer requests than places
  written_.store(at + 1, std::memory_order_release);
  arrived_();
}

void LibcameraSession::disconnected() {
  gone_.store(true, std::memory_order_release);
  arrived_();
}

bool LibcameraSession::take(Frame& frame) noexcept {
  const std::uint32_t at = read_.load(std::memory_order_relaxed);
  if (at == written_.load(std::memory_order_acquire)) return false;
  frame = ring_[at % kRing];
  read_.store(at + 1, std::memory_order_relaxed);
  return true;
}

Status LibcameraSession::requeue(Wanted& wanted) {
  for (std::size_t i = 0; i < requests_.size(); ++i) {
    if (!back_[i].exchange(false, std::memory_order_acquire)) continue;
    requests_[i]->reuse(libcamera::Request::ReuseBuffers);
    put(requests_[i]->controls(), wanted);
    wanted.clear();
    if (const int said = camera_->queueRequest(requests_[i].get()); said < 0)
      return Error{kind_of(-said), "queueRequest", -said};
  }
  return {};
}

void LibcameraSession::begin_access(std::uint32_t request) noexcept {
  dma_buf_sync sync{DMA_BUF_SYNC_START | DMA_BUF_SYNC_READ};
  static_cast<void>(ioctl(mapped_[request].fd, DMA_BUF_IOCTL_SYNC, &sync));  // memory that is no dma-buf needs no sync
}
void LibcameraSession::end_access(std::uint32_t request) noexcept {
  dma_buf_sync sync{DMA_BUF_SYNC_END | DMA_BUF_SYNC_READ};
  static_cast<void>(ioctl(mapped_[request].fd, DMA_BUF_IOCTL_SYNC, &sync));
}

}  // namespace sinew::hal
