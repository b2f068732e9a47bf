// The part of `sinew doctor` for a board with devices: their files, CAN interfaces, and their surroundings.
#include <sys/timex.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <set>

#include "hal/linux/system_check.hpp"

namespace sinew::hal {
namespace {

using enum CheckState;

constexpr std::int64_t kCanType = 280;       // ARPHRD_CAN. Source: linux/if_arp.h
constexpr std::int64_t kShortCanQueue = 64;  // frames; the kernel's default of 10 is one cycle of a few joints

/// Findings of one check; the worst one is its state.
class Findings {
 public:
  explicit Findings(std::string id) : check_{std::move(id), ok, "", ""} {}
  void fine(const std::string& seen) { add(ok, seen, ""); }
  void add(CheckState state, const std::string& seen, const std::string& advice) {
    check_.seen += (check_.seen.empty() ? "" : "; ") + seen;
    if (!advice.empty() && advised_.insert(advice).second)
      check_.advice += (check_.advice.empty() ? "" : "; ") + advice;
    if (state == problem || (state == warning && check_.state == ok)) check_.state = state;
  }
  const SystemCheck& check() const { return check_; }

 private:
  SystemCheck check_;
  std::set<std::string> advised_;
};

std::string octal(std::uint32_t mode) {
  char text[8];
  std::snprintf(text, sizeof text, "%04o", mode);
  return text;
}

SystemCheck devices(const SystemFiles& files, const SystemDemand& demand) {
  Findings found("devices");
  for (const auto& node : demand.nodes) {
    const auto access = files.access(node.path.substr(1));
    const std::string whose = node.path + " (" + node.used_by + ")";
    if (!access) {
      found.add(problem, whose + " is not there",
                "is it plugged in and enabled (device tree overlay, dtparam=), its module loaded? names that stay: "
                "/dev/serial/by-id, /dev/v4l/by-id, or a udev rule");
      continue;
    }
    const std::string rights = whose + " is " + octal(access->mode) + ", group " + access->group;
    if (!access->ours)
      found.add(problem, rights + ": this user may not use it",
                "a udev rule gives the device to a group, and the user into the group: usermod -aG " + access->group +
                    " USER (docs/porting.md)");
    else if ((access->mode & 0066) == 0)
      found.add(warning, rights + ": for its owner alone",
                "a service runs as another user: a udev rule gives it to a group (docs/porting.md)");
    else
      found.fine(rights);
  }
  if (demand.nodes.empty()) found.fine("the robot file names no files in /dev");
  return found.check();
}

void look_at_can(const SystemFiles& files, const SystemDemand& demand, const SystemDemand::Can& can, Findings& found) {
  const std::string folder = "sys/class/net/" + can.interface + "/";
  const std::string whose = can.interface + " (" + can.used_by + ")";
  const auto type = files.number(folder + "type");
  if (!type)
    return found.add(
        problem, whose + " is not there",
        "is its controller enabled (device tree overlay), its module loaded? names that stay: a .link file");
  if (*type != kCanType) return found.add(problem, whose + " is no CAN interface", "name another one");
  std::uint64_t flags = 0;  // "0x40081"
  const std::string text = files.text(folder + "flags").value_or("");
  if (text.starts_with("0x")) std::from_chars(text.data() + 2, text.data() + text.size(), flags, 16);
  if ((flags & 1) == 0)
    found.add(problem, whose + " is down",
              "ip link set " + can.interface + " up type can bitrate " +
                  std::to_string(can.bit_rate ? can.bit_rate : 1'000'000) +
                  " restart-ms 100; for good: a .network file");
  const auto queue = files.number(folder + "tx_queue_len");
  if (queue && *queue < kShortCanQueue)
    found.add(warning, whose + " queues " + std::to_string(*queue) + " frames: a burst is refused",
              "ip link set " + can.interface + " txqueuelen 128; for good: TransmitQueueLength= in a .link file");
  const auto facts = demand.can_facts ? demand.can_facts(can.interface) : std::nullopt;
  if (!facts) return (flags & 1) ? found.fine(whose + " is up; its bit rate is not told here") : void();
  if (facts->bit_rate == 0) return found.fine(whose + " has no bit rate (a virtual bus)");
  if (can.bit_rate != 0 && facts->bit_rate != can.bit_rate)
    found.add(problem,
              whose + " runs at " + std::to_string(facts->bit_rate) + " bit/s, the robot file says " +
                  std::to_string(can.bit_rate),
              "one of them is wrong: all nodes of a bus have the same");
  if (facts->bus_off)
    found.add(problem, whose + " is bus-off", "cable, termination (2 x 120 Ohm), bit rate of all nodes");
  if (facts->restart_ms == 0)
    found.add(warning, whose + " stays off after bus-off (restart-ms 0)",
              "ip link set " + can.interface + " type can restart-ms 100; for good: RestartSec= in a .network file");
  found.fine(whose + ": " + std::to_string(facts->bit_rate) + " bit/s");
}

SystemCheck can(const SystemFiles& files, const SystemDemand& demand) {
  Findings found("can");
  for (const auto& one : demand.can) look_at_can(files, demand, one, found);
  if (demand.can.empty()) found.fine("the robot file names no CAN interfaces of the kernel");
  return found.check();
}

/// The kernel's build options that these devices need.
std::set<std::string> options_for(const SystemDemand& demand) {
  std::set<std::string> options;
  constexpr std::pair<const char*, const char*> kNodes[] = {{"/dev/i2c-", "CONFIG_I2C_CHARDEV"},
                                                            {"/dev/spidev", "CONFIG_SPI_SPIDEV"},
                                                            {"/dev/video", "CONFIG_VIDEO_DEV"},
                                                            {"/dev/gpiochip", "CONFIG_GPIO_CDEV"},
                                                            {"/dev/watchdog", "CONFIG_WATCHDOG"}};
  for (const auto& node : demand.nodes)
    for (const auto& [path, option] : kNodes)
      if (node.path.starts_with(path)) options.insert(option);
  if (!demand.can.empty()) options.insert({"CONFIG_CAN", "CONFIG_CAN_RAW"});
  if (demand.iio) options.insert({"CONFIG_IIO", "CONFIG_IIO_BUFFER"});
  return options;
}

SystemCheck kernel_options(const SystemFiles& files, const SystemDemand& demand) {
  std::string missing, there;
  for (const auto& option : options_for(demand)) {
    const auto value = files.kernel_option(option);
    if (!value)
      return {"kernel_options", unknown, "the kernel's configuration cannot be read",
              "modprobe configs, or look for the /boot/config of this kernel"};
    std::string& list = value->empty() ? missing : there;
    list += (list.empty() ? "" : ", ") + option;
  }
  if (missing.empty())
    return {"kernel_options", ok, there.empty() ? "no device asks for a part of the kernel" : "there: " + there, ""};
  return {"kernel_options", problem, "the kernel was built without " + missing,
          "another kernel, or one built with them (docs/porting.md)"};
}

SystemCheck swap(const SystemFiles& files) {
  const auto swaps = files.text("proc/swaps");
  if (!swaps) return {"swap", unknown, "whether memory is swapped cannot be read", ""};
  std::string used;
  for (std::size_t at = swaps->find('\n'); at != std::string::npos; at = swaps->find('\n', at + 1)) {
    const std::string name = swaps->substr(at + 1, swaps->find_first_of(" \t\n", at + 1) - at - 1);
    if (!name.empty() && name.find("zram") == std::string::npos) used += (used.empty() ? "" : ", ") + name;
  }
  if (used.empty()) return {"swap", ok, "nothing is swapped to a disk", ""};
  return {"swap", warning, "memory of other programs is swapped to " + used + ": the card is busy when it is needed",
          "swapoff -a, and take it out of /etc/fstab; the robot's own memory is locked"};
}

SystemCheck root_file_system(const SystemFiles& files) {
  const std::string mounts = "\n" + files.text("proc/mounts").value_or("");
  std::string type, options;
  for (std::size_t at = 0; (at = mounts.find(" / ", at)) != std::string::npos; ++at) {  // the last one is on top
    const auto type_end = mounts.find(' ', at + 3);
    if (type_end == std::string::npos) continue;
    type = mounts.substr(at + 3, type_end - at - 3);
    options = mounts.substr(type_end + 1, mounts.find_first_of(" \n", type_end + 1) - type_end - 1);
  }
  if (options.empty()) return {"root", unknown, "how the root file system is mounted cannot be read", ""};
  if (type == "overlay" || ("," + options + ",").find(",ro,") != std::string::npos)
    return {"root", ok, "a power cut does not reach the root file system (" + type + ")", ""};
  return {"root", warning, "the root file system (" + type + ") is writable: a power cut can damage it",
          "mount it read-only, with a partition of its own for runs (docs/porting.md)"};
}

SystemCheck clock_sync(const SystemFiles& files) {
  const SystemCheck good{"clock_sync", ok, "the wall clock follows a time server", ""};
  const SystemCheck bad{"clock_sync", warning,
                        "the wall clock follows no time server: names and dates of runs may be wrong",
                        "chrony or systemd-timesyncd; without a network a real-time clock with a battery"};
  if (files.is_live()) {
    timex state{};  // only asks
    return adjtimex(&state) == TIME_ERROR || (state.status & STA_UNSYNC) != 0 ? bad : good;
  }
  if (files.access("run/systemd/timesync/synchronized")) return good;
  return {"clock_sync", unknown, "whether the wall clock is right cannot be read", ""};
}

}  // namespace

void check_board(const SystemFiles& files, const SystemDemand& demand, std::vector<SystemCheck>& checks) {
  if (!demand.real_board) return;
  checks.push_back(devices(files, demand));
  checks.push_back(can(files, demand));
  checks.push_back(kernel_options(files, demand));
  checks.push_back(swap(files));
  checks.push_back(root_file_system(files));
  checks.push_back(clock_sync(files));
}

}  // namespace sinew::hal
