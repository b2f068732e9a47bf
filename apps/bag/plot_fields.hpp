#pragma once
// What `bag plot` and `topic plot` draw: expressions of fields, from messages as they come.
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/view/plot.hpp"
#include "record/ros2_schema.hpp"

namespace sinew::app {

/// Topics by name, each with the definition of its messages.
using TopicSchemas = std::map<std::string, record::Ros2Schema>;

/// Curves of fields over time. An expression is a field (TOPIC.FIELD, also all numbers inside of it), the difference of
/// two (`A - B`: B is interpolated at the times of A), the angle between two attitudes (`angle(A, B)`) or the length of
/// a vector (`norm(A)`, `norm(A - B)`).
/// Thread:  owner.
class PlotFields {
 public:
  /// Nothing, with `why`: an expression is not understood, a topic or field does not exist (with what there is), or two
  /// do not fit together.
  static std::optional<PlotFields> make(const std::vector<std::string>& expressions, const TopicSchemas& topics,
                                        std::string& why);
  PlotFields(PlotFields&&) noexcept;
  PlotFields& operator=(PlotFields&&) noexcept;
  ~PlotFields();

  /// The topics whose messages add() wants.
  std::vector<std::string> topics() const;
  void add(const std::string& topic, double time_s, const nlohmann::ordered_json& message);

  /// One plot for each unit, in the order of the expressions; without title, label of the time and marks. Of a curve
  /// without points the name says so.
  std::vector<Plot> plots() const;

  struct Expression;
  struct Column;

 private:
  PlotFields();
  std::vector<std::unique_ptr<Expression>> expressions_;
  std::map<std::string, std::vector<std::shared_ptr<Column>>> columns_;  // by topic
};

}  // namespace sinew::app
