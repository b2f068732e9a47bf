#pragma once
#include <vector>

#include "apps/toml/toml_resolver.hpp"

namespace sinew::app {

struct IniProblem {
  rt::Problem problem;  // its line counts nothing
  LinePlace at;
};

/// Whether a device of the driver "text" names a file of altURI's form by its key `ini`.
bool names_ini_file(const toml::table& robot);

/// Puts what these files say in place of the key `ini`: keys and tables of the same name keep what the robot file says.
/// A file's name is relative to the robot file that names it.
/// Errors:  problems; a file that cannot be read keeps its key.
void read_ini_files(toml::table& robot, NodePlaces& places, std::vector<IniProblem>& problems);

}  // namespace sinew::app
