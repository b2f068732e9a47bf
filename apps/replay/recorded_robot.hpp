#pragma once
// The robot of a recording, for the commands that execute its steps again.
#include <memory>
#include <optional>
#include <string>

#include "hal/board.hpp"
#include "record/reader.hpp"
#include "rt/graph.hpp"

namespace sinew::app {

/// The graph of the robot file that a recording holds. Nothing, with `why`, when it holds no run, or its robot file
/// cannot be understood.
std::optional<rt::GraphSpec> written_spec(record::Reader& reader, const std::string& file, std::string& why);

/// The graph that ran: that of the robot file with the parameters of the start and the seed. Nothing: as above.
std::optional<rt::GraphSpec> recorded_spec(record::Reader& reader, const std::string& file, std::string& why);

/// Checked and configured on a board that outlives it (hal::SilentBoard). Null, with all reasons in `why`.
std::unique_ptr<rt::Graph> configured_graph(const rt::GraphSpec& spec, const rt::ModuleTypes& types, hal::Board& board,
                                            const std::string& file, std::string& why);

}  // namespace sinew::app
