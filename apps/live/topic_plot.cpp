// topic plot: fields of a running robot over some seconds.
#include <fmt/format.h>

#include <map>

#include "apps/command/command.hpp"
#include "apps/live/topic_options.hpp"
#include "apps/live/topic_reader.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"
#include "msg/json.hpp"
#include "msg/ros2msg.hpp"
#include "record/ros2_schema.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;

constexpr hal::Duration kLook = 2ms;  // between two looks at all topics; each keeps some messages until then

/// The definitions of the messages that this program knows.
TopicSchemas schemas_of(const tap::SegmentReader& reader) {
  TopicSchemas all;
  for (const tap::Topic& topic : reader.topics()) {
    std::string ignored;  // our own text
    if (topic.known())
      if (auto schema =
              record::Ros2Schema::parse(msg::ros2_name(*topic.info), msg::ros2msg_schema(*topic.info), ignored))
        all.emplace(topic.name, std::move(*schema));
  }
  return all;
}

class LivePlot {
 public:
  LivePlot(const TopicPlotOptions& options, LiveRobot& robot) : options_(options), robot_(robot) {}

  int run() {
    const tap::SegmentReader* const segment = robot_.reader();
    if (!segment) return kNotBegun;
    const TopicSchemas schemas = schemas_of(*segment);
    std::string why;
    auto fields = PlotFields::make(options_.plot.fields, schemas, why);
    if (!fields) return fail("robot " + robot_.name() + ": " + why);
    PlotMarks marks(options_.plot.no_marks ? TopicSchemas() : schemas, names());
    for (const std::string& field : options_.plot.marked)
      if (why = marks.watch(field, schemas); !why.empty()) return fail("robot " + robot_.name() + ": " + why);
    fields_ = &*fields;
    marks_ = &marks;
    for (const auto& topic : fields->topics())
      if (!open(topic)) return kNotBegun;
    for (const auto& topic : marks.topics())
      if (!readers_.contains(topic) && !open(topic)) return kNotBegun;
    if (!follow()) return kFailed;
    const std::string title = fmt::format("{}, {:.3g} s of a run", robot_.name(), end_s_);
    const int code = finish_plot(options_.plot, options_.json, *fields, &marks, title, {0, end_s_});
    for (const auto& [topic, reader] : readers_)
      if (reader.lost() > 0)
        std::fprintf(stderr, "%s: %llu messages came too fast to be drawn\n", topic.c_str(),
                     static_cast<unsigned long long>(reader.lost()));
    return code;
  }

 private:
  /// Of what the marks say in numbers. A robot of an older version does not tell.
  PlotMarks::Names names() {
    PlotMarks::Names names;
    if (const auto hello = robot_.ask("hello"); hello && hello->contains("failsafes"))
      for (const Json& name : hello->at("failsafes"))
        if (name.is_string()) names.failsafes.push_back(name.get<std::string>());
    return names;
  }
  bool open(const std::string& topic) {
    auto reader = TopicReader::open(robot_, topic);
    if (reader) readers_.emplace(topic, std::move(*reader));
    return reader.has_value();
  }

  /// False, after it was printed: the robot ended before anything came.
  bool follow() {
    hal::Os& os = hal::system_os();
    const hal::Time end = os.now() + hal::Duration{static_cast<std::int64_t>(options_.seconds * 1e9)};
    while (os.now() < end && !hal::stop_requested()) {
      for (auto& [topic, reader] : readers_) {
        TopicReader::Got got = TopicReader::Got::message;
        while (got == TopicReader::Got::message) {
          got = reader.next(os.now());
          if (got == TopicReader::Got::message) add(topic, reader);
        }
        if (got == TopicReader::Got::end && !hal::stop_requested()) return start_ns_.has_value();
      }
      os.sleep_until(os.now() + kLook);
    }
    return true;
  }

  void add(const std::string& topic, const TopicReader& reader) {
    text_.clear();
    msg::to_json(*reader.topic().info, reader.message(), text_);
    const Json message = Json::parse(text_, nullptr, false);
    const std::int64_t published = reader.header().published.ns;
    const std::int64_t stamp = message.value("stamp", published);
    if (!start_ns_) start_ns_ = published;
    constexpr std::int64_t kStrange_ns = 60'000'000'000;
    const bool good = stamp > 0 && stamp <= published && published - stamp < kStrange_ns;
    const double t = 1e-9 * static_cast<double>((good ? stamp : published) - *start_ns_);
    end_s_ = std::max(end_s_, t);
    fields_->add(topic, t, message);
    marks_->add(topic, t, message);
  }

  const TopicPlotOptions& options_;
  LiveRobot& robot_;
  PlotFields* fields_ = nullptr;
  PlotMarks* marks_ = nullptr;
  std::map<std::string, TopicReader> readers_;
  std::string text_;
  std::optional<std::int64_t> start_ns_;
  double end_s_ = 0;
};

}  // namespace

int plot_topics(const TopicPlotOptions& options) {
  auto robot = LiveRobot::find(options);
  return robot ? LivePlot(options, *robot).run() : kNotBegun;
}

}  // namespace sinew::app
