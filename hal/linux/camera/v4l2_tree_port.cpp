#include "hal/linux/camera/v4l2_tree_port.hpp"

#include <linux/videodev2.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "hal/linux/camera/v4l2_cable.hpp"
#include "hal/linux/camera/v4l2_format.hpp"
#include "hal/linux/camera/v4l2_sim.hpp"
#include "hal/linux/socket.hpp"

namespace sinew::hal {
namespace {

using namespace std::chrono_literals;

constexpr Duration kAnswersWithin = 2s;  // the source's thread has ordinary priority
constexpr const char* kExposure = "Exposure Time, Absolute";
constexpr std::int64_t kExposureUnitNs = 100'000;

int errno_of(const Error& e) {
  switch (e.code) {
    case Errc::not_found:
    case Errc::closed:  // a dead process left the socket behind
      return ENOENT;
    case Errc::denied:
      return EACCES;
    case Errc::bad_argument:
      return ENAMETOOLONG;
    default:
      return EIO;
  }
}

template <class T>
Status read_whole(Stream& line, T& into) {
  auto rest = std::as_writable_bytes(std::span(&into, 1));
  while (!rest.empty()) {
    const auto got = line.read(rest);
    if (!got) return got.error();
    rest = rest.subspan(*got);
  }
  return {};
}

V4l2SimCamera camera_of(const CableHello& hello, const std::string& path) {
  V4l2SimCamera c;
  c.node = path;
  c.card = hello.card, c.bus_info = hello.bus_info, c.driver = "sinew-sim";
  c.offers = {{v4l2_code(hello.format),
               msg::pixel_format_name(hello.format),
               {{hello.width, hello.height}},
               {hello.rate_mhz / 1e3}}};
  c.controls = {{V4L2_CID_GAIN, V4L2_CTRL_TYPE_INTEGER, "Gain", 0, 100, 1, 20},
                {V4L2_CID_EXPOSURE_AUTO, V4L2_CTRL_TYPE_MENU, "Auto Exposure", 0, 3, 1, V4L2_EXPOSURE_MANUAL},
                {V4L2_CID_EXPOSURE_ABSOLUTE, V4L2_CTRL_TYPE_INTEGER, kExposure, 1, 300, 1, 80}};
  return c;
}

bool sensible(CableHello& hello, const SharedMemory& memory) {
  hello.card[sizeof hello.card - 1] = hello.bus_info[sizeof hello.bus_info - 1] = 0;
  const std::uint64_t pixels = std::uint64_t{hello.width} * hello.height * msg::bytes_per_pixel(hello.format);
  return hello.magic == kCableMagic && pixels > 0 && hello.width <= msg::kMaxImageWidth &&
         hello.height <= msg::kMaxImageHeight && hello.slot_bytes >= sizeof(msg::Image) + pixels &&
         hello.slot_bytes % alignof(msg::Image) == 0 && memory.size() / kCableSlots >= hello.slot_bytes &&
         hello.rate_mhz > 0;
}

}  // namespace

/// One descriptor: the simulated driver, and the cable to the process that draws.
class V4l2TreePort::Device {
 public:
  /// 0 or negative errno.
  static int open(Os& os, const std::string& socket, const std::string& path, std::shared_ptr<Device>& out);
  ~Device() {
    line_->shutdown();
    thread_.reset();
    if (fd_ >= 0) sim_->close(fd_);
  }
  int fd() const { return fd_; }
  V4l2Sim& sim() { return *sim_; }
  int ioctl(unsigned long request, void* argument) {
    if (request == VIDIOC_REQBUFS)
      if (const int claimed = claim(); claimed < 0) return claimed;
    const int said = sim_->ioctl(fd_, request, argument);
    if (said == 0 && request == VIDIOC_STREAMON) return start();
    if (said == 0 && request == VIDIOC_STREAMOFF) static_cast<void>(say({CableWord::stop, 0, 0, 0}));
    return said;
  }

 private:
  Status say(const CableMessage& message) {
    const std::lock_guard lock(saying_);  // between the filling thread and the one that stops the stream
    return line_->write(std::as_bytes(std::span(&message, 1)));
  }
  Device(Os& os, const CableHello& hello) : os_(os), hello_(hello) {}
  int claim();
  int start();
  void receive() noexcept;
  bool take(const CableMessage& message);

