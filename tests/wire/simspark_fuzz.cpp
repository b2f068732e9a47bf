// For any bytes: frames, percepts and effectors that are refused, or that are written and read again as the same.
#include "wire/text/simspark.hpp"

#include <cstdlib>
#include <cstring>

using namespace sinew;

namespace {

std::array<char, 1 << 16> g_first, g_second;

std::string_view written(const wire::SparkPercepts& percepts, std::span<char> into) {
  const auto frame = wire::SparkWriter(into).percepts(percepts).frame();
  if (frame.size() < 4) return {};
  return {frame.data() + 4, frame.size() - 4};
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  static wire::SparkPercepts percepts, back;
  const bool whole = wire::parse_spark_percepts(text, percepts) == wire::SparkError::none;
  if (percepts.joints > percepts.joint.size() || percepts.sightings > percepts.seen.size()) std::abort();
  if (whole) {
    // Numbers are rounded when they are written; from then on text and values are the same.
    const std::string_view once = written(percepts, g_first);
    if (!once.empty()) {
      if (wire::parse_spark_percepts(once, back) != wire::SparkError::none) std::abort();
      if (back.joints != percepts.joints || back.sightings != percepts.sightings || back.hears != percepts.hears ||
          back.places != percepts.places)
        std::abort();
      if (written(back, g_second) != once) std::abort();
    }
  }
  wire::SparkEffectors in(text);
  wire::SparkEffector effector;
  for (std::size_t count = 0; in.next(effector);)
    if (++count > size) std::abort();
  wire::SparkOrders orders(text);
  wire::SparkOrder order;
  for (std::size_t count = 0; orders.next(order);)
    if (++count > size) std::abort();
  std::array<char, 64> buffer;
  wire::SparkFrames frames(buffer);
  for (const char c : text)
    if (frames.push(c) && frames.text().size() > buffer.size()) std::abort();
  return 0;
}
