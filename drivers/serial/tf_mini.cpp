#include "drivers/serial/tf_mini.hpp"

namespace sinew::drivers {
namespace {
constexpr std::uint64_t kMuchTfMiniGarbage = 200;  // bytes: 20 frames' worth without one good frame
}

hal::Status TfMini::set_up(std::string& why) {
  scanner_ = {};
  garbage_ = 0;
  return line_.open(why);
}

hal::Status TfMini::poll(hal::Time now, std::vector<msg::RangeSample>& out, std::string& why) {
  const auto on_frame = [&](std::span<const std::uint8_t> frame) {
    out.push_back({.stamp = now, .range_m = wire::decode_tfmini(frame, weakest_).range_m});
    garbage_ = scanner_.stats().skipped_bytes;
  };
  const auto on_bytes = [&](std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t b : bytes) scanner_.push(b, on_frame);
  };
  if (auto done = line_.read(on_bytes, why); !done) return done;
  if (scanner_.stats().skipped_bytes - garbage_ < kMuchTfMiniGarbage) return {};
  garbage_ = scanner_.stats().skipped_bytes;
  why = "only garbage comes in; a TFmini sends at 115200 bit/s";
  return hal::Error{hal::Errc::bad_data, "tfmini: garbage"};
}

}  // namespace sinew::drivers
