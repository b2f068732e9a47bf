#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/bag/bag_file.hpp"
#include "apps/flight/mission_events.hpp"
#include "apps/robot_file/robot_file.hpp"
#include "record/run/quantity.hpp"

namespace sinew::app {

/// One quantity of one topic over a recorded run.
struct RecordedField {
  struct Sample {
    rt::Time at;                    // when it was published, by the robot's clock
    std::array<double, 4> value{};  // a number, or the w, x, y, z of an attitude
  };
  std::string name;  // "filter.state.p_world_m.z"
  record::Quantity what;
  std::vector<Sample> samples{};

  bool is_number() const { return what.what == record::Quantity::What::number; }
  /// The value at a time between two samples that are at most a second apart: on a line between them, of whole numbers
  /// that of the earlier one. Nothing elsewhere.
  std::optional<RecordedField::Sample> at(rt::Time t) const;
};
/// b - a of numbers; of attitudes the angle between them, in degrees.
double difference(const RecordedField& field, const RecordedField::Sample& a, const RecordedField::Sample& b);

/// A run in a file, as a whole: what happened when, and some of its fields over time.
/// Thread:  owner.
class RecordedFlight {
 public:
  /// Null after printing why: no such file, or no run of Sinew in it.
  static std::unique_ptr<RecordedFlight> open(const std::string& path, Progress& progress);

  /// All that read() can take, of messages of any type: the file has their definitions.
  std::vector<std::string> field_names() const;
  /// Position and tilt of a NavState: of an estimate, or of the truth.
  bool is_usual(const std::string& field) const;
  /// Reads the events, and the fields of these names, each of them one of field_names(). False after printing what
  /// could not be read; the rest is there.
  bool read(const std::vector<std::string>& names);

  struct Event {
    rt::Time at;
    std::string text;
    bool alarm = false;  // a failsafe, a safe action, a fault
  };
  /// In the order of time: what the robot said (MissionEvents), and the faults that the simulator played.
  const std::vector<Event>& events() const { return events_; }
  /// In the order of `names`.
  const std::vector<RecordedField>& fields() const { return fields_; }
  rt::Time start() const { return start_; }
  const std::string& path() const { return path_; }
  /// How it went, in one line; why there is no result, if so.
  const std::string& result() const { return result_; }

 private:
  struct Topic {
    const msg::TypeInfo* type = nullptr;  // null: this program does not know it, or another version
    bool is_state = false;                // a NavState
    std::vector<record::Quantity> quantities{};
    std::uint32_t size = 0;             // bytes that they need
    std::vector<std::size_t> fields{};  // in fields_
    std::optional<std::size_t> actuator{};
  };
  RecordedFlight(std::string path, std::unique_ptr<record::Reader> reader);
  bool read_run();
  static bool tells(const Topic& topic);
  void add_topic(const record::Channel& channel);
  void take(const record::Message& message, Topic& topic);
  void take_events(const record::Message& message, const Topic& topic);
  void add_faults();

  const std::string path_;
  std::unique_ptr<record::Reader> reader_;
  std::int64_t unix_ns_ = 0;
  rt::Time start_;
  rt::GraphSpec spec_;
  std::string result_;
  std::map<std::string, Topic> topics_;
  std::optional<MissionEvents> told_;
  std::vector<Event> events_;
  std::vector<RecordedField> fields_;
  std::vector<std::byte> message_;
};

}  // namespace sinew::app
