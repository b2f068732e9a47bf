#include "robots/spark/devices.hpp"

namespace sinew::plant {

std::span<const WorldOption> spark_options() {
  static constexpr WorldOption kAll[] = {
      {"number", "number", "", 0, 11, 0.0, "", "its number in the team; 0: the server chooses", true},
      {"robot_type", "robot-type", "", 0, 6, 0.0, "", "which of the server's bodies it takes; ours is that of type 0",
       true},
      {"beam_x_m", "beam-x", "m", -15, 0, -2.0, "", "where it beams to: along the field, its own goal at -15"},
      {"beam_y_m", "beam-y", "m", -10, 10, 0.0, "", "where it beams to: across the field"},
      {"beam_heading_deg", "beam-heading", "deg", -180, 180, 0.0, "", "where it looks: 0 at the other goal"},
      {"settle_s", "settle", "s", 0, 30, 1.0, "", "it stands still for so long after the beam, before its time begins"},
  };
  return kAll;
}

}  // namespace sinew::plant
