#pragma once
#include <optional>
#include <string>

#include "monitor/http/server.hpp"
#include "monitor/robot_pictures.hpp"

namespace sinew::monitor {

/// /ROBOT/images/TOPIC.KIND?quality=1..100&chroma=420|422&scale=0..1&region=X,Y,WIDTH,HEIGHT
struct PictureRequest {
  std::string robot, topic;
  bool movie = false;  // .mjpg
  Recipe recipe{};
};

/// Errors: nothing, with `why` (what, and what is allowed); `is_picture` false: the path is of another kind.
std::optional<PictureRequest> parse_picture_request(const Request& request, bool& is_picture, std::string& why);

}  // namespace sinew::monitor
