#include "hal/linux/devices/gpio.hpp"

#include <fcntl.h>
#include <linux/gpio.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <optional>

#include "hal/linux/open_error.hpp"
#include "hal/platform.hpp"

namespace sinew::hal {
namespace {

Error gpio_error(const char* where) { return {errno == ENODEV ? Errc::closed : Errc::io, where, errno}; }

class LinuxGpio final : public Gpio {
 public:
  LinuxGpio(int fd, bool output, bool edges) : fd_(fd), output_(output), edges_(edges) {}
  ~LinuxGpio() override { ::close(fd_); }
  LinuxGpio(const LinuxGpio&) = delete;
  LinuxGpio& operator=(const LinuxGpio&) = delete;

  Result<bool> get() noexcept override {
    gpio_v2_line_values v{0, 1};
    if (::ioctl(fd_, GPIO_V2_LINE_GET_VALUES_IOCTL, &v) < 0) return gpio_error("gpio: get");
    return (v.bits & 1) != 0;
  }
  Status set(bool active) noexcept override {
    if (!output_) return Error{Errc::not_supported, "gpio: the line is an input"};
    gpio_v2_line_values v{active ? 1u : 0u, 1};
    if (::ioctl(fd_, GPIO_V2_LINE_SET_VALUES_IOCTL, &v) < 0) return gpio_error("gpio: set");
    return {};
  }
  Result<Time> wait_edge(Time deadline) noexcept override {
    if (!edges_) return Error{Errc::not_supported, "gpio: the line was opened without edges"};
    for (int n = 0; n <= 0;) {
      pollfd waiting{fd_, POLLIN, 0};
      const std::int64_t left =
          deadline == kNever ? 0 : std::max<std::int64_t>(0, (deadline - system_os().now()).count());
      const timespec limit{static_cast<time_t>(left / 1'000'000'000), static_cast<long>(left % 1'000'000'000)};
      n = ::ppoll(&waiting, 1, deadline == kNever ? nullptr : &limit, nullptr);
      if (n < 0 && errno != EINTR) return gpio_error("gpio: poll");
      if (n == 0) return Error{Errc::timeout, "gpio: no edge"};
    }
    gpio_v2_line_event event{};
    if (::read(fd_, &event, sizeof event) != static_cast<ssize_t>(sizeof event)) return gpio_error("gpio: read");
    return Time{static_cast<std::int64_t>(event.timestamp_ns)};
  }

 private:
  int fd_;
  bool output_, edges_;
};

struct Chip {
  Chip() = default;
  ~Chip() {
    if (fd >= 0) ::close(fd);
  }
  Chip(const Chip&) = delete;
  Chip& operator=(const Chip&) = delete;
  int fd = -1;
  gpiochip_info info{};
};

Status open_path(const std::string& path, Chip& chip, std::string& why) {
  constexpr OpenHint kHint{"see which there are with: gpiodetect (Debian: gpiod)"};
  chip.fd = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (chip.fd < 0) return open_error(path, errno, kHint, "gpio: open", why);
  if (::ioctl(chip.fd, GPIO_GET_CHIPINFO_IOCTL, &chip.info) >= 0) return {};
  const Error error = open_error(path, errno, kHint, "gpio: chip", why);
  if (error.code == Errc::not_supported) why = path + ": is no GPIO chip; one is called /dev/gpiochipN";
  return error;
}

Status open_chip(const std::string& name, Chip& chip, std::string& why) {
  if (name.starts_with('/')) return open_path(name, chip, why);
  std::string seen;
  std::error_code ignored;  // no /dev: nothing is found
  for (const auto& entry : std::filesystem::directory_iterator("/dev", ignored)) {
    const std::string path = entry.path().string();
    if (!path.starts_with("/dev/gpiochip")) continue;
    Chip other;
    std::string reason;
    if (!open_path(path, other, reason)) {
      seen += (seen.empty() ? "" : "; ") + reason;
      continue;
    }
    const std::string label(other.info.label, strnlen(other.info.label, sizeof other.info.label));
    if (label == name) {
      std::swap(chip.fd, other.fd);
      chip.info = other.info;
      return {};
    }
    seen += (seen.empty() ? "" : ", ") + label;
  }
  why = "gpio chip '" + name + "': no chip has this label; there are: " + (seen.empty() ? "none" : seen);
  return Error{Errc::not_found, "gpio: chip"};
}

std::optional<std::uint32_t> find_line(const Chip& chip, const std::string& name) {
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  if (error == std::errc{} && end == name.data() + name.size())
    return number < chip.info.lines ? std::optional(number) : std::nullopt;
  for (std::uint32_t i = 0; i < chip.info.lines; ++i) {
    gpio_v2_line_info info{};
    info.offset = i;
    if (::ioctl(chip.fd, GPIO_V2_GET_LINEINFO_IOCTL, &info) < 0) continue;
    if (name == std::string(info.name, strnlen(info.name, sizeof info.name))) return i;
  }
  return {};
}

}  // namespace

Result<std::unique_ptr<Gpio>> open_gpio(const GpioSpec& spec, std::string& why) {
  if (spec.output && (spec.rising || spec.falling)) {
    why = spec.chip + " line '" + spec.line + "': an output has no edges to wait for";
    return Error{Errc::bad_argument, "gpio"};
  }
  Chip chip;
  if (auto done = open_chip(spec.chip, chip, why); !done) return done.error();
  const auto offset = find_line(chip, spec.line);
  if (!offset) {
    why = spec.chip + ": has no line '" + spec.line + "'; its lines are 0 to " + std::to_string(chip.info.lines - 1) +
          ", names: gpioinfo";
    return Error{Errc::not_found, "gpio: line"};
  }
  gpio_v2_line_request request{};
  request.offsets[0] = *offset;
  request.num_lines = 1;
  std::strncpy(request.consumer, "sinew", sizeof request.consumer - 1);
  request.config.flags = spec.output ? GPIO_V2_LINE_FLAG_OUTPUT : GPIO_V2_LINE_FLAG_INPUT;
  if (spec.active_low) request.config.flags |= GPIO_V2_LINE_FLAG_ACTIVE_LOW;
  if (spec.rising) request.config.flags |= GPIO_V2_LINE_FLAG_EDGE_RISING;
  if (spec.falling) request.config.flags |= GPIO_V2_LINE_FLAG_EDGE_FALLING;
  if (spec.output) {
    request.config.num_attrs = 1;
    request.config.attrs[0].mask = 1;
    request.config.attrs[0].attr.id = GPIO_V2_LINE_ATTR_ID_OUTPUT_VALUES;
    request.config.attrs[0].attr.values = spec.initial ? 1 : 0;
  }
  if (::ioctl(chip.fd, GPIO_V2_GET_LINE_IOCTL, &request) < 0) {
    const Error error = open_error(spec.chip, errno, {}, "gpio: line", why);
    if (error.code == Errc::busy) why = spec.chip + " line '" + spec.line + "': somebody holds it; see: gpioinfo";
    return error;
  }
  return std::unique_ptr<Gpio>(new LinuxGpio(request.fd, spec.output, spec.rising || spec.falling));
}

}  // namespace sinew::hal
