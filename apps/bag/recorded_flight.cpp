#include "apps/bag/recorded_flight.hpp"

#include <algorithm>
#include <cstring>

#include "apps/bag/run_text.hpp"
#include "apps/bag/schema_quantities.hpp"
#include "apps/command/command.hpp"
#include "apps/robot_file/world_report.hpp"
#include "apps/run/run_metadata.hpp"
#include "msg/all.hpp"
#include "msg/cdr.hpp"
#include "msg/ros2msg.hpp"
#include "msg/text.hpp"
#include "record/run/recorded_run.hpp"
#include "record/run/ros2_convert.hpp"
#include "record/run/run_messages.hpp"

namespace sinew::app {
namespace {

using record::Quantity;
using Sample = RecordedField::Sample;

constexpr rt::Duration kFarthest = std::chrono::seconds(1);
constexpr std::size_t kCdrHeader = 4;

/// The same quantity of a Sample's value instead of a message.
Quantity of_sample(const Quantity& what) {
  Quantity own = what;
  own.offset = 0;
  own.kind = msg::Kind::f64;
  return own;
}

/// Null: this program does not know the type, or another version of it.
const msg::TypeInfo* type_of(const record::Reader& reader, const record::Channel& channel) {
  constexpr std::string_view kOurTypes = "sinew_msgs/msg/";
  const auto schema = reader.schemas().find(channel.schema);
  if (schema == reader.schemas().end() || !schema->second.name.starts_with(kOurTypes)) return nullptr;
  const msg::TypeInfo* const type = msg::find_type(schema->second.name.substr(kOurTypes.size()));
  const bool same =
      type && !type->has_bulk() && record::same_definition(msg::ros2msg_schema(*type), schema->second.data);
  return same ? type : nullptr;
}

}  // namespace

double difference(const RecordedField& field, const Sample& a, const Sample& b) {
  const Quantity what = of_sample(field.what);
  return record::difference(what, a.value.data(), what, b.value.data());
}

std::optional<Sample> RecordedField::at(rt::Time t) const {
  const auto after = std::ranges::lower_bound(samples, t, {}, &Sample::at);
  if (after == samples.end()) return std::nullopt;
  if (after->at == t) return *after;
  if (after == samples.begin() || after->at - (after - 1)->at > kFarthest) return std::nullopt;
  Sample mixed = *(after - 1);
  if (is_number() && !msg::is_float(what.kind)) return mixed;
  const double share = msg::seconds(t - mixed.at) / msg::seconds(after->at - mixed.at);
  double dot = 0;  // of two attitudes; between neighbours a line replaces the arc
  for (std::size_t i = 0; i < mixed.value.size(); ++i) dot += mixed.value[i] * after->value[i];
  const double sign = !is_number() && dot < 0 ? -1 : 1;
  for (std::size_t i = 0; i < mixed.value.size(); ++i)
    mixed.value[i] += share * (sign * after->value[i] - mixed.value[i]);
  return mixed;
}

std::unique_ptr<RecordedFlight> RecordedFlight::open(const std::string& path, Progress& progress) {
  auto reader = open_recording(path, progress);
  if (!reader) return nullptr;
  std::unique_ptr<RecordedFlight> flight(new RecordedFlight(path, std::move(reader)));
  return flight->read_run() ? std::move(flight) : nullptr;
}

RecordedFlight::RecordedFlight(std::string path, std::unique_ptr<record::Reader> reader)
    : path_(std::move(path)), reader_(std::move(reader)) {}

bool RecordedFlight::read_run() {
  const auto text = record::read_attachment(*reader_, "robot.toml");
  if (!text || record::read_metadata(*reader_, "sinew.run").empty()) {
    fail(path_ + ": the file holds no run of Sinew");
    return false;
  }
  unix_ns_ = record::unix_ns_of(*reader_);
  start_ = record::recorded_time(*reader_).start;
  spec_ = parse_robot(*text, path_).robot.graph;  // a problem of an older version's file costs only names of failsafes
  result_ = result_line(*reader_);
  told_.emplace(spec_);
  for (const auto& [id, channel] : reader_->channels()) add_topic(channel);
  for (std::size_t i = 0; i < spec_.actuators.size(); ++i)
    if (const auto topic = topics_.find(MissionEvents::state_topic(spec_.actuators[i]));
        topic != topics_.end() && topic->second.type == &msg::type_info<msg::GuardianState>())
      topic->second.actuator = i;
  return true;
}

/// Whether its messages are events.
bool RecordedFlight::tells(const Topic& topic) {
  return topic.type && (topic.actuator || topic.type == &msg::type_info<msg::MissionState>() ||
                        topic.type == &msg::type_info<msg::SafetyState>());
}

/// The recorder's own of steps and states are no topics of the robot.
void RecordedFlight::add_topic(const record::Channel& channel) {
  if (channel.topic == record::kStepsTopic || channel.topic == record::kStatesTopic) return;
  const auto from = reader_->schemas().find(channel.schema);
  if (from == reader_->schemas().end() || from->second.encoding != "ros2msg" || channel.message_encoding != "cdr")
    return;
  std::string ignored;  // what cannot be understood cannot be compared
  const auto schema = record::Ros2Schema::parse(from->second.name, from->second.data, ignored);
  if (!schema) return;
  Topic& topic = topics_[channel.topic];
  topic.type = type_of(*reader_, channel);
  topic.is_state = schema->root().name == "sinew_msgs/NavState";
  topic.quantities = schema_quantities(*schema, topic.size);
}

std::vector<std::string> RecordedFlight::field_names() const {
  std::vector<std::string> names;
  for (const auto& [topic, about] : topics_)
    for (const Quantity& q : about.quantities) names.push_back(topic + "." + q.path);
  return names;
}

bool RecordedFlight::is_usual(const std::string& field) const {
  for (const char* const usual : {".p_world_m.x", ".p_world_m.y", ".p_world_m.z", ".q_world_base.tilt"}) {
    if (!field.ends_with(usual)) continue;
    const auto topic = topics_.find(field.substr(0, field.size() - std::string_view(usual).size()));
    if (topic != topics_.end() && topic->second.is_state) return true;
  }
  return false;
}

bool RecordedFlight::read(const std::vector<std::string>& names) {
  fields_.resize(names.size());
  record::Query query;
  for (auto& [name, topic] : topics_) {
    for (const Quantity& q : topic.quantities)
      for (std::size_t i = 0; i < names.size(); ++i)
        if (names[i] == name + "." + q.path) {
          fields_[i] = {names[i], q};
          topic.fields.push_back(i);
        }
    if (tells(topic) || !topic.fields.empty()) query.topics.push_back(name);
  }
  const bool good = each_message(*reader_, query, [&](const record::Message& m) {
    take(m, topics_.at(m.channel->topic));
    return true;
  });
  for (MissionEvents::Event& e : told_->take()) events_.push_back({e.at, std::move(e.text), e.alarm});
  add_faults();
  std::ranges::stable_sort(events_, {}, &Event::at);
  return good;
}

void RecordedFlight::take(const record::Message& m, Topic& topic) {
  take_events(m, topic);
  if (m.data.size() < kCdrHeader + topic.size) return;  // `bag check` names it
  const std::byte* const message = m.data.data() + kCdrHeader;
  const rt::Time at{static_cast<std::int64_t>(m.stamps.log_time) - unix_ns_};
  for (const std::size_t i : topic.fields) {
    RecordedField& field = fields_[i];
    Sample sample{at};
    if (field.is_number())
      sample.value[0] = field.what.value(message);
    else
      std::memcpy(sample.value.data(), message + field.what.offset, sizeof sample.value);
    field.samples.push_back(sample);
  }
}

void RecordedFlight::take_events(const record::Message& m, const Topic& topic) {
  if (!tells(topic)) return;
  message_.resize(topic.type->size);
  topic.type->reset(message_.data());
  const std::span in(reinterpret_cast<const std::uint8_t*>(m.data.data()), m.data.size());
  if (!msg::cdr_decode(*topic.type, in, message_.data())) return;
  const void* const message = message_.data();
  if (topic.type == &msg::type_info<msg::MissionState>()) told_->see(*static_cast<const msg::MissionState*>(message));
  if (topic.type == &msg::type_info<msg::SafetyState>()) told_->see(*static_cast<const msg::SafetyState*>(message));
  if (topic.actuator) told_->see(*topic.actuator, *static_cast<const msg::GuardianState*>(message));
}

/// Of the simulator's report, whose time begins with the run.
void RecordedFlight::add_faults() {
  const auto text = record::read_attachment(*reader_, kReportFile);
  const auto report = text ? parse_report(*text) : std::nullopt;
  if (!report) return;
  for (const WorldReport::Fault& f : report->faults)
    if (f.first_s)
      events_.push_back({start_ + rt::Duration{static_cast<std::int64_t>(*f.first_s * 1e9)}, "fault " + f.text, true});
}

}  // namespace sinew::app
