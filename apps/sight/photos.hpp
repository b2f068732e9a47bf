#pragma once
// Photos of a real field with labels of their balls, as in RoboCup's MSL: judged, and the classifier trained with them.
#include <string>
#include <vector>

#include "apps/sight/judge.hpp"
#include "apps/sight/train.hpp"

namespace sinew::sight {

struct Photo {
  std::string name;
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> yuyv;
  struct Box {
    double u_px, v_px, wide_px, high_px;  // its middle
  };
  std::vector<Box> balls;
  vision::ImageView view() const { return {yuyv.data(), width, height, width * 2, msg::PixelFormat::yuyv}; }
};

/// All NAME.jpg of a folder with their NAME.txt, by name; a line of the latter is: class, middle x and y, width and
/// height as shares of the picture; class 0 is a ball. Errors: `why`.
std::vector<Photo> load_photos(const std::string& folder, std::string& why);

/// A camera for photos whose camera nobody has written down: over flat ground, looking at the horizon, with a focal
/// length of 0.9 widths. Its height and the horizon's row are fitted to the labels of these photos: the row of a ball
/// grows with its size.
struct PhotoCamera {
  double horizon_px = 0, height_m = 0.5;
  vision::Pinhole camera;
  msg::CameraPose pose() const;
};
PhotoCamera fit_camera(std::span<const Photo> photos, double ball_radius_m);

inline constexpr double kMslBallRadius_m = 0.11;  // FIFA size 5, RoboCup Middle Size League, Law 2

void collect(std::span<const Photo> photos, const PhotoCamera& camera, std::vector<Example>& out);
/// `lines`: what was found in each photo.
Judgement judge(std::span<const Photo> photos, const PhotoCamera& camera, std::string& lines);

}  // namespace sinew::sight
