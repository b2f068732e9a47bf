#pragma once
// The kernel below hal/linux, as far as device nodes go: open(), ioctl() and the like of simulated paths end here (by
// the linker's --wrap), so that all code above the system call is the code of a robot.
#include <sys/stat.h>

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "hal/buses.hpp"

namespace sinew::test {

/// One device node.
class SimNode {
 public:
  virtual ~SimNode() = default;
  /// A descriptor, or -errno.
  virtual int open() = 0;
  /// 0 or -errno.
  virtual int ioctl(unsigned long request, void* argument) = 0;
  virtual int lock() { return 0; }
};

/// One at a time.
class SimKernel {
 public:
  SimKernel();
  ~SimKernel();
  void add(const std::string& path, std::shared_ptr<SimNode> node) { nodes_[path] = std::move(node); }
  /// Descriptors of it are dead from now on, also when the node comes back.
  void remove(const std::string& path);
  /// From now on opening these paths (or all below them) fails with this errno; 0: no more.
  void refuse(const std::string& path, int error) { refused_[path] = error; }
  /// The result of stat() for refused and simulated paths: this group may use them (mode 0660).
  std::string group = "dialout";
  int can_socket_errno = 0;  // of socket(PF_CAN)

  // The wrapped calls ask these. Below 0: -errno; nothing: not our path.
  std::optional<int> open(const std::string& path);
  std::shared_ptr<SimNode> of(int fd) const;
  void close(int fd) { open_.erase(fd); }
  bool knows(const std::string& path) const;
  static SimKernel* current();

 private:
  std::map<std::string, std::shared_ptr<SimNode>> nodes_;
  std::map<std::string, int> refused_;
  std::map<int, std::shared_ptr<SimNode>> open_;
};

/// /dev/i2c-N with simulated chips behind it: sim_hil's bus behind the kernel's interface.
class I2cNode final : public SimNode {
 public:
  explicit I2cNode(std::shared_ptr<hal::I2cBus> bus) : bus_(std::move(bus)) {}
  int open() override;
  int ioctl(unsigned long request, void* argument) override;
  std::set<int> held;  // addresses that a kernel driver has

 private:
  std::shared_ptr<hal::I2cBus> bus_;
};

/// /dev/spidevB.C.
class SpiNode final : public SimNode {
 public:
  explicit SpiNode(std::shared_ptr<hal::SpiBus> chip) : chip_(std::move(chip)) {}
  int open() override;
  int ioctl(unsigned long request, void* argument) override;

 private:
  std::shared_ptr<hal::SpiBus> chip_;
};

/// A serial line: bytes that are sent here arrive at once.
class SerialNode final : public SimNode {
 public:
  ~SerialNode() override { unplug(); }
  int open() override;
  int ioctl(unsigned long request, void* argument) override;
  int lock() override { return held ? -11 : 0; }
  void send(std::span<const std::uint8_t> bytes);
  /// What the robot has sent since.
  std::vector<std::uint8_t> heard();
  void unplug();
  bool held = false;  // by another program

 private:
  int far_ = -1;
  std::uint32_t rate_ = 9600;
};

}  // namespace sinew::test
