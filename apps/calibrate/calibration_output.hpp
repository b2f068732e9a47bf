#pragma once
// What the commands that calibrate from a recording print and write.
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "apps/robot_file/calibration.hpp"
#include "apps/robot_file/robot_file.hpp"
#include "rt/graph.hpp"

namespace sinew::app {

inline void put_text(const std::string& text) { std::fwrite(text.data(), 1, text.size(), stdout); }

/// What is there already; no file is an empty one. False after printing what is wrong with it.
bool read_calibration(const std::string& file, Calibration& all);
/// In one piece; without a file it is printed, unless `quiet`. The exit code.
int write_calibration(const std::string& file, const std::string& robot, const Calibration& all, bool quiet);

/// Calls `each` with the name of each module that reads this topic, and with what it declares.
void each_reader(const RobotFile& robot, const rt::ModuleTypes& types, const std::string& topic,
                 const std::function<void(const std::string& module, const rt::Declaration& declaration)>& each);

struct OutputFiles {
  std::string file, params;  // --file: a calibration file; --params: for `sinew run --params`
  bool quiet = false;
};
/// Parameters of modules, merged with what the calibration file has; without files they are printed. The exit code.
int write_params(const OutputFiles& to, const std::string& robot, const std::vector<OverlayParam>& params);

}  // namespace sinew::app
