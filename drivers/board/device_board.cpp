#include "drivers/board/device_board.hpp"

#include <algorithm>
#include <sstream>

#include "drivers/joints/bus_check.hpp"
#include "hal/camera_memory.hpp"

namespace sinew::drivers {
namespace {

const DriverKind* find_driver(std::span<const DriverKind> drivers, std::string_view name) {
  const auto it = std::find_if(drivers.begin(), drivers.end(), [&](const DriverKind& d) { return d.name == name; });
  return it == drivers.end() ? nullptr : &*it;
}

std::vector<std::string_view> names_of(std::span<const DriverKind> drivers) {
  std::vector<std::string_view> names;
  for (const DriverKind& d : drivers) names.push_back(d.name);
  return names;
}

/// `text` with the device and its driver in front. Texts that begin with the device's name lose it: it need not be
/// there twice.
std::string titled(std::string_view name, const std::string& driver, const std::string& text) {
  const std::string begin = std::string(name) + ": ";
  return "device '" + std::string(name) + "' (driver " + driver +
         "): " + (text.starts_with(begin) ? text.substr(begin.size()) : text);
}

// Each line of `text` with the device's name in front; some drivers write the name themselves.
void add_lines(const std::string& name, const std::string& text, std::vector<std::string>& all) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    all.push_back(line.starts_with(name + ": ") || line.starts_with(name + ".") ? line : name + ": " + line);
}

}  // namespace

namespace {

/// The owner of each serial line, chip, camera and bus.
class Claims {
 public:
  void take(const DeviceKeys& keys) {
    for (const DeviceKeys::Claim& claim : keys.claims()) {
      const auto [owner, free] = owners_.emplace(claim.place, keys.path());
      if (free) continue;
      const auto key = keys.spec().keys.find(claim.key);
      problems_.push_back({key == keys.spec().keys.end() ? keys.spec().line : key->second.line,
                           keys.path() + '.' + claim.key, '"' + claim.place + '"',
                           "one that no other has: it is [" + owner->second + "]'s"});
    }
  }
  std::vector<rt::Problem> problems() { return std::move(problems_); }

 private:
  std::vector<rt::Problem> problems_;
  std::map<std::string, std::string> owners_;
};

}  // namespace

std::vector<rt::Problem> check_devices(const DeviceSpecs& specs, std::span<const DriverKind> drivers) {
  std::vector<rt::Problem> problems;
  Claims claims;
  for (const DeviceSpec& spec : specs.buses) {
    DeviceKeys keys(spec, "bus." + spec.name, problems);
    if (spec.driver == kSerialBus)
      static_cast<void>(read_serial_bus(keys));
    else
      static_cast<void>(read_can_bus(keys));
    keys.finish();
    claims.take(keys);
  }
  for (const DeviceSpec& spec : specs.devices) {
    const std::string path = "device." + spec.name;
    const DriverKind* driver = find_driver(drivers, spec.driver);
    DeviceKeys keys(spec, path, problems);
    if (!driver) {
      keys.refuse_driver(names_of(drivers));
      continue;
    }
    static_cast<void>(driver->read(keys, specs));
    keys.finish();
    claims.take(keys);
    if (!spec.joints.empty() && spec.driver != "can_servos" && spec.driver != "serial_servos")
      problems.push_back({spec.joints.front().line, path + ".joint", "[[" + path + ".joint]]",
                          "none: only the drivers can_servos and serial_servos have joints"});
    if (spec.driver == "text") continue;
    for (const auto& [what, tables] : {std::pair{".drive", &spec.drives}, std::pair{".command", &spec.commands},
                                       std::pair{".message", &spec.messages}})
      if (!tables->empty())
        problems.push_back({tables->front().line, path + what, "[[" + path + what + "]]",
                            "none: only the driver text has such tables"});
  }
  // Claims and bus loads are only checked when no table has an error of form.
  if (problems.empty()) problems = claims.problems();
  if (problems.empty()) problems = check_buses(specs);
  return problems;
}

DeviceBoard::DeviceBoard(DeviceSpecs specs, std::span<const DriverKind> drivers, hal::Connectors& connectors,
                         hal::Os& os)
    : specs_(std::move(specs)),
      drivers_(drivers),
      can_(specs_, connectors, os),
      lines_(specs_, connectors, os),
      context_{connectors, os, can_, lines_, [this](std::string_view name, std::string& why) {
                 auto other = open(name, why);
                 if (!other) tell(why), why = "device '" + std::string(name) + "' is not there";
                 return other;
               }} {}
DeviceBoard::~DeviceBoard() = default;

