#include <fmt/format.h>

#include <algorithm>

#include "apps/bag/bag_message.hpp"
#include "apps/bag/bag_options.hpp"
#include "apps/command/command.hpp"
#include "apps/command/json.hpp"
#include "apps/robot_file/robot_file.hpp"
#include "record/run/recorded_run.hpp"
#include "record/run/run_messages.hpp"

namespace sinew::app {
namespace {

/// The definitions of all topics whose messages can be shown, but the recorder's own of steps and states.
TopicSchemas schemas_of(const record::Reader& reader) {
  TopicSchemas all;
  for (const auto& [id, channel] : reader.channels()) {
    const auto schema = reader.schemas().find(channel.schema);
    if (schema == reader.schemas().end() || schema->second.encoding != "ros2msg" || channel.message_encoding != "cdr")
      continue;
    if (channel.topic == record::kStepsTopic || channel.topic == record::kStatesTopic) continue;
    std::string ignored;  // a topic that cannot be shown is no topic to plot
    if (auto parsed = record::Ros2Schema::parse(schema->second.name, schema->second.data, ignored))
      all.emplace(channel.topic, std::move(*parsed));
  }
  return all;
}

PlotMarks::Names names_of(record::Reader& reader) {
  PlotMarks::Names names;
  for (const auto& [number, module] : record::read_metadata(reader, "sinew.modules")) names.modules[number] = module;
  if (const auto text = record::read_attachment(reader, "robot.toml"))
    for (const auto& failsafe : parse_robot(*text, "robot.toml").robot.graph.failsafes)
      names.failsafes.push_back(failsafe.name);
  return names;
}

class BagPlot {
 public:
  BagPlot(const BagPlotOptions& options, record::Reader& reader)
      : options_(options), reader_(reader), start_(record::recorded_start(reader)) {}

  int run() {
    const TopicSchemas schemas = schemas_of(reader_);
    std::string why;
    auto fields = PlotFields::make(options_.plot.fields, schemas, why);
    if (!fields) return fail(options_.file + ": " + why);
    PlotMarks marks(options_.plot.no_marks ? TopicSchemas() : schemas, names_of(reader_));
    for (const std::string& field : options_.plot.marked)
      if (why = marks.watch(field, schemas); !why.empty()) return fail(options_.file + ": " + why);
    Selection what{fields->topics(), options_.from_s, options_.until_s};
    for (const std::string& topic : marks.topics())
      if (std::find(what.topics.begin(), what.topics.end(), topic) == what.topics.end()) what.topics.push_back(topic);
    const auto query = query_of(reader_, what);
    if (!query) return kNotBegun;
    BagMessages texts(reader_);
    std::string text;
    const bool good = each_message(reader_, *query, [&](const record::Message& m) {
      text.clear();
      if (!texts.append_json(m, text)) return true;  // that was said
      const Json message = Json::parse(text, nullptr, false);
      fields->add(m.channel->topic, seconds_of(m), message);
      marks.add(m.channel->topic, seconds_of(m), message);
      return true;
    });
    const double end_s = 1e-9 * static_cast<double>(end_time(reader_) - start_);
    const int code = finish_plot(options_.plot, options_.json, *fields, &marks, title(),
                                 {options_.from_s.value_or(0), std::min(options_.until_s.value_or(end_s), end_s)});
    return good && texts.unknown() == 0 ? code : kFailed;
  }

 private:
  /// By the stamp, so that what was measured at one time stands at one place; a message without one by its log time.
  double seconds_of(const record::Message& m) const {
    constexpr std::uint64_t kStrange_ns = 60'000'000'000;  // no message is that old when it is recorded
    const std::uint64_t log = m.stamps.log_time, stamp = m.stamps.publish_time;
    const std::uint64_t t = stamp == 0 || stamp > log || log - stamp > kStrange_ns ? log : stamp;
    return 1e-9 * (static_cast<double>(t) - static_cast<double>(start_));
  }
  std::string title() const {
    const auto run = record::read_metadata(reader_, "sinew.run");
    const auto robot = run.find("robot");
    return robot == run.end() ? options_.file : robot->second + ", " + options_.file;
  }

  const BagPlotOptions& options_;
  record::Reader& reader_;
  std::uint64_t start_;
};

}  // namespace

int bag_plot(const BagPlotOptions& options) {
  std::unique_ptr<record::Reader> reader;
  Progress progress("plot");
  reader = open_recording(options.file, progress);
  return reader ? BagPlot(options, *reader).run() : kNotBegun;
}

}  // namespace sinew::app
