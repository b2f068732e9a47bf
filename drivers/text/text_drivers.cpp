#include "drivers/text/text_drivers.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "drivers/text/text_link.hpp"

namespace sinew::drivers {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// The link among the devices, for those that name it.
const DeviceSpec* find_link(const DeviceSpecs& specs, std::string_view name) {
  for (const DeviceSpec& d : specs.devices)
    if (d.name == name && d.driver == "text") return &d;
  return nullptr;
}

const DeviceSpec* read_link(DeviceKeys& keys, const DeviceSpecs& specs, std::string& name) {
  std::string all;
  for (const DeviceSpec& d : specs.devices)
    if (d.driver == "text") all += (all.empty() ? ": " : ", ") + d.name;
  const std::string allowed = "the name of a device with the driver text" + all;
  keys.read("link", name, allowed, {.doc = "the link that it is a part of", .required = true});
  const DeviceSpec* link = find_link(specs, name);
  if (!name.empty() && !link) keys.problem("link", all.empty() ? allowed + ": there is none" : allowed);
  return link;
}

/// Opens the link, which may be open already.
hal::Result<std::shared_ptr<TextLink>> open_link(DeviceContext& context, const std::string& name, std::string& why) {
  auto device = context.device(name, why);
  if (!device) return device.error();
  return std::static_pointer_cast<TextLink>((*device)->owner);
}

// ---- all values

class TextValuesSensor final : public hal::SensorQueue<msg::TextValues>, public TextSink {
 public:
  void offer(const msg::TextValues& values) noexcept override { put(values); }
  void set_link(bool up) noexcept override { set_gone(!up); }
};

DeviceOpener read_text(DeviceKeys& keys, const DeviceSpecs&) {
  const TextLinkSpec spec = read_text_link(keys);
  return [spec](DeviceContext& context, std::string& why) -> hal::Result<OpenedDevice> {
    auto link = TextLink::open(spec, context, why);
    if (!link) return link.error();
    const auto sensor = std::make_shared<TextValuesSensor>();
    (*link)->add(sensor);
    OpenedDevice device;
    device.owner = *link;  // which keeps the sensor
    device.report = link->get();
    if (!spec.drives.empty()) device.actuators = &(*link)->drives();
    device.sensor(hal::SensorKind::text) = static_cast<hal::TextRobot*>(sensor.get());
    return device;
  };
}

// ---- some of the commands

DeviceOpener read_text_commands(DeviceKeys& keys, const DeviceSpecs& specs) {
  std::string link_name, commands;
  const DeviceSpec* link = read_link(keys, specs, link_name);
  const std::string allowed = "names of its [[device.NAME.command]], with commas between";
  const bool has = keys.read("commands", commands, allowed,
                             {.doc = "the group's channels in this order", .otherwise = "all of the link"});
  std::vector<std::size_t> chosen;
  if (link) {
    std::size_t channels = 0;
    std::vector<rt::Problem> aside;  // check_devices() finds them in the link's own tables
    const auto channels_of = [&](const DeviceSpec& table) {
      DeviceKeys own(table, "", aside);
      const auto command = read_text_command(own);
      return command ? command->channels() : 1;
    };
    std::vector<std::string> names = cut_list(commands);
    if (!has)
      for (const DeviceSpec& c : link->commands) names.push_back(c.name);
    for (const std::string& name : names) {
      const auto it = std::find_if(link->commands.begin(), link->commands.end(),
                                   [&](const DeviceSpec& c) { return c.name == name; });
      if (it == link->commands.end()) {
        keys.problem("commands", allowed + ": there is no \"" + name + "\"");
        continue;
      }
      chosen.push_back(static_cast<std::size_t>(it - link->commands.begin()));
      channels += channels_of(*it);
    }
    if (channels == 0 || channels > msg::kMaxChannels) keys.problem("commands", "commands with 1 to 8 values in all");
    for (const std::string& name : names) keys.claim("commands", "command " + link_name + "." + name);
  }
  return [link_name, chosen](DeviceContext& context, std::string& why) -> hal::Result<OpenedDevice> {
    auto opened = open_link(context, link_name, why);
    if (!opened) return opened.error();
    struct Both {
      std::shared_ptr<TextLink> link;
      std::shared_ptr<TextGroup> group;
    };
    const auto both = std::make_shared<Both>(Both{*opened, (*opened)->add_commands(chosen)});
    OpenedDevice device;
    device.owner = both;
    device.actuators = both->group.get();
    return device;
  };
}

// ---- values as sensors

/// One number of a message, by the key that names the link's value of it.
template <class M>
struct TextField {
  std::string_view key, doc;
  void (*set)(M&, double);
  bool required = true;
};

template <class M>
struct TextFields;

template <>
struct TextFields<msg::RangeSample> {
  static constexpr std::array<TextField<msg::RangeSample>, 1> all{
      {{"range", "m", [](msg::RangeSample& m, double v) { m.range_m = v; }}}};
};
template <>
struct TextFields<msg::BaroSample> {
  using M = msg::BaroSample;
  static constexpr std::array<TextField<M>, 2> all{
      {{"pressure", "Pa", [](M& m, double v) { m.pressure_pa = v; }},
       {"temperature", "degrees C; else 15", [](M& m, double v) { m.temperature_c = v; }, false}}};
  static void prepare(M& m) { m.temperature_c = 15; }
};
template <>
struct TextFields<msg::BatterySample> {
  using M = msg::BatterySample;
  static constexpr std::array<TextField<M>, 3> all{{{"voltage", "V", [](M& m, double v) { m.voltage_v = v; }, false},
                                                    {"current", "A", [](M& m, double v) { m.current_a = v; }, false},
                                                    {"charge", "0 to 1", [](M& m, double v) { m.charge = v; }, false}}};
  static void prepare(M& m) { m.voltage_v = m.current_a = m.charge = kUnknown; }
};
template <>
struct TextFields<msg::MagSample> {
  using M = msg::MagSample;
  static constexpr std::array<TextField<M>, 3> all{{{"field_x", "T, base", [](M& m, double v) { m.field_t.x = v; }},
                                                    {"field_y", "T, base", [](M& m, double v) { m.field_t.y = v; }},
                                                    {"field_z", "T, base", [](M& m, double v) { m.field_t.z = v; }}}};
};
template <>
struct TextFields<msg::ImuSample> {
  using M = msg::ImuSample;
  static constexpr std::array<TextField<M>, 6> all{
      {{"gyro_x", "rad/s, base", [](M& m, double v) { m.gyro_radps.x = v; }},
       {"gyro_y", "rad/s, base", [](M& m, double v) { m.gyro_radps.y = v; }},
       {"gyro_z", "rad/s, base", [](M& m, double v) { m.gyro_radps.z = v; }},
       {"accel_x", "m/s^2, base, +g upward at rest", [](M& m, double v) { m.accel_mps2.x = v; }},
       {"accel_y", "m/s^2, base, +g upward at rest", [](M& m, double v) { m.accel_mps2.y = v; }},
       {"accel_z", "m/s^2, base, +g upward at rest", [](M& m, double v) { m.accel_mps2.z = v; }}}};
};
template <>
struct TextFields<msg::GnssSample> {
  using M = msg::GnssSample;
  static constexpr std::array<TextField<M>, 5> all{
      {{"latitude", "degrees", [](M& m, double v) { m.latitude_deg = v; }},
       {"longitude", "degrees", [](M& m, double v) { m.longitude_deg = v; }},
       {"altitude", "m above mean sea level", [](M& m, double v) { m.altitude_m = v; }, false},
       {"fix", "0: none, else there is one",
        [](M& m, double v) { m.fix = v > 0.5 ? msg::GnssFix::flat : msg::GnssFix::none; }},
       {"satellites", "used",
        [](M& m, double v) { m.satellites = static_cast<std::uint32_t>(v < 0     ? 0
                                                                       : v > 200 ? 200
                                                                                 : v); }, false}}};
  static void prepare(M& m) {
    m.altitude_m = m.horizontal_accuracy_m = m.vertical_accuracy_m = m.speed_accuracy_mps = kUnknown;
    m.velocity_mps = {kUnknown, kUnknown, kUnknown};
  }
};
template <std::size_t I>
void set_joint_position(msg::JointState& m, double v) {
  m.position_rad[I] = v;
}
template <>
struct TextFields<msg::JointState> {
  using M = msg::JointState;
  static constexpr std::array<TextField<M>, 8> all{{{"position_1", "rad", set_joint_position<0>},
                                                    {"position_2", "rad", set_joint_position<1>, false},
                                                    {"position_3", "rad", set_joint_position<2>, false},
                                                    {"position_4", "rad", set_joint_position<3>, false},
                                                    {"position_5", "rad", set_joint_position<4>, false},
                                                    {"position_6", "rad", set_joint_position<5>, false},
                                                    {"position_7", "rad", set_joint_position<6>, false},
                                                    {"position_8", "rad", set_joint_position<7>, false}}};
};

/// A sample whenever one of its values came, if all of them came within the link's time of silence: nothing that has
/// stood still goes on in a fresh sample.
template <class M>
class TextSensor final : public hal::SensorQueue<M>, public TextSink {
 public:
  struct Part {
    std::size_t value;  // of the link
    void (*set)(M&, double);
  };
  TextSensor(std::vector<Part> parts, hal::Duration oldest) : parts_(std::move(parts)), oldest_(oldest) {}
  void offer(const msg::TextValues& values) noexcept override {
    bool fresh = false;
    M sample;
    if constexpr (requires { TextFields<M>::prepare(sample); }) TextFields<M>::prepare(sample);
    if constexpr (std::is_same_v<M, msg::JointState>) prepare_joints(sample, values);
    for (const Part& part : parts_) {
      const hal::Time measured = values.measured[part.value];
      if (measured.ns == 0 || values.stamp - measured > oldest_) return;
      fresh = fresh || (values.fresh >> part.value & 1) != 0;
      part.set(sample, values.value[part.value]);
    }
    if (!fresh) return;
    sample.stamp = values.stamp;
    if constexpr (std::is_same_v<M, msg::GnssSample>)
      if (sample.fix == msg::GnssFix::none) sample.latitude_deg = sample.longitude_deg = sample.altitude_m = kUnknown;
    this->put(sample);
  }
  void set_link(bool up) noexcept override { this->set_gone(!up); }

