#pragma once
// The carpet of pictures that were taken on a field, as the robot's vision measures it: the look that its colour table
// is made of, for a robot's file.
#include <array>
#include <string>
#include <vector>

#include "apps/sight/photos.hpp"

namespace sinew::sight {

struct Carpets {
  std::size_t pictures = 0;
  std::vector<soccer::CarpetLook> looks;   // of those in which it could be measured
  std::array<std::uint64_t, 6> classes{};  // pixels of each soccer::Colour, of all pictures, by their own tables
};

struct RecordTopics {
  std::string image = "camera.raw", pose = "camera_pose.pose";
  double fov_y_rad = 1.0382921838;  // as vision::CameraParameters
};

/// Of pictures in a record, each with the camera's pose of its time. Errors: `why`; a record without these topics, or
/// without any picture (yuyv, up to 640 x 480) that has a pose.
bool measure_record(const std::string& path, const RecordTopics& topics, Carpets& out, std::string& why);
/// Of photos of a camera that looks level from `height_m`.
void measure_photos(std::span<const Photo> photos, double height_m, Carpets& out);

/// The median look, how far the looks of single pictures are from it, and the lines for the parameters of
/// soccer::Sight in a robot's file. `carpets.looks` must not be empty.
soccer::CarpetLook median(const Carpets& carpets);
std::string report(const Carpets& carpets);

}  // namespace sinew::sight
