#pragma once
// The topic commands, each with its options; `file`: a recorded file instead of a running robot.
#include <nlohmann/json.hpp>
#include <string>

#include "apps/bag/plot_output.hpp"
#include "apps/live/live_robot.hpp"
#include "apps/live/topic_rate.hpp"

namespace sinew::app {

struct TopicListOptions : LiveOptions {
  std::string file;
};

struct TopicOptions : TopicListOptions {
  std::string topic;
};

struct EchoOptions : TopicOptions {
  std::uint64_t count = 0;  // 0: until Ctrl-C, or to the end of the file
  std::string field;
  double timeout_s = 0;  // 0: never
};

struct HzOptions : TopicOptions {
  double seconds = 2;  // of a running robot; a file is read as a whole
};

struct TopicPlotOptions : LiveOptions {
  PlotOptions plot{};
  double seconds = 5;  // of this machine's time
};

int plot_topics(const TopicPlotOptions& options);
int list_topics_of_file(const TopicListOptions& options);
int topic_info_of_file(const TopicOptions& options);
int echo_file(const EchoOptions& options);
int hz_of_file(const HzOptions& options);

/// One message as text, with names in place of numbers where the definition has them, or as JSON with numbers; empty,
/// after printing why, when it lacks the field.
std::string echo_text(const EchoOptions& options, Json message, const record::Ros2Schema* schema,
                      std::uint32_t sequence, std::int64_t published_ns);
void print_rate(const HzOptions& options, const TopicRate& rate);

}  // namespace sinew::app
