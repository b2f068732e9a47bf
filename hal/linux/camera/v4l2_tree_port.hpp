#pragma once
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "hal/linux/camera/v4l2_port.hpp"
#include "hal/os.hpp"

namespace sinew::hal {

/// Video devices of a folder that stands for "/": ROOT/dev/video0 is the socket of another process's V4l2Source.
/// V4l2Sim answers the requests: formats, buffers that are queued and filled, sequence numbers, controls; pictures come
/// over the cable. A process that ends or unplugs its source looks like an unplugged device.
/// Differences to the kernel's: the queue lives in this process, and one of its threads (priority 95, as a driver's)
/// fills buffers. Exposure and gain are accepted and reported, but do not change the pictures.
/// Thread:  any.   RT: ioctl() of VIDIOC_QBUF and VIDIOC_DQBUF takes a lock that the filling thread holds while it
///          copies a picture.
class V4l2TreePort final : public V4l2Port {
 public:
  V4l2TreePort(Os& os, std::string root);
  ~V4l2TreePort() override;

  std::vector<std::string> nodes() override;
  std::vector<std::string> links(const std::string& folder) override;
  /// Errors:  also ENODEV when the listener is no camera of this kind.
  int open(const std::string& path) override;
  void close(int fd) noexcept override;
  int ioctl(int fd, unsigned long request, void* argument) noexcept override;
  void* map(int fd, std::size_t bytes, std::int64_t offset) override;
  void unmap(void* memory, std::size_t bytes) noexcept override;

 private:
  class Device;
  std::shared_ptr<Device> find(int fd) const;

  Os& os_;
  const std::string root_;
  mutable std::mutex mutex_;
  std::map<int, std::shared_ptr<Device>> devices_;   // by their descriptors
  std::map<void*, std::shared_ptr<Device>> mapped_;  // of mapped memory
};

}  // namespace sinew::hal
