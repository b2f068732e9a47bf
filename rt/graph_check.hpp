#pragma once
// Everything that can be wrong with a resolved graph, found in one run. Used by Graph::check().
#include <string>
#include <string_view>
#include <vector>

#include "rt/graph.hpp"

namespace sinew::rt {

/// The topic of what a simulator or a data set knows to be true: for recordings and reports. No module may read it.
inline constexpr std::string_view kGroundTruth = "ground_truth";
/// True of this topic, and of names that begin with it and a dot.
bool is_ground_truth(std::string_view topic);

class GraphCheck {
 public:
  GraphCheck(const Graph& graph, const std::vector<std::string>& known_types, const CheckOptions& options)
      : graph_(graph), known_types_(known_types), options_(options) {}
  std::vector<Problem> run();

 private:
  // rt/graph_check.cpp: names, threads, modules
  void names();
  void threads();
  void priority(const ThreadSpec& t);
  void trigger(const GraphThread& t);
  void cpus(const std::string& key, const std::vector<int>& cpus, int line);
  void order(const GraphThread& t);
  void modules();
  void placement(const GraphModule& m);
  void execution_time(const GraphModule& m);
  void params(const GraphModule& m);
  // rt/graph_check_topics.cpp: what is connected
  void bindings(const GraphModule& m);
  void binding(const GraphModule& m, std::uint32_t port);
  void previous(const GraphModule& m, std::uint32_t port);
  void max_age(const GraphModule& m, std::uint32_t port, int line);
  void topics();
  void external(const TopicSpec& topic);
  void actuators();
  void actuator_limits(const ActuatorSpec& a);
  void actuator_command(const ActuatorSpec& a);
  void actuator_channels(const ActuatorSpec& a, const GraphTopic& command);
  void chains();
  // rt/graph_check_failsafes.cpp
  void failsafes();
  void failsafe(const FailsafeSpec& f);
  void failsafe_field(const FailsafeSpec& f, const msg::TypeInfo& type);

  void add(int line, std::string key, std::string value, std::string allowed) {
    problems_.push_back({line, std::move(key), std::move(value), std::move(allowed)});
  }
  /// True, and a problem, when something in the robot would act by the truth.
  bool acts_by_truth(int line, const std::string& key, const std::string& topic);
  template <class Container, class NameAndLine>
  void unique(const Container& all, std::string_view kind, NameAndLine&& of);
  /// "a topic of ImuSample: imu.raw sim.imu; did you mean imu.raw?"; any type when null, no question without `asked`.
  std::string topic_candidates(const msg::TypeInfo* type, std::string_view asked = {}) const;

  const Graph& graph_;
  const std::vector<std::string>& known_types_;
  const CheckOptions& options_;
  std::vector<Problem> problems_;
};

/// In microseconds, as robot files write times.
std::string in_us(Duration d);
std::string in_ms(Duration d);
bool is_name(std::string_view text);
std::string quoted(std::string_view text);
/// The words with spaces between them.
std::string listed(const std::vector<std::string>& words);
/// The same, and the words that may have been meant by `asked`: "kp kd; did you mean kp?".
std::string listed_for(std::string_view asked, const std::vector<std::string>& words);

}  // namespace sinew::rt
