#include "hal/linux/devices/iio_device.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <utility>

#include "hal/linux/open_error.hpp"

namespace sinew::hal {
namespace {

constexpr const char* kFolder = "/sys/bus/iio/devices";
constexpr OpenHint kNoFile{"the driver does not offer it"};

/// A small text file without the white space at its end. Errors: as open_error().
Result<std::string> read_file(const std::string& path, std::string& why) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return open_error(path, errno, kNoFile, "iio: open", why);
  std::array<char, 4096> space{};
  const ssize_t n = ::read(fd, space.data(), space.size());
  const int e = errno;
  ::close(fd);
  if (n < 0) {
    why = path + ": cannot be read: " + errno_text(e);
    return Error{e == ENODEV ? Errc::closed : Errc::io, "iio: read", e};
  }
  std::string text(space.data(), static_cast<std::size_t>(n));
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ' || text.back() == '\0')) text.pop_back();
  return text;
}

Status write_file(const std::string& path, const std::string& text, std::string& why) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_TRUNC | O_CLOEXEC);
  if (fd < 0) return open_error(path, errno, kNoFile, "iio: open", why);
  const ssize_t n = ::write(fd, text.data(), text.size());
  const int e = errno;
  ::close(fd);
  if (n >= 0) return {};
  why = path + ": cannot be set to '" + text + "': " + errno_text(e);
  if (e == EBUSY) {
    why += "; another program uses this device (iiod, iio-sensor-proxy: sudo systemctl stop iio-sensor-proxy)";
    return Error{Errc::busy, "iio: write", e};
  }
  return Error{e == EINVAL ? Errc::bad_argument : Errc::io, "iio: write", e};
}

bool exists(const std::string& path) { return ::access(path.c_str(), F_OK) == 0; }

/// Names in a folder that begin with `begin`, sorted.
std::vector<std::string> names_in(const std::string& folder, std::string_view begin) {
  std::vector<std::string> out;
  std::error_code ignored;  // no folder: nothing in it
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored))
    if (std::string name = entry.path().filename().string(); name.starts_with(begin)) out.push_back(std::move(name));
  std::sort(out.begin(), out.end());
  return out;
}

std::string joined(const std::vector<std::string>& parts) {
  std::string out;
  for (const std::string& p : parts) out += (out.empty() ? "" : ", ") + p;
  return out.empty() ? "none" : out;
}

std::string as_text(double value) {
  std::string s = std::to_string(value);  // six digits, as sysfs reads them
  while (s.find('.') != std::string::npos && (s.back() == '0' || s.back() == '.')) {
    const bool point = s.back() == '.';
    s.pop_back();
    if (point) break;
  }
  return s;
}

constexpr std::array<const char*, 3> kAxis{"_x", "_y", "_z"};

}  // namespace

msg::Vec3 IioAxes::to_board(const std::array<double, 3>& raw) const {
  std::array<double, 3> v{};
  for (std::size_t i = 0; i < 3; ++i) v[i] = (raw[i] + offset[i]) * scale[i];
  const auto row = [&](std::size_t r) {
    return mount[3 * r] * v[0] + mount[3 * r + 1] * v[1] + mount[3 * r + 2] * v[2];
  };
  return {row(0), row(1), row(2)};
}

Result<std::unique_ptr<IioDevice>> IioDevice::find(const std::string& root, const std::string& name, std::string& why) {
  const std::string base = root == "/" ? "" : root, folder = base + kFolder;
  std::vector<std::string> found, seen;
  std::string title;
  for (const std::string& entry : names_in(folder, "iio:device")) {
    std::string ignored;
    const auto own = read_file(folder + "/" + entry + "/name", ignored);
    const auto label = read_file(folder + "/" + entry + "/label", ignored);
    const std::string shown = entry + " (" + (own ? *own : "without name") + ")";
    seen.push_back(shown);
    if (name != entry && (!own || name != *own) && (!label || name != *label)) continue;
    found.push_back(entry);
    title = shown;
  }
  if (found.size() == 1) return std::unique_ptr<IioDevice>(new IioDevice(base, found[0], title));
  if (found.size() > 1) {
    why = "iio device '" + name + "': " + joined(found) + " have this name; write which one";
    return Error{Errc::bad_argument, "iio: two devices"};
  }
  why = "iio device '" + name + "': not in " + folder + "; there is: " + joined(seen);
  if (seen.empty()) why += " (is its driver loaded, and on its bus?)";
  return Error{Errc::not_found, "iio: device"};
}

