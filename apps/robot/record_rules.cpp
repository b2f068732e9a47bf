#include "apps/robot/record_rules.hpp"

#include <algorithm>

#include "apps/robot/board_rules.hpp"
#include "rt/graph_check.hpp"
#include "rt/parameters.hpp"

namespace sinew::app {

std::vector<rt::Problem> check_recording(const RecordOptions& record, const rt::Graph& graph) {
  std::vector<rt::Problem> problems;
  const auto look = [&](int line, const char* key, const std::string& topic) {
    if (graph.find_topic(topic) != rt::kNone) return;
    if (topic == rt::kGroundTruth && needs_plant(graph.spec())) return;  // a run adds it
    std::vector<std::string> names;
    for (const auto& t : graph.topics()) names.push_back(t.name);
    problems.push_back(
        {line, std::string("record.") + key, rt::quoted(topic), "a topic: " + rt::listed_for(topic, names)});
  };
  for (const auto& topic : record.topics) look(topic.line, "topics", topic.value);
  for (const auto& [topic, rate] : record.rate_hz) look(rate.line, "rate_hz", topic);
  std::vector<std::string> threads;
  for (const auto& t : graph.threads()) threads.push_back(t.spec.name);
  for (const auto& thread : record.threads)
    if (std::find(threads.begin(), threads.end(), thread.value) == threads.end())
      problems.push_back({thread.line, "record.threads", rt::quoted(thread.value),
                          "a thread: " + rt::listed_for(thread.value, threads)});
  return problems;
}

}  // namespace sinew::app
