#pragma once
#include <string>
#include <vector>

#include "rt/graph.hpp"

namespace sinew::app {

struct LensOptions {
  std::string recording, topic, file, params, picture;
  std::vector<std::uint32_t> board{9, 6};
  double square_m = 0;
  std::size_t views = 40;
  bool json = false;
};

/// `calibrate camera`: focal lengths, centre and distortion from a recording that shows a printed chessboard; the exit
/// code. Errors:  printed: the file, its topic, too few views. Nothing is written then.
int calibrate_lens(const LensOptions& o, const rt::ModuleTypes& types);

struct LegsOptions {
  LensOptions lens;  // of the board and the recording
  std::string place = "camera", camera_file;
};

/// `calibrate legs`: zeros of joints and soles; the exit code.
int calibrate_legs(const LegsOptions& o, const rt::ModuleTypes& types);

}  // namespace sinew::app
