#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <utility>

#include "tap/segment_reader.hpp"

namespace sinew::tap {

/// The newest message of the first topic of type M, read as an outsider reads it.
/// Thread:  owner.
/// Owner:   the segment outlives it.
template <msg::Described M>
class NewestMessage {
 public:
  explicit NewestMessage(const rt::Segment& segment) {
    const rt::SegmentHeader& header = segment.header();
    auto reader =
        SegmentReader::open({reinterpret_cast<const std::byte*>(&header), static_cast<std::size_t>(header.bytes)});
    if (!reader) return;
    reader_.emplace(std::move(*reader));
    for (std::uint32_t t = 0; t < reader_->topics().size() && !topic_; ++t)
      if (reader_->topics()[t].info == &msg::type_info<M>()) topic_ = t;
  }
  /// Nothing: there is no such topic, or no message yet; or the writer overtook each of a few readings.
  std::optional<M> get() const {
    if (!topic_) return std::nullopt;
    std::array<std::byte, sizeof(rt::SlotHeader) + sizeof(M)> copy;
    for (int i = 0; i < 8; ++i) {
      const auto message = reader_->newest(*topic_);
      if (!message) return std::nullopt;
      if (!reader_->copy(*message, copy)) continue;
      M state;
      std::memcpy(&state, copy.data() + sizeof(rt::SlotHeader), sizeof state);
      return state;
    }
    return std::nullopt;
  }

 private:
  std::optional<SegmentReader> reader_;
  std::optional<std::uint32_t> topic_;
};

}  // namespace sinew::tap