  Os& os_;
  CableHello hello_;
  std::mutex saying_;
  std::unique_ptr<Stream> line_;
  std::unique_ptr<SharedMemory> memory_;
  std::unique_ptr<V4l2Sim> sim_;
  int fd_ = -1;
  bool claimed_ = false, counting_ = false;
  std::uint32_t last_number_ = 0;
  std::unique_ptr<Thread> thread_;
};

int V4l2TreePort::Device::open(Os& os, const std::string& socket, const std::string& path,
                               std::shared_ptr<Device>& out) {
  auto line = connect_stream("unix:" + socket, Duration{0});
  if (!line) return -errno_of(line.error());
  (*line)->set_patience(kAnswersWithin);
  CableHello hello;
  if (!read_whole(**line, hello)) return -ENODEV;
  auto memory = (*line)->take_memory(Stream::MemoryAccess::mapped);
  if (!memory || !sensible(hello, **memory)) return -ENODEV;
  std::shared_ptr<Device> device(new Device(os, hello));
  device->line_ = std::move(*line);
  device->memory_ = std::move(*memory);
  device->sim_ = std::make_unique<V4l2Sim>(camera_of(hello, path));
  device->sim_->set_busy(hello.busy != 0);
  device->fd_ = device->sim_->open(path);
  if (device->fd_ < 0) return device->fd_;
  out = std::move(device);
  return 0;
}

/// Only one opener gets buffers: as in the kernel, the first user owns the queue.
int V4l2TreePort::Device::claim() {
  if (claimed_) return 0;
  if (!say({CableWord::claim, 0, 0, 0})) return -ENODEV;
  CableMessage answer;
  if (!read_whole(*line_, answer)) return -ENODEV;
  claimed_ = answer.word == CableWord::granted;
  sim_->set_busy(!claimed_);
  return 0;
}

int V4l2TreePort::Device::start() {
  if (!say({CableWord::start, 0, 0, 0})) return -ENODEV;
  if (thread_) return 0;
  line_->set_patience(Duration{0});
  ThreadOptions options;
  options.name = "video_driver";
  options.fifo_priority = 95;  // as FdWatch: both replace interrupts
  options.stack_bytes = std::size_t{64} * 1024;
  auto started = os_.start_thread(options, [this] { receive(); });
  if (!started) return -ENOMEM;
  thread_ = std::move(*started);
  return 0;
}

void V4l2TreePort::Device::receive() noexcept {
  CableMessage message;
  while (read_whole(*line_, message))
    if (!take(message)) break;
  sim_->unplug();
}

bool V4l2TreePort::Device::take(const CableMessage& message) {
  if (message.word != CableWord::frame || message.slot >= kCableSlots) return false;
  const auto& image =
      *reinterpret_cast<const msg::Image*>(memory_->data() + std::size_t{message.slot} * hello_.slot_bytes);
  if (image.format != hello_.format || image.width != hello_.width || image.height != hello_.height ||
      image.stride != hello_.width * msg::bytes_per_pixel(hello_.format))
    return false;
  if (counting_) sim_->lose(message.number - last_number_ - 1);
  counting_ = true, last_number_ = message.number;
  // The driver stamps the start of the exposure.
  const Duration half{sim_->control(kExposure) * kExposureUnitNs / 2};
  sim_->deliver(image, image.stamp - half);  // false: no buffer was queued; the sequence shows it
  return static_cast<bool>(say({CableWord::give_back, message.slot, 0, 0}));
}

V4l2TreePort::V4l2TreePort(Os& os, std::string root) : os_(os), root_(std::move(root)) {}
V4l2TreePort::~V4l2TreePort() = default;

std::vector<std::string> V4l2TreePort::nodes() { return v4l2_nodes(v4l2_names(root_ + "/dev")); }
std::vector<std::string> V4l2TreePort::links(const std::string& folder) { return v4l2_names(root_ + folder); }

int V4l2TreePort::open(const std::string& path) {
  std::shared_ptr<Device> device;
  if (const int failed = Device::open(os_, root_ + path, path, device); failed < 0) return failed;
  const std::lock_guard lock(mutex_);
  const int fd = device->fd();
  devices_[fd] = std::move(device);
  return fd;
}

std::shared_ptr<V4l2TreePort::Device> V4l2TreePort::find(int fd) const {
  const std::lock_guard lock(mutex_);
  const auto found = devices_.find(fd);
  return found == devices_.end() ? nullptr : found->second;
}

void V4l2TreePort::close(int fd) noexcept {
  std::shared_ptr<Device> closed;  // ends its thread outside of the lock
  const std::lock_guard lock(mutex_);
  const auto found = devices_.find(fd);
  if (found == devices_.end()) return;
  closed = std::move(found->second);
  devices_.erase(found);
}

int V4l2TreePort::ioctl(int fd, unsigned long request, void* argument) noexcept {
  const auto device = find(fd);
  return device ? device->ioctl(request, argument) : -EBADF;
}

void* V4l2TreePort::map(int fd, std::size_t bytes, std::int64_t offset) {
  auto device = find(fd);
  void* memory = device ? device->sim().map(fd, bytes, offset) : nullptr;
  if (!memory) return nullptr;
  const std::lock_guard lock(mutex_);
  mapped_[memory] = std::move(device);
  return memory;
}

void V4l2TreePort::unmap(void* memory, std::size_t bytes) noexcept {
  std::shared_ptr<Device> device;
  {
    const std::lock_guard lock(mutex_);
    const auto found = mapped_.find(memory);
    if (found == mapped_.end()) return;
    device = std::move(found->second);
    mapped_.erase(found);
  }
  device->sim().unmap(memory, bytes);
}

}  // namespace sinew::hal
