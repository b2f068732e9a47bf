#pragma once
#include <optional>
#include <string>
#include <vector>

#include "record/reader.hpp"
#include "rt/graph.hpp"

namespace sinew::record {

/// A topic of ground truth has this name, or begins with it and a point.
inline constexpr std::string_view kTruthTopic = "ground_truth";

/// The ground truth in a recording: the messages of one topic, also for stamps between them. Fields that are not known
/// are NaN.
/// Thread:  owner; at() any.
class Truth {
 public:
  /// The name of the topic in this file; empty when there is none of that kind.
  static std::string topic_of(const Reader& reader);
  /// Reads all of the topic.
  /// Errors:  nothing, with `why`: there is no such topic, its type is not known or of another version, it is empty.
  static std::optional<Truth> read(Reader& reader, const rt::Graph& graph, const std::string& topic, std::string& why);

  /// Interpolates between two messages that are at most a second apart, into type().size bytes. False: not known then.
  bool at(rt::Time stamp, void* message) const;
  const msg::TypeInfo& type() const { return *type_; }

 private:
  explicit Truth(const msg::TypeInfo& type) : type_(&type) {}
  const std::byte* message(std::size_t i) const { return bytes_.data() + i * type_->size; }

  const msg::TypeInfo* type_;
  std::vector<rt::Time> stamps_;  // rise
  std::vector<std::byte> bytes_;
};

}  // namespace sinew::record
