#include "hal/linux/camera/v4l2_port.hpp"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <filesystem>

namespace sinew::hal {
namespace {

namespace fs = std::filesystem;

class KernelV4l2Port final : public V4l2Port {
 public:
  std::vector<std::string> nodes() override { return v4l2_nodes(v4l2_names("/dev")); }
  std::vector<std::string> links(const std::string& folder) override { return v4l2_names(folder); }
  int open(const std::string& path) override {
    const int fd = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    return fd >= 0 ? fd : -errno;
  }
  void close(int fd) noexcept override { ::close(fd); }
  int ioctl(int fd, unsigned long request, void* argument) noexcept override {
    for (;;) {
      if (::ioctl(fd, request, argument) == 0) return 0;
      if (errno != EINTR) return -errno;
    }
  }
  void* map(int fd, std::size_t bytes, std::int64_t offset) override {
    void* memory = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, offset);
    return memory == MAP_FAILED ? nullptr : memory;
  }
  void unmap(void* memory, std::size_t bytes) noexcept override { ::munmap(memory, bytes); }
};

}  // namespace

std::vector<std::string> v4l2_names(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code none;  // a machine without cameras has no such folder
  for (fs::directory_iterator at(folder, none), end; !none && at != end; at.increment(none))
    names.push_back(at->path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<std::string> v4l2_nodes(const std::vector<std::string>& names) {
  std::vector<int> numbers;
  for (const std::string& name : names) {
    int number = -1;
    if (!name.starts_with("video")) continue;
    const auto [end, wrong] = std::from_chars(name.data() + 5, name.data() + name.size(), number);
    if (wrong == std::errc() && end == name.data() + name.size()) numbers.push_back(number);
  }
  std::sort(numbers.begin(), numbers.end());
  std::vector<std::string> paths;
  for (const int number : numbers) paths.push_back("/dev/video" + std::to_string(number));
  return paths;
}

V4l2Port& kernel_v4l2_port() {
  static KernelV4l2Port port;
  return port;
}

}  // namespace sinew::hal
