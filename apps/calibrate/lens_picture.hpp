#pragma once
// What a camera's calibration rests on, as a picture.
#include <string>

#include "apps/calibrate/recorded_boards.hpp"
#include "identify/camera_fit.hpp"

namespace sinew::app {

/// Twice as large as the camera's: one of its pictures, pale; every corner that was used, and how far the fitted camera
/// is off there, drawn so many times as long. Empty: it was written; else why not.
std::string draw_lens(const std::string& path, const RecordedBoards& boards,
                      const std::vector<identify::PlaneView>& views, const identify::CameraFit& fit, double longer);

}  // namespace sinew::app