IioDevice::IioDevice(std::string root, std::string entry, std::string title)
    : root_(std::move(root)),
      entry_(std::move(entry)),
      title_(std::move(title)),
      folder_(root_ + kFolder + "/" + entry_) {}

IioDevice::~IioDevice() {
  if (fd_ >= 0) {
    ::close(fd_);
    std::string ignored;  // it may be unplugged; then there is nothing to stop
    (void)write_file(file("buffer/enable"), "0", ignored);
  }
  for (const Sensor3& s : sensors_)
    for (const int fd : s.raw_fd)
      if (fd >= 0) ::close(fd);
}

bool IioDevice::has(std::string_view sensor) const {
  return exists(file("in_" + std::string(sensor) + "_x_raw")) ||
         exists(file("scan_elements/in_" + std::string(sensor) + "_x_en"));
}

std::string IioDevice::channels() const { return joined(names_in(folder_, "in_")); }

Status IioDevice::set_up(const IioSpec& spec, bool buffered, const std::vector<std::string>& sensors,
                         std::string& why) {
  if (buffered && (!exists(file("scan_elements")) || !exists(file("buffer/enable")))) {
    why = title_ + ": its driver has no buffer (no interrupt or trigger?)";
    return Error{Errc::not_supported, "iio: buffer"};
  }
  if (buffered)  // exclusive, before a setting of another program is changed
    if (auto done = open_node(why); !done) return done;
  if (auto done = end_left_stream(buffered, why); !done) return done;
  if (buffered && !spec.trigger.empty())
    if (auto done = set_trigger(spec, why); !done) return done;
  if (auto done = set_rate(spec, buffered, why); !done) return done;
  sensors_.clear();
  for (const std::string& name : sensors) {
    sensors_.push_back({.name = name, .axes = {}, .channel = {}, .raw_fd = {-1, -1, -1}});
    if (auto done = read_axes(sensors_.back(), why); !done) return done;
  }
  return {};
}

/// Ends a buffer that a killed program left on: nothing can be set while it is on. Opening the node says busy when
/// another program reads it.
Status IioDevice::end_left_stream(bool keep_node, std::string& why) {
  std::string ignored;
  if (const auto on = read_file(file("buffer/enable"), ignored); !on || *on != "1") return {};
  if (!keep_node)
    if (auto done = open_node(why); !done) return done;
  const Status ended = write_file(file("buffer/enable"), "0", why);
  if (!keep_node) ::close(std::exchange(fd_, -1));
  return ended;
}

Status IioDevice::open_node(std::string& why) {
  const std::string path = root_ + "/dev/" + entry_;
  fd_ = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (fd_ < 0) return open_error(path, errno, {"its driver has no buffer"}, "iio: open", why);
  return {};
}

Status IioDevice::set_rate(const IioSpec& spec, bool buffered, std::string& why) {
  if (spec.rate_hz <= 0) return {};
  bool any = !spec.trigger.empty() || !buffered;  // true: the trigger, or our own polling, makes the rate
  for (const char* name : {"sampling_frequency", "in_accel_sampling_frequency", "in_anglvel_sampling_frequency"}) {
    if (!exists(file(name))) continue;
    any = true;
    if (auto done = write_file(file(name), as_text(spec.rate_hz), why); !done) {
      std::string ignored;
      for (const std::string& list : {std::string(name) + "_available", std::string("sampling_frequency_available")})
        if (const auto allowed = read_file(file(list), ignored)) {
          why += "; it takes: " + *allowed;
          break;
        }
      return done;
    }
  }
  if (any) return {};
  why = title_ + ": has no sampling_frequency; leave rate_hz out, or name a trigger that has one";
  return Error{Errc::bad_argument, "iio: rate"};
}

