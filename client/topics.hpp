#pragma once
// What the robot says about its topics, flattened for readers that know no structures.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "hal/result.hpp"
#include "tap/segment_reader.hpp"

namespace sinew::client {

/// One number of a message, or one array of numbers.
struct Field {
  std::string name, unit, doc;
  std::string names;  // JSON object from name to value, of a choice or of bits; empty: none
  msg::Kind kind = msg::Kind::f64;
  std::uint32_t offset = 0, count = 1;
  bool is_array = false;
};

struct Topic {
  std::string name, type;
  bool external = false, wakes_outsiders = false;
  double rate_hz = 0;
  std::vector<Field> fields;
};

/// Makes the topics, in the reader's order, from the robot's reply to the request `topics`. The reply is not trusted:
/// every field lies within its message.
/// Errors:  bad_data.
hal::Result<std::vector<Topic>> describe_topics(std::string_view reply, const tap::SegmentReader& reader);

}  // namespace sinew::client
