#include "apps/robot_file/policy_reader.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "policy/policy.hpp"
#include "rt/graph_check.hpp"

namespace sinew::app {
namespace {

using policy::Commanded;
using policy::Observed;
using policy::Shaping;

constexpr rt::Duration kLongestAge = std::chrono::hours(1);
constexpr double kMostNumber = 1e30;

/// A number, or an array of such.
bool read_numbers_or_one(TomlReader& r, std::string_view key, std::vector<double>& out) {
  const toml::node* node = r.take(key);
  if (!node) return false;
  const auto number = [](const toml::node& n) -> std::optional<double> {
    const auto v = n.is_boolean() ? std::nullopt : n.value<double>();
    return v && std::abs(*v) <= kMostNumber ? v : std::nullopt;
  };
  bool good = true;
  if (const toml::array* array = node->as_array()) {
    good = !array->empty() && array->size() <= 4096;
    for (std::size_t i = 0; good && i < array->size(); ++i) {
      const auto v = number((*array)[i]);
      good = v.has_value();
      if (v) out.push_back(*v);
    }
  } else {
    const auto v = number(*node);
    good = v.has_value();
    if (v) out.push_back(*v);
  }
  if (!good) r.problem(*node, key, "a number, or an array with one for each of the fields");
  return good;
}

void read_shaping(TomlReader& r, std::vector<Shaping>& all) {
  std::vector<double> scale, offset;
  read_numbers_or_one(r, "scale", scale);
  read_numbers_or_one(r, "offset", offset);
  std::optional<double> low, high;
  if (const toml::node* node = r.take("clip")) {
    const toml::array* pair = node->as_array();
    const bool two = pair && pair->size() == 2 && (*pair)[0].is_number() && (*pair)[1].is_number();
    if (two) low = (*pair)[0].value<double>(), high = (*pair)[1].value<double>();
    if (!two || !(*low <= *high)) r.problem(*node, "clip", "[smallest, largest], two numbers in this order");
  }
  const std::size_t n = std::max<std::size_t>({1, scale.size(), offset.size()});
  if (scale.size() > 1 && offset.size() > 1 && scale.size() != offset.size())
    r.problem(*r.raw().get("offset"), "offset", "as many numbers as scale has: " + std::to_string(scale.size()));
  for (std::size_t i = 0; i < n; ++i) {
    Shaping s{1, 0, low, high};
    if (!scale.empty()) s.scale = scale.size() == 1 ? scale[0] : scale[std::min(i, scale.size() - 1)];
    if (!offset.empty()) s.offset = offset.size() == 1 ? offset[0] : offset[std::min(i, offset.size() - 1)];
    all.push_back(s);
  }
}

void read_fields(TomlReader& r, std::vector<std::string>& fields, std::string_view example) {
  std::vector<rt::Located<std::string>> names;
  r.read_names("fields", names);
  for (const auto& name : names) fields.push_back(name.value);
  if (fields.empty()) r.missing("fields", "numbers of the message: " + std::string(example));
  if (fields.size() > policy::kMostEntries)
    r.problems().push_back(
        {r.line(), r.full("fields"), std::to_string(fields.size()), "at most " + std::to_string(policy::kMostEntries)});
}

std::uint32_t read_steps(TomlReader& r, std::string_view key, std::uint32_t otherwise, std::int64_t min,
                         std::int64_t max) {
  std::int64_t steps = 0;
  return r.read(key, steps, min, max) ? static_cast<std::uint32_t>(steps) : otherwise;
}

void read_observed(TomlReader& r, policy::PolicyOptions& o, std::uint32_t delay, rt::ModuleSpec& m) {
  Observed e;
  e.line = r.line();
  e.key = r.path();
  r.read("input", e.input, "an input of the network");
  r.read("topic", e.topic, "the name of a topic, e.g. \"imu.raw\"");
  r.read("output", e.output, "an output of the network: as it was in the step before");
  double value = 0;
  if (r.read("value", value, -kMostNumber, kMostNumber)) e.value = value;
  if (r.has("topic") + r.has("output") + r.has("value") != 1)
    r.problems().push_back({e.line, e.key, "", "exactly one of topic, output, value"});
  if (!e.topic.empty()) {
    read_fields(r, e.fields, "[\"gyro_radps.x\", \"gyro_radps.y\"]");
    const std::string port = policy::topic_port(e.topic);
    const auto bound = m.in.emplace(port, rt::Located<std::string>{e.topic, line_of(*r.raw().get("topic"))}).first;
    if (bound->second.value != e.topic)
      r.problem(*r.raw().get("topic"), "topic",
                "a name that differs from " + rt::quoted(bound->second.value) + " in letters or digits");
    rt::Duration age{};
    if (r.read_time("max_age_ms", age, 1e6, std::chrono::milliseconds(1), kLongestAge)) {
      const auto given = m.max_age.emplace(port, age).first;
      given->second = std::min(given->second, age);
    }
  }
  if (!e.value) read_shaping(r, e.shaping);
  e.history = read_steps(r, "history", 1, 1, policy::kMostHistory);
  e.delay = read_steps(r, "delay", delay, 0, policy::kMostDelay);
  o.observed.push_back(std::move(e));
}

void read_commanded(TomlReader& r, policy::PolicyOptions& o) {
  Commanded c;
  c.line = r.line();
  c.key = r.path();
  r.require("to", c.to, "a name for the output of this module, e.g. \"motor\"; it is required");
  if (!c.to.empty() && (!rt::is_name(c.to) || c.to == "state" || c.to == "vectors"))
    r.problems().push_back(
        {c.line, r.full("to"), rt::quoted(c.to), "a name of a-z, 0-9 and _ other than state and vectors"});
  read_fields(r, c.fields, "[\"value[0]\", \"value[1]\"]");
  r.read("output", c.output, "an output of the network");
  c.index = read_steps(r, "index", 0, 0, 65535);
  double value = 0;
  if (r.read("value", value, -kMostNumber, kMostNumber)) c.value = value;
  if (c.value && (r.has("output") || r.has("index")))
    r.problems().push_back({c.line, r.path(), "", "value, or output and index"});
  read_shaping(r, c.shaping);
  c.delay = read_steps(r, "delay", 0, 0, policy::kMostDelay);
  o.commanded.push_back(std::move(c));
}

}  // namespace

void read_policy(TomlReader& r, RobotFile& robot, rt::ModuleSpec& m) {
  policy::PolicyOptions o;
  o.name = m.name;
  o.line = m.line;
  const auto file = std::make_shared<policy::PolicyFile>();
  r.require("file", file->path, "the path of an ONNX file, beside this one; it is required");
  o.file_line = r.raw().get("file") ? line_of(*r.raw().get("file")) : m.line;
  file->problem = "it was not read";
  o.history = read_steps(r, "history", 1, 1, policy::kMostHistory);
  r.read_choice("order", o.newest_first, {{"oldest_first", false}, {"newest_first", true}});
  const std::uint32_t delay = read_steps(r, "delay", 0, 0, policy::kMostDelay);
  r.table("recurrent", [&](TomlReader& t) {
    o.recurrent_line = t.line();
    for (const auto& [key, node] : t.raw()) {
      std::string output;
      if (t.read(key.str(), output, "an output of the network")) o.recurrent.emplace(std::string(key.str()), output);
    }
  });
  r.array_of_tables("observe", [&](TomlReader& t) { read_observed(t, o, delay, m); });
  r.array_of_tables("command", [&](TomlReader& t) { read_commanded(t, o); });
  for (const auto& [key, count] : {std::pair{"observe", o.observed.size()}, {"command", o.commanded.size()}}) {
    if (count == 0) r.missing(key, "at least one [[module." + m.name + "." + key + "]]");
    if (count > policy::kMostEntries)
      r.problems().push_back(
          {m.line, r.full(key), std::to_string(count), "at most " + std::to_string(policy::kMostEntries)});
  }
  if (const std::size_t topics = policy::observed_topics(o).size(); topics > msg::kMaxPolicyTopics)
    r.problems().push_back({m.line, r.full("observe"), std::to_string(topics) + " topics",
                            "fields of at most " + std::to_string(msg::kMaxPolicyTopics) + " topics"});
  m.make = [o, file] { return std::make_unique<policy::Policy>(o, file); };
  robot.policies.push_back({std::move(o), file});
}

void read_networks(RobotFile& robot) {
  namespace fs = std::filesystem;
  for (PolicyTable& p : robot.policies) {
    policy::PolicyFile& file = *p.file;
    if (file.path.empty()) continue;
    const fs::path beside = fs::path(robot.place_of(p.options.file_line).file).parent_path();
    const fs::path path = beside / file.path;
    file.bytes.clear();
    file.place = path.string();
    std::error_code none;
    if (!fs::is_regular_file(path, none)) {
      file.problem = path.string() + ": no such file";
      continue;
    }
    if (const auto size = fs::file_size(path, none); size > onnx::kMostFileBytes) {
      file.problem =
          "it has " + std::to_string(size) + " bytes; at most " + std::to_string(onnx::kMostFileBytes) + " are read";
      continue;
    }
    std::ifstream in(path, std::ios::binary);
    file.bytes.assign(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
    file.problem = in.bad() || file.bytes.empty() ? path.string() + ": it cannot be read" : "";
  }
}

}  // namespace sinew::app
