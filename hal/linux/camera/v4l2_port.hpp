#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace sinew::hal {

/// The calls to video devices: the kernel's own, or those of a simulated device (v4l2_sim.hpp).
/// Thread:  any; one descriptor may be used from two (a control is set while frames are taken).
/// Errors:  negative errno, as the kernel itself answers.
class V4l2Port {
 public:
  virtual ~V4l2Port() = default;
  /// Paths of all video nodes, "/dev/video0" before "/dev/video10". RT: no.
  virtual std::vector<std::string> nodes() = 0;
  /// udev's stable names in a folder ("/dev/v4l/by-id"). RT: no.
  virtual std::vector<std::string> links(const std::string& folder) = 0;
  /// A descriptor for reading and writing that does not block; epoll can wait on it.
  virtual int open(const std::string& path) = 0;
  virtual void close(int fd) noexcept = 0;
  /// One of the VIDIOC_ requests; an interrupted one is begun again.
  virtual int ioctl(int fd, unsigned long request, void* argument) noexcept = 0;
  /// Null: the mapping failed.
  virtual void* map(int fd, std::size_t bytes, std::int64_t offset) = 0;
  virtual void unmap(void* memory, std::size_t bytes) noexcept = 0;
};

/// The running kernel's.
V4l2Port& kernel_v4l2_port();

/// Names of the files in a folder, sorted; empty when there is no such folder. RT: no.
std::vector<std::string> v4l2_names(const std::string& folder);
/// "/dev/video0", "/dev/video10": the video nodes among the names of /dev, by their numbers. RT: no.
std::vector<std::string> v4l2_nodes(const std::vector<std::string>& names);

}  // namespace sinew::hal