hal::Result<OpenedDevice*> DeviceBoard::open(std::string_view name, std::string& why) {
  if (const auto it = opened_.find(name); it != opened_.end()) return &it->second;
  const auto spec =
      std::find_if(specs_.devices.begin(), specs_.devices.end(), [&](const DeviceSpec& s) { return s.name == name; });
  const std::string device = "device '" + std::string(name) + "'";
  if (spec == specs_.devices.end()) {
    std::string known;
    for (const DeviceSpec& s : specs_.devices) known += (known.empty() ? "" : ", ") + s.name;
    why = device + ": the robot file has no [device." + std::string(name) +
          "]; it has: " + (known.empty() ? "no device at all" : known);
    return hal::Error{hal::Errc::not_found, "no [device.NAME] of this name"};
  }
  std::vector<rt::Problem> problems;  // check_devices() reported them already
  DeviceKeys keys(*spec, "device." + spec->name, problems);
  std::string because;
  auto opened = find_driver(drivers_, spec->driver)->read(keys, specs_)(context_, because);
  if (!opened) {
    why = titled(name, spec->driver, because.empty() ? hal::to_string(opened.error().code) : because);
    return opened.error();
  }
  if (!because.empty()) warnings_.push_back(device + ": " + because);
  return &opened_.emplace(spec->name, std::move(*opened)).first->second;
}

OpenedDevice* DeviceBoard::find(std::string_view name, hal::Error& error) {
  std::string why;
  auto device = open(name, why);
  if (device) return *device;
  tell(why);
  error = device.error();
  return nullptr;
}

hal::Status DeviceBoard::start() {
  std::string why;
  auto started = can_.start(why);
  if (started) started = lines_.start(why);
  if (!started) tell(why);
  return started;
}

std::vector<std::string> DeviceBoard::warnings() const {
  std::vector<std::string> all = can_.warnings();
  all.insert(all.end(), lines_.warnings().begin(), lines_.warnings().end());
  all.insert(all.end(), warnings_.begin(), warnings_.end());
  return all;
}

std::vector<std::string> DeviceBoard::complaints() const {
  std::vector<std::string> all = can_.complaints();
  for (std::string& what : lines_.complaints()) all.push_back(std::move(what));
  for (const auto& [name, device] : opened_)
    if (device.report) add_lines(name, device.report->trouble(), all);
  return all;
}

std::vector<std::string> DeviceBoard::shortfalls() const {
  std::vector<std::string> all = can_.shortfalls();
  for (std::string& what : lines_.shortfalls()) all.push_back(std::move(what));
  for (const auto& [name, device] : opened_)
    if (device.report)
      if (const std::string what = device.report->shortfall(); !what.empty())
        all.push_back("device '" + name + "': " + what);
  if (const auto* report = dynamic_cast<const hal::SelfReport*>(&context_.connectors))
    if (const std::string what = report->shortfall(); !what.empty())
      all.push_back("thread that watches the devices: " + what);
  return all;
}

void DeviceBoard::tell(const std::string& what) {
  if (("\n" + problem_ + "\n").find("\n" + what + "\n") != std::string::npos) return;
  problem_ += (problem_.empty() ? "" : "\n") + what;
}

hal::Error DeviceBoard::is_no(std::string_view name, std::string_view what) {
  tell("device '" + std::string(name) + "' is no " + std::string(what) + "; [device." + std::string(name) +
       "] has the driver of something else");
  return {hal::Errc::not_found, "a device of another kind"};
}

hal::Result<hal::Device*> DeviceBoard::open_sensor(hal::SensorKind kind, std::string_view name) {
  hal::Error error;
  OpenedDevice* device = find(name, error);
  if (!device) return error;
  if (hal::Device* sensor = device->sensor(kind)) return sensor;
  return is_no(name, hal::to_string(kind));
}

hal::Result<hal::Camera*> DeviceBoard::camera(std::string_view name) {
  hal::Error error;
  OpenedDevice* device = find(name, error);
  if (!device) return error;
  if (device->camera) return device->camera;
  return is_no(name, "camera");
}

hal::Result<hal::Radio*> DeviceBoard::radio(std::string_view name) {
  hal::Error error;
  OpenedDevice* device = find(name, error);
  if (!device) return error;
  if (device->radio) return device->radio;
  return is_no(name, "radio");
}

std::string DeviceBoard::notes() const {
  std::string text;
  for (const auto& [name, device] : opened_)
    if (const auto* memory = dynamic_cast<const hal::CameraMemory*>(device.camera))
      text += (text.empty() ? "" : "\n") + ("device '" + name + "': " + memory->path_of_pixels());
  return text;
}

hal::Result<hal::Actuators*> DeviceBoard::actuators(std::string_view name) {
  hal::Error error;
  OpenedDevice* device = find(name, error);
  if (!device) return error;
  if (device->actuators) return device->actuators;
  return is_no(name, "actuator group");
}

}  // namespace sinew::drivers
