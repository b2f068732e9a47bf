#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "record/run/quantity.hpp"
#include "record/run/recorded_run.hpp"
#include "record/run/replay.hpp"
#include "record/run/truth.hpp"

namespace sinew::record {

/// The difference of one quantity, over many messages.
struct Deviation {
  std::uint64_t count = 0;
  double sum_of_squares = 0, max = 0;  // max: of the amount
  rt::Time max_at;                     // the first step with this maximum
  void add(double difference, rt::Time at);
  double rms() const;  // 0 of none
};

/// A curve of any length for a plot: keeps the smallest and the largest value of each stretch of time.
class Curve {
 public:
  explicit Curve(const RecordedTime& record);
  void add(rt::Time at, double value);
  std::vector<std::pair<double, double>> points() const;  // s since its start, value

 private:
  struct Stretch {
    rt::Time low_at, high_at;
    double low = 0, high = 0;
    bool any = false;
  };
  rt::Time start_;
  double per_stretch_s_;
  std::vector<Stretch> stretches_;
};

/// One quantity of one topic.
struct ComparedQuantity {
  std::string name;  // "filter.state.q_world_base.tilt"
  std::string unit;
  Deviation now;                // from the record
  std::uint64_t one_sided = 0;  // messages in which only one of the two is a number
  bool has_truth = false;       // the truth has this quantity, too
  Deviation recorded_from_truth, now_from_truth;
  std::uint64_t not_a_number = 0;  // messages in which it is no number now, but was one in the truth or the record
  double spread = 0;  // of the recorded values: standard deviation or, of angles, RMS from the first attitude

  /// "recorded", "now", "truth", or the angles between them; empty unless they were asked for.
  std::vector<std::pair<std::string, Curve>> curves{};

  /// The RMS of the difference divided by the spread of the recorded values; infinite when these never moved.
  double relative() const;
  bool same() const { return now.max == 0 && one_sided == 0; }
};

struct ComparisonOptions {
  std::vector<std::string> quantities{};      // means(); none: all
  std::vector<std::string> modules{};         // whose outputs; none: all
  const Truth* truth = nullptr;               // outlives the comparison
  std::optional<double> from_s{}, until_s{};  // of the record: only messages of steps in between
  RecordedTime record{};
  bool curves = false;  // kept, for a plot
};

/// Compares the outputs of a replay with the record, and both with the truth, number by number.
/// Thread:  owner.
class Comparison final : public ReplayWatcher {
 public:
  Comparison(const rt::Graph& graph, const ComparisonOptions& options);
  ~Comparison() override;
  void compared(const ReplayedMessage& message) override;
  /// In the order of topics and fields; quantities without messages have none counted.
  std::vector<ComparedQuantity> result() const;

 private:
  struct One;
  struct Topic;
  static void make_curves(One& one, const ComparisonOptions& options);
  static void compare(One& one, const Topic& topic, const ReplayedMessage& message);
  static void compare_with_truth(One& one, const ReplayedMessage& message, const void* truth);

  ComparisonOptions options_;
  rt::Time from_{INT64_MIN}, until_{INT64_MAX};
  std::vector<Topic> topics_;
  std::vector<std::byte> truth_;
};

/// The names of all quantities of the outputs of these modules (none: of all).
std::vector<std::string> quantity_names(const rt::Graph& graph, const std::vector<std::string>& modules = {});

}  // namespace sinew::record
