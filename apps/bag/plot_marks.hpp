#pragma once
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/bag/plot_fields.hpp"
#include "apps/view/plot.hpp"

namespace sinew::app {

/// What happened, for the marks of a plot: phases of a mission, modes of a head, failsafes and the guardian's actions,
/// requests from outside, and each change of the fields that a user names.
/// Thread:  owner.
class PlotMarks {
 public:
  struct Names {
    std::vector<std::string> failsafes{};          // by bit, as in the robot file; may be empty
    std::map<std::string, std::string> modules{};  // of a recording: "007" to its name
  };
  PlotMarks(const TopicSchemas& topics, Names names);

  /// Marks each change of TOPIC.FIELD, too. Empty, or why not.
  std::string watch(const std::string& field, const TopicSchemas& topics);

  /// The topics whose messages add() wants.
  std::vector<std::string> topics() const;
  void add(const std::string& topic, double time_s, const nlohmann::ordered_json& message);
  /// In the order of time.
  std::vector<PlotMark> marks() const;

 private:
  enum class Meaning { change, failsafes, alarm_change, request };
  struct Watched {
    Meaning meaning;
    std::string field;  // path in the message
    std::string title;  // before the value, e.g. "filter.state.at_rest "
    record::Ros2Field described{};
    std::optional<std::uint64_t> last{};
  };
  void add_value(Watched& watched, double time_s, std::uint64_t value);
  void add_request(double time_s, const nlohmann::ordered_json& message);

  Names names_;
  std::map<std::string, std::vector<Watched>> watched_;
  std::vector<PlotMark> marks_;
};

}  // namespace sinew::app
