#pragma once
#include <optional>
#include <string>
#include <vector>

#include "rt/graph.hpp"

namespace sinew::app {

struct MagOptions {
  std::string recording{}, topic{}, file{}, params{};
  std::optional<double> field_ut{};  // strength of the earth's field there
  std::vector<double> at_deg{};  // latitude and longitude, or empty: of a GNSS fix in the recording, if there is one
  std::optional<double> year{};  // decimal; default: when it was recorded, or today
  bool json = false;
};

/// `calibrate mag`: hard and soft iron by a recording in which the vehicle was turned about; the exit code.
/// Errors:  printed: the file, its topics, what the readings do not show. Nothing is written then.
int calibrate_mag(const MagOptions& o, const rt::ModuleTypes& types);

}  // namespace sinew::app
