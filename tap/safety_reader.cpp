#include "tap/safety_reader.hpp"

#include "msg/json.hpp"
#include "rt/safety_text.hpp"

namespace sinew::tap {

SafetyReader::SafetyReader(const rt::Segment& segment, const rt::GraphSpec& spec) : spec_(spec), state_(segment) {}

std::vector<std::string> SafetyReader::not_ready() const {
  const auto state = state_.get();
  return state ? rt::not_ready(spec_, *state) : std::vector<std::string>{};
}

Json SafetyReader::json() const {
  const auto state = state_.get();
  if (!state) return {};
  std::string text;
  msg::to_json(msg::type_info<msg::SafetyState>(), &*state, text);
  Json json = Json::parse(text, nullptr, false);
  json["reasons"] = rt::not_ready(spec_, *state);
  return json;
}

}  // namespace sinew::tap