 private:
  void prepare_joints(msg::JointState& m, const msg::TextValues& values) const {
    m.count = static_cast<std::uint32_t>(parts_.size());
    m.ready = (1u << m.count) - 1;
    m.velocity_radps.fill(kUnknown), m.effort_nm.fill(kUnknown);
    m.temperature_c.fill(kUnknown), m.voltage_v.fill(kUnknown);
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      m.measured[i] = values.measured[parts_[i].value];
      m.mode[i] = msg::JointMode::enabled;
    }
  }
  const std::vector<Part> parts_;
  const hal::Duration oldest_;
};

/// GNSS without a fix has no position in its lines.
template <class M>
bool may_be_old(std::string_view key) {
  return std::is_same_v<M, msg::GnssSample> && key != "fix";
}

template <class M>
DeviceOpener read_text_sensor(DeviceKeys& keys, const DeviceSpecs& specs) {
  std::string link_name;
  const DeviceSpec* link = read_link(keys, specs, link_name);
  using Part = typename TextSensor<M>::Part;
  std::vector<Part> parts;
  bool any = false, gap = false;
  for (const TextField<M>& field : TextFields<M>::all) {
    std::string name;
    const std::string allowed = "the name of a [[device.NAME.message]] of the link";
    const bool has =
        keys.read(field.key, name, allowed,
                  {.doc = field.doc, .otherwise = field.required ? "" : "unknown", .required = field.required});
    if constexpr (std::is_same_v<M, msg::JointState>) {
      if (has && gap) keys.problem(field.key, "no such key without the one before it");
      gap = gap || !has;
    }
    any = any || has;
    if (!has || !link) continue;
    const auto it =
        std::find_if(link->messages.begin(), link->messages.end(), [&](const DeviceSpec& m) { return m.name == name; });
    if (it == link->messages.end())
      keys.problem(field.key, allowed + ": there is no \"" + name + "\"");
    else
      parts.push_back({static_cast<std::size_t>(it - link->messages.begin()), field.set});
  }
  if (!any && !keys.told("link") && link) keys.problem("link", "and at least one of its values by a key");
  return [link_name, parts](DeviceContext& context, std::string& why) -> hal::Result<OpenedDevice> {
    auto opened = open_link(context, link_name, why);
    if (!opened) return opened.error();
    const auto sensor = std::make_shared<TextSensor<M>>(parts, (*opened)->spec().silent);
    (*opened)->add(sensor);
    OpenedDevice device;
    device.owner = *opened;
    device.sensor(hal::kSensorKind<M>) = static_cast<hal::Sensor<M>*>(sensor.get());
    return device;
  };
}

}  // namespace