Status IioDevice::set_trigger(const IioSpec& spec, std::string& why) {
  const std::string folder = root_ + kFolder;
  std::vector<std::string> seen;
  for (const std::string& entry : names_in(folder, "trigger")) {
    std::string ignored;
    const auto name = read_file(folder + "/" + entry + "/name", ignored);
    if (!name) continue;
    seen.push_back(*name);
    if (*name != spec.trigger) continue;
    const std::string rate = folder + "/" + entry + "/sampling_frequency";
    if (spec.rate_hz > 0 && exists(rate))
      if (auto done = write_file(rate, as_text(spec.rate_hz), why); !done) return done;
    return write_file(file("trigger/current_trigger"), spec.trigger, why);
  }
  why = "iio trigger '" + spec.trigger + "': there is: " + joined(seen);
  return Error{Errc::bad_argument, "iio: trigger"};
}

Result<double> IioDevice::number_of(std::initializer_list<std::string> names, double otherwise, std::string& why) {
  for (const std::string& name : names) {
    if (!exists(file(name))) continue;
    const auto text = read_file(file(name), why);
    if (!text) return text.error();
    if (const auto value = wire::parse_iio_number(*text)) return *value;
    why = file(name) + ": '" + *text + "' is not a number";
    return Error{Errc::bad_data, "iio: number"};
  }
  return otherwise;
}

Status IioDevice::read_axes(Sensor3& s, std::string& why) {
  const std::string in = "in_" + s.name;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto scale = number_of({in + kAxis[i] + "_scale", in + "_scale"}, 0, why);
    if (!scale) return scale.error();
    const auto offset = number_of({in + kAxis[i] + "_offset", in + "_offset"}, 0, why);
    if (!offset) return offset.error();
    if (*scale == 0) {
      why = title_ + ": " + in + "_scale is missing or 0: its numbers mean nothing";
      return Error{Errc::bad_data, "iio: scale"};
    }
    s.axes.scale[i] = *scale;
    s.axes.offset[i] = *offset;
  }
  for (const std::string& name : {in + "_mount_matrix", std::string("in_mount_matrix"), std::string("mount_matrix")}) {
    if (!exists(file(name))) continue;
    const auto text = read_file(file(name), why);
    if (!text) return text.error();
    const auto matrix = wire::parse_iio_mount_matrix(*text);
    if (!matrix) {
      why = file(name) + ": '" + *text + "' is not \"x1, y1, z1; x2, y2, z2; x3, y3, z3\"";
      return Error{Errc::bad_data, "iio: mount matrix"};
    }
    s.axes.mount = *matrix;
    break;
  }
  return {};
}

Status IioDevice::choose_elements(std::string& why) {
  std::vector<std::string> wanted{"in_timestamp_en"};
  for (const Sensor3& s : sensors_)
    for (const char* axis : kAxis) wanted.push_back("in_" + s.name + axis + "_en");
  for (const std::string& name : names_in(file("scan_elements"), "in_")) {
    if (!name.ends_with("_en")) continue;
    const bool on = std::find(wanted.begin(), wanted.end(), name) != wanted.end();
    if (auto done = write_file(file("scan_elements/" + name), on ? "1" : "0", why); !done) return done;
  }
  return {};
}

Status IioDevice::read_layout(std::string& why) {
  layout_ = {};
  std::map<std::string, std::uint32_t> index_of;
  for (const std::string& name : names_in(file("scan_elements"), "in_")) {
    if (!name.ends_with("_en")) continue;
    const std::string element = name.substr(0, name.size() - 3), path = file("scan_elements/" + element);
    const auto on = read_file(path + "_en", why);
    if (!on) return on.error();
    if (*on != "1") continue;  // a driver may keep other elements on: each element that is on lies in the scan
    const auto index = number_of({"scan_elements/" + element + "_index"}, -1, why);
    if (!index) return index.error();
    const auto text = read_file(path + "_type", why);
    if (!text) return text.error();
    const auto form = wire::parse_iio_form(*text);
    if (!form) {
      why = path + "_type: '" + *text + "' is not like \"le:s16/16>>0\"";
      return Error{Errc::bad_data, "iio: type"};
    }
    if (*index < 0 || *index > 1000 || !layout_.add(static_cast<std::uint32_t>(*index), *form)) {
      why = path + "_index: missing, out of range, or twice the same";
      return Error{Errc::bad_data, "iio: index"};
    }
    index_of[element] = static_cast<std::uint32_t>(*index);
  }
  const auto channel = [&](const std::string& element) -> const wire::IioChannel* {
    const auto at = index_of.find(element);
    return at == index_of.end() ? nullptr : layout_.find(at->second);
  };
  stamp_ = channel("in_timestamp");
  for (Sensor3& s : sensors_)
    for (std::size_t i = 0; i < 3; ++i) {
      s.channel[i] = channel("in_" + s.name + kAxis[i]);
      if (s.channel[i]) continue;
      why = file("scan_elements/in_" + s.name + kAxis[i] + "_en") + ": cannot be switched on";
      return Error{Errc::bad_data, "iio: element"};
    }
  if (layout_.scan_bytes() <= part_.size()) return {};
  why = title_ + ": a scan of " + std::to_string(layout_.scan_bytes()) + " bytes is longer than any IMU's";
  return Error{Errc::bad_data, "iio: scan"};
}

