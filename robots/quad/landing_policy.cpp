#include "robots/quad/landing_policy.hpp"

#include <charconv>
#include <vector>

namespace sinew::control {
namespace {

using learn::GridAxis;

// Distance aside 0 to 1.5 m as d / (d + kNear_m); its rate; the height of the camera; the rate of sinking.
constexpr double kFar = 1.5 / (1.5 + LandingPolicy::kNear_m);
constexpr double kFast = 0.8 / (0.8 + LandingPolicy::kSlow_mps);
constexpr GridAxis kAside[] = {{0, kFar, 7}, {-kFast, kFast, 7}};
constexpr GridAxis kDown[] = {{0.4, 2.4, 5}, {0, 0.6, 3}, {0, kFar, 5}};
constexpr double kAsideSpeeds[] = {-0.2, 0, 0.1, 0.3, 0.6};
constexpr double kSinkSpeeds[] = {0.05, 0.2, 0.35, 0.5};

learn::Actions actions(LandingActions kind, std::span<const double> values) {
  return kind == LandingActions::discrete ? learn::Actions::discrete(values)
                                          : learn::Actions::continuous(values.front(), values.back());
}

}  // namespace

LandingPolicy::LandingPolicy(LandingActions kind)
    : aside(learn::RadialBasis(kAside), actions(kind, kAsideSpeeds)),
      down(learn::RadialBasis(kDown), actions(kind, kSinkSpeeds)) {}

LandingPolicy::State LandingPolicy::state_aside(const LandingView& view, std::size_t axis, bool& mirrored) {
  const double offset = view.offset_m(axis), rate = view.offset_mps(axis), far = math::fabs(offset);
  mirrored = offset < 0;
  const double towards = mirrored ? -rate : rate;
  return {far / (far + kNear_m), towards / (math::fabs(towards) + kSlow_mps)};
}

LandingPolicy::State LandingPolicy::state_down(const LandingView& view) {
  const double far = view.distance_m();
  return {view.height_m(), -view.height_mps(), far / (far + kNear_m)};
}

LandingWish LandingPolicy::wish(const LandingView& view) const noexcept {
  LandingWish w;
  for (std::size_t i = 0; i < 2; ++i) {
    bool mirrored = false;
    const State state = state_aside(view, i, mirrored);
    const double speed = aside.best(state).action;
    w.aside_mps[i] = mirrored ? -speed : speed;
  }
  w.sink_mps = down.best(state_down(view)).action;
  return w;
}

std::string weights_text(std::span<const double> weights) {
  std::string text;
  for (const double w : weights) {
    char word[32];
    const auto end = std::to_chars(word, word + sizeof word, static_cast<float>(w));
    if (!text.empty()) text += ' ';
    text.append(word, end.ptr);
  }
  return text;
}

std::string read_weights(std::string_view text, std::span<double> weights) {
  std::vector<double> read;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t begin = text.find_first_not_of(" \t\r\n", at);
    if (begin == std::string_view::npos) break;
    const std::size_t end = std::min(text.find_first_of(" \t\r\n", begin), text.size());
    const std::string_view word = text.substr(begin, end - begin);
    float number = 0;
    const auto got = std::from_chars(word.data(), word.data() + word.size(), number);
    const std::string place = "number " + std::to_string(read.size() + 1);
    if (got.ec != std::errc() || got.ptr != word.data() + word.size() || !math::is_finite(double{number}))
      return place + ": '" + std::string(word.substr(0, 32)) + "': a number such as -1.25";
    if (read.size() == weights.size())
      return place + ": " + std::to_string(weights.size()) + " are needed, here are more";
    read.push_back(double{number});
    at = end;
  }
  if (read.size() != weights.size())
    return std::to_string(weights.size()) + " numbers are needed, here are " + std::to_string(read.size());
  std::copy(read.begin(), read.end(), weights.begin());
  return {};
}

}  // namespace sinew::control
