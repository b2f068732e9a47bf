#pragma once
#include "apps/command/place.hpp"
#include "rt/module_types.hpp"

namespace sinew::app {

/// The `sinew` command as a whole for a program of one's own, which knows the modules of `types` and no others:
///
///   int main(int argc, char** argv) {
///     auto types = sinew::app::all_modules();
///     types.add<my::Thing>("my::Thing");
///     return sinew::app::command_line(argc, argv, types);
///   }
///
/// `place` is filled by find_package(Sinew); see apps/command/place.hpp.
/// Returns the exit code: 0 done; 1 the thing failed; 2 it could not be begun (usage, no such file, no such robot).
/// Thread:  owner, once in a process.
/// Source:  docs/command-line.md
int command_line(int argc, char** argv, const rt::ModuleTypes& types,
                 const Place& place = {SINEW_PROGRAMS_FOLDER, SINEW_PACKAGE_FOLDER});

}  // namespace sinew::app
