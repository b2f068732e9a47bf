#pragma once
#include <map>
#include <optional>
#include <string>

#include "record/reader.hpp"
#include "record/ros2_schema.hpp"

namespace sinew::app {

/// The messages of a file as JSON, by the definitions in the file itself. Prints on standard error, once per topic:
/// messages that cannot be shown, and a type that this program has with other fields.
/// Thread:  owner.
class BagMessages {
 public:
  explicit BagMessages(const record::Reader& reader) : reader_(reader) {}
  /// False, and nothing appended: the kind of message is not known, or the bytes do not fit it.
  bool append_json(const record::Message& message, std::string& out);
  /// The definition of a channel's messages. Null, after printing why: it is not known.
  const record::Ros2Schema* schema(const record::Channel& channel);
  /// Messages that could not be shown.
  std::uint64_t unknown() const { return unknown_; }

 private:
  struct Known {
    std::optional<record::Ros2Schema> schema;
    bool said = false;
  };
  Known& of(const record::Channel& channel);
  const record::Reader& reader_;
  std::map<std::uint16_t, Known> channels_;
  std::uint64_t unknown_ = 0;
};

}  // namespace sinew::app
