#pragma once
// How long the steps of a robot's modules really take: measured once on a machine, kept in a file beside the robot's.
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "rt/graph_spec.hpp"

namespace sinew::search {

struct ExecProfile {
  std::string measured;                         // when, on what machine, from how much
  std::map<std::string, rt::ExecModel> module;  // by name; "guardian" is one of them

  /// Gives every module its model, times a factor for that module. Where the robot file says how long a step takes on
  /// its board (exec_us, about the 99th percentile), this time stays the 99th percentile, and the profile gives only
  /// the shape of the distribution: so a profile from a faster machine can be used. Modules that the profile does not
  /// name keep the robot file's model. Returns the names in the profile that the robot does not have.
  std::vector<std::string> apply(rt::GraphSpec& graph,
                                 const std::function<double(const std::string&)>& factor_of) const;
};

/// The profile of "robots/quad/quad.toml" is "robots/quad/quad_exec.toml".
std::string profile_path(const std::string& robot_path);

/// Errors:  every problem, with its line; a file that cannot be read is one.
ExecProfile parse_profile(std::string_view text, const std::string& path, std::vector<rt::Problem>& problems);
ExecProfile load_profile(const std::string& path, std::vector<rt::Problem>& problems);

/// Quantiles of what was measured, and the text of a profile. `samples` by module, at least one each; sorted here.
rt::ExecModel model_of(std::vector<rt::Duration>& samples);
std::string to_text(const ExecProfile& profile);

}  // namespace sinew::search
