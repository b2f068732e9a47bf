#pragma once
#include <map>
#include <string>
#include <vector>

#include "record/format.hpp"
#include "rt/graph_spec.hpp"

namespace sinew::app {

/// What the robot file says of recordings.
struct RecordOptions {
  bool enabled = true;
  std::string folder = "runs";
  std::vector<rt::Located<std::string>> topics{};  // none: all
  /// Only steps of these threads; of what other threads publish only the messages that such a step held. None: all.
  std::vector<rt::Located<std::string>> threads{};
  std::map<std::string, rt::Located<double>> rate_hz{};  // of topics
  double pixel_mb_per_s = 5;
  record::Compression compression = record::Compression::lz4;
  double split_mb = 0, split_s = 0;  // 0: one file
  double free_floor_mb = 200;        // disk space that a recording leaves free
  double buffer_mb = 32;             // in real time: what may wait in memory while the disk stalls
  struct Ring {                      // the last seconds in memory
    bool enabled = false;
    double seconds = 10, megabytes = 32;
  } ring{};
};

}  // namespace sinew::app