std::span<const DriverKind> text_drivers() {
  static constexpr std::array<DriverKind, 9> kAll{{{"text", "actuators, text", read_text},
                                                   {"text_commands", "actuators", read_text_commands},
                                                   {"text_imu", "imu", read_text_sensor<msg::ImuSample>},
                                                   {"text_range", "range", read_text_sensor<msg::RangeSample>},
                                                   {"text_baro", "baro", read_text_sensor<msg::BaroSample>},
                                                   {"text_battery", "battery", read_text_sensor<msg::BatterySample>},
                                                   {"text_mag", "mag", read_text_sensor<msg::MagSample>},
                                                   {"text_gnss", "gnss", read_text_sensor<msg::GnssSample>},
                                                   {"text_joints", "joints", read_text_sensor<msg::JointState>}}};
  return kAll;
}

std::vector<std::pair<std::string_view, std::function<void(DeviceKeys&)>>> text_tables() {
  return {{"[[device.NAME.drive]]",
           [](DeviceKeys& keys) {
             TextDrive drive;
             read_text_drive(keys, drive);
           }},
          {"[[device.NAME.command]]", [](DeviceKeys& keys) { static_cast<void>(read_text_command(keys)); }},
          {"[[device.NAME.message]]", [](DeviceKeys& keys) {
             TextValue value;
             read_text_value(keys, TextDecoder::usarsim, value);
           }}};
}

}  // namespace sinew::drivers