Status IioDevice::start_buffer(const IioSpec& spec, std::string& why) {
  if (exists(file("current_timestamp_clock"))) {
    if (auto done = write_file(file("current_timestamp_clock"), "monotonic", why); !done) return done;
    monotonic_ = true;
  }
  if (auto done = choose_elements(why); !done) return done;
  if (auto done = read_layout(why); !done) return done;
  if (auto done = write_file(file("buffer/length"), std::to_string(std::max(2u, spec.buffer_length)), why); !done)
    return done;
  std::string ignored;  // older kernels have no watermark, and behave like 1
  if (exists(file("buffer/watermark"))) (void)write_file(file("buffer/watermark"), "1", ignored);

  if (auto done = write_file(file("buffer/enable"), "1", why); !done) {
    if (done.error().code != Errc::bad_argument) return done;
    why += "; the buffer needs a trigger: name one (ls " + root_ + kFolder + "/trigger*/name)";
    return Error{Errc::not_supported, "iio: no trigger", done.error().detail};
  }
  part_size_ = 0;
  return {};
}

Status IioDevice::start_polling(std::string& why) {
  for (Sensor3& s : sensors_)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::string path = file("in_" + s.name + kAxis[i] + "_raw");
      s.raw_fd[i] = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
      if (s.raw_fd[i] < 0) return open_error(path, errno, kNoFile, "iio: open", why);
    }
  return {};
}

Result<std::size_t> IioDevice::read(std::span<std::uint8_t> into) noexcept {
  const std::size_t scan = layout_.scan_bytes();
  if (scan == 0 || into.size() < scan) return Error{Errc::bad_argument, "iio: read"};
  std::copy_n(part_.begin(), part_size_, into.begin());
  const ssize_t n = ::read(fd_, into.data() + part_size_, into.size() / scan * scan - part_size_);
  if (n < 0) {
    if (errno == EAGAIN || errno == EINTR) return std::size_t{0};
    return Error{errno == ENODEV ? Errc::closed : Errc::io, "iio: read", errno};
  }
  const std::size_t size = part_size_ + static_cast<std::size_t>(n), whole = size / scan * scan;
  part_size_ = size - whole;
  std::copy_n(into.begin() + static_cast<std::ptrdiff_t>(whole), part_size_, part_.begin());
  return whole;
}

std::array<double, 3> IioDevice::raw(std::span<const std::uint8_t> scan, std::size_t sensor) const noexcept {
  std::array<double, 3> out{};
  for (std::size_t i = 0; i < 3; ++i) out[i] = static_cast<double>(wire::iio_raw(scan, *sensors_[sensor].channel[i]));
  return out;
}

std::optional<std::int64_t> IioDevice::stamp(std::span<const std::uint8_t> scan) const noexcept {
  if (!stamp_) return {};
  return wire::iio_raw(scan, *stamp_);
}

Result<std::array<double, 3>> IioDevice::poll(std::size_t sensor) noexcept {
  std::array<double, 3> out{};
  for (std::size_t i = 0; i < 3; ++i) {
    std::array<char, 64> text{};
    const ssize_t n = ::pread(sensors_[sensor].raw_fd[i], text.data(), text.size(), 0);
    if (n < 0) return Error{errno == ENODEV ? Errc::closed : Errc::io, "iio: poll", errno};
    const auto value = wire::parse_iio_number({text.data(), static_cast<std::size_t>(n)});
    if (!value) return Error{Errc::bad_data, "iio: a raw file holds no number"};
    out[i] = *value;
  }
  return out;
}

}  // namespace sinew::hal
