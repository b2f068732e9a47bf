#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "msg/describe.hpp"
#include "record/reader.hpp"

namespace sinew::record {

/// A topic of a recording whose messages this program can put back into memory.
struct RecordedTopic {
  std::string name;
  const msg::TypeInfo* type = nullptr;
  std::uint32_t image_bytes = 0;  // room for the pixels; 0: no images
  double rate_hz = 0;             // messages over the length of the file; 0: not known
};

struct RecordedTopics {
  struct Unknown {
    std::string name, why;
  };
  std::vector<RecordedTopic> known;  // the message type has the same definition in the file and in this program
  std::vector<Unknown> unknown;      // all others, but those of the recorder's own
};

/// Reads the first head of each image topic.
RecordedTopics recorded_topics(Reader& reader);

}  // namespace sinew::record
