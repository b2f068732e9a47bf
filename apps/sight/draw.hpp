#pragma once
// What was seen, drawn over its picture.
#include <string>

#include "apps/sight/scenes.hpp"

namespace sinew::sight {

struct Drawing {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};
Drawing draw(const vision::ImageView& image, const soccer::GroundView& view, const soccer::FieldSight& sight,
             const msg::SoccerSight& seen);
/// Pictures of one size side by side.
Drawing side_by_side(const std::vector<Drawing>& all, std::size_t columns);
/// False: `path` cannot be written.
bool write_png(const std::string& path, const Drawing& picture);

}  // namespace sinew::sight
