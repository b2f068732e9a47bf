#pragma once
// A client that sends any text.
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "hal/linux/socket.hpp"
#include "tap/frames.hpp"
#include "tap_rig.hpp"

namespace sinew::tap {

class RawClient {
 public:
  explicit RawClient(const Robot& robot) : stream_(std::move(*hal::connect_stream("unix:" + robot.name->path(), 5s))) {
    stream_->set_patience(20s);
  }
  bool send(std::string_view bytes) { return stream_->write(std::as_bytes(std::span(bytes))).has_value(); }
  bool send_frame(std::string_view text) {
    return stream_->write(frame_head(text.size()), std::as_bytes(std::span(text))).has_value();
  }
  /// Nothing: the robot hung up.
  std::optional<Json> reply() {
    while (!frames_.frame()) {
      const auto n = stream_->read(frames_.room());
      if (!n) return std::nullopt;
      frames_.filled(*n);
    }
    Json json = Json::parse(*frames_.frame(), nullptr, false);
    frames_.drop();
    return json;
  }

 private:
  std::unique_ptr<hal::Stream> stream_;
  FrameReader frames_{kMaxReplyBytes};
};

}  // namespace sinew::tap
