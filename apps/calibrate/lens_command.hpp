#pragma once
#include <cstdio>
#include <string>
#include <vector>

#include "apps/robot_file/calibration.hpp"
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

inline void put_text(const std::string& text) { std::fwrite(text.data(), 1, text.size(), stdout); }

/// What is there already; no file is an empty one. False after printing what is wrong with it.
bool read_calibration(const std::string& file, Calibration& all);
/// In one piece; without a file it is printed, unless `quiet`. The exit code.
int write_calibration(const std::string& file, const std::string& robot, const Calibration& all, bool quiet);

}  // namespace sinew::app
