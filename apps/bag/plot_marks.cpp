#include "apps/bag/plot_marks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "apps/bag/field_remark.hpp"
#include "apps/view/message_text.hpp"
#include "record/run/run_messages.hpp"

namespace sinew::app {
namespace {

using Json = nlohmann::ordered_json;

const record::Ros2Field* field_of(const record::Ros2Schema& schema, const std::string& name) {
  for (const record::Ros2Field& field : schema.root().fields)
    if (field.name == name) return &field;
  return nullptr;
}

/// 0 for what is no number.
std::uint64_t whole_number(const Json& value) {
  if (value.is_boolean()) return value.get<bool>() ? 1 : 0;
  if (value.is_number_integer()) return value.get<std::uint64_t>();
  return value.is_number() ? static_cast<std::uint64_t>(std::llround(value.get<double>())) : 0;
}

}  // namespace

PlotMarks::PlotMarks(const TopicSchemas& topics, Names names) : names_(std::move(names)) {
  const auto watch_field = [&](const std::string& topic, const record::Ros2Schema& schema, const char* field,
                               Meaning meaning) {
    if (const auto* described = field_of(schema, field)) watched_[topic].push_back({meaning, field, "", *described});
  };
  for (const auto& [topic, schema] : topics) {
    const std::string& type = schema.root().name;
    if (type == "sinew_msgs/MissionState") watch_field(topic, schema, "phase", Meaning::change);
    if (type == "sinew_msgs/HeadState") watch_field(topic, schema, "mode", Meaning::change);
    if (type == "sinew_msgs/SafetyState") {
      watch_field(topic, schema, "acted", Meaning::failsafes);
      watch_field(topic, schema, "action", Meaning::alarm_change);
    }
    if (topic == record::kRequestsTopic) watch_field(topic, schema, "kind", Meaning::request);
  }
}

std::string PlotMarks::watch(const std::string& field, const TopicSchemas& topics) {
  for (const auto& [topic, schema] : topics) {
    if (!field.starts_with(topic + ".")) continue;
    const std::string path = field.substr(topic.size() + 1);
    const auto* described = field_of(schema, path);
    if (!described || described->shape != record::Ros2Field::Shape::one ||
        described->kind == record::Ros2Field::Kind::nested || described->kind == record::Ros2Field::Kind::text)
      return fmt::format("--mark {}: one number of a message of {}", field, topic);
    watched_[topic].push_back({Meaning::change, path, field + " ", *described});
    return {};
  }
  return fmt::format("--mark {}: no such topic", field);
}

std::vector<std::string> PlotMarks::topics() const {
  std::vector<std::string> names;
  for (const auto& [topic, watched] : watched_) names.push_back(topic);
  return names;
}

void PlotMarks::add(const std::string& topic, double time_s, const Json& message) {
  const auto watched = watched_.find(topic);
  if (watched == watched_.end()) return;
  for (Watched& one : watched->second) {
    const auto value = message.find(one.field);
    if (value == message.end()) continue;
    if (one.meaning == Meaning::request)
      add_request(time_s, message);
    else
      add_value(one, time_s, whole_number(*value));
  }
}

void PlotMarks::add_value(Watched& watched, double time_s, std::uint64_t value) {
  const std::uint64_t before = watched.last.value_or(watched.meaning == Meaning::change ? value : 0);
  watched.last = value;
  if (value == before) return;
  if (watched.meaning == Meaning::failsafes) {
    for (std::size_t bit = 0; bit < 64; ++bit)
      if (value & ~before & (std::uint64_t{1} << bit))
        marks_.push_back({time_s,
                          bit < names_.failsafes.size() ? names_.failsafes[bit] : fmt::format("failsafe {}", bit + 1),
                          true});
    return;
  }
  const bool alarm = watched.meaning == Meaning::alarm_change;
  if (alarm && value == 0) return;  // nothing is asked for any more
  marks_.push_back({time_s, watched.title + value_name(remark_of(watched.described), value), alarm});
}

void PlotMarks::add_request(double time_s, const Json& message) {
  constexpr std::array<const char*, 6> kKinds{"set a parameter of ", "enable ", "disable ",
                                              "period of ",          "arm",     "disarm"};
  const auto kind = message.value("kind", std::uint64_t{kKinds.size()});
  if (kind >= kKinds.size() || message.value("refused", false)) return;  // a message: its topic tells
  std::string text = kKinds[static_cast<std::size_t>(kind)];
  if (text.ends_with(' ')) {
    const auto module = names_.modules.find(fmt::format("{:03}", message.value("module", 0u)));
    text += module == names_.modules.end() ? "a module" : module->second;
  }
  marks_.push_back({time_s, text});
}

std::vector<PlotMark> PlotMarks::marks() const {
  auto marks = marks_;
  std::stable_sort(marks.begin(), marks.end(), [](const auto& a, const auto& b) { return a.x < b.x; });
  return marks;
}

}  // namespace sinew::app
