#include "apps/robot_file/device_table_reader.hpp"

namespace sinew::app {
namespace {

void read_keys(TomlReader& r, drivers::DeviceSpec& spec) {
  for (const auto& [key, node] : r.raw()) {
    const std::string_view name = key.str();
    if (name == "driver" || name == "joint" || name == "name") continue;
    if (node.is_array_of_tables() && (name == "drive" || name == "command" || name == "message")) continue;
    r.take(name);
    rt::Located<rt::ParamValue> value;
    value.line = line_of(node);
    if (read_param_value(node, value.value))
      spec.keys.emplace(std::string(name), std::move(value));
    else
      r.problem(node, name, "a boolean, a number or a string");
  }
}

}  // namespace

void read_device(const std::string& name, TomlReader& r, std::vector<drivers::DeviceSpec>& out) {
  drivers::DeviceSpec spec;
  spec.name = name;
  spec.line = r.line();
  r.require("driver", spec.driver, "the name of a driver, e.g. \"iio\"; it is required");
  if (const toml::node* node = r.raw().get("name")) {  // for a device an ordinary key, for a joint its name
    rt::Located<rt::ParamValue> value{{}, line_of(*node)};
    r.take("name");
    if (read_param_value(*node, value.value)) spec.keys.emplace("name", std::move(value));
  }
  read_keys(r, spec);
  r.array_of_tables("joint", [&](TomlReader& j) {
    drivers::DeviceSpec joint;
    joint.line = j.line();
    j.require("name", joint.name, "the name of the joint; it is required");
    j.require("driver", joint.driver, "the protocol of its servo, e.g. \"cia402\"; it is required");
    read_keys(j, joint);
    spec.joints.push_back(std::move(joint));
  });
  for (const auto& [key, tables] :
       {std::pair{"drive", &spec.drives}, std::pair{"command", &spec.commands}, std::pair{"message", &spec.messages}})
    if (const toml::node* node = r.raw().get(key); node && node->is_array_of_tables())
      r.array_of_tables(key, [&, list = tables](TomlReader& t) {
        drivers::DeviceSpec part;
        part.line = t.line();
        t.require("name", part.name, "a name; it is required");
        read_keys(t, part);
        list->push_back(std::move(part));
      });
  out.push_back(std::move(spec));
}

}  // namespace sinew::app
