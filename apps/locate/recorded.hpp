#pragma once
// What a recorded robot believed of its place, against the simulator's truth.
#include <optional>
#include <string>
#include <vector>

#include "apps/locate/study.hpp"
#include "record/reader.hpp"

namespace sinew::locate {

struct RecordedPlace {
  double t_s = 0;  // after the first truth
  soccer::FieldAt believed, truth;
  bool found = false;
};

/// The module's messages of type NavState, each with the truth of its time; the field as the world has it.
/// Errors:  nothing, with `why`: a topic is not in the file, or of another version.
std::optional<std::vector<RecordedPlace>> read_places(record::Reader& reader, const std::string& topic,
                                                      std::string& why);

/// Counted from `settle_s` after the first on, while the robot is on the carpet: in a game it is taken out otherwise.
PoseErrors errors_of(const std::vector<RecordedPlace>& places, double settle_s);

/// The field from above as SVG: the true path grey and wide, the believed one thin; what is not found is dotted.
std::string draw_paths(const soccer::Field& field, const std::vector<std::vector<RecordedPlace>>& runs);

}  // namespace sinew::locate
