#include "tap/safety_reader.hpp"

#include <array>
#include <cstring>

#include "msg/json.hpp"
#include "rt/safety_text.hpp"

namespace sinew::tap {

SafetyReader::SafetyReader(const rt::Segment& segment, const rt::GraphSpec& spec) : spec_(spec) {
  const rt::SegmentHeader& header = segment.header();
  auto reader =
      SegmentReader::open({reinterpret_cast<const std::byte*>(&header), static_cast<std::size_t>(header.bytes)});
  if (!reader) return;
  reader_.emplace(std::move(*reader));
  for (std::uint32_t t = 0; t < reader_->topics().size(); ++t)
    if (reader_->topics()[t].info == &msg::type_info<msg::SafetyState>()) topic_ = t;
}

std::optional<msg::SafetyState> SafetyReader::newest() const {
  if (!topic_) return std::nullopt;
  std::array<std::byte, sizeof(rt::SlotHeader) + sizeof(msg::SafetyState)> copy;
  for (int i = 0; i < 8; ++i) {
    const auto message = reader_->newest(*topic_);
    if (!message) return std::nullopt;
    if (!reader_->copy(*message, copy)) continue;
    msg::SafetyState state;
    std::memcpy(&state, copy.data() + sizeof(rt::SlotHeader), sizeof state);
    return state;
  }
  return std::nullopt;
}

std::vector<std::string> SafetyReader::not_ready() const {
  const auto state = newest();
  return state ? rt::not_ready(spec_, *state) : std::vector<std::string>{};
}

Json SafetyReader::json() const {
  const auto state = newest();
  if (!state) return {};
  std::string text;
  msg::to_json(msg::type_info<msg::SafetyState>(), &*state, text);
  Json json = Json::parse(text, nullptr, false);
  json["reasons"] = rt::not_ready(spec_, *state);
  return json;
}

}  // namespace sinew::tap
