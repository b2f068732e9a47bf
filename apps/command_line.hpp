#pragma once
#include "apps/command/place.hpp"
#include "rt/module_types.hpp"

namespace sinew::app {

/// The whole `sinew` command for your own program, which knows only the modules of `types`:
///
///   int main(int argc, char** argv) {
///     auto types = sinew::app::all_modules();
///     types.add<my::Thing>("my::Thing");
///     return sinew::app::command_line(argc, argv, types);
///   }
///
/// `place` is filled by find_package(Sinew); see apps/command/place.hpp.
/// Returns the exit code: 0: done; 1: failed; 2: could not begin (usage, no such file, no such robot).
/// Thread:  owner, once in a process.
/// Source:  docs/command-line.md
int command_line(int argc, char** argv, const rt::ModuleTypes& types,
                 const Place& place = {SINEW_PROGRAMS_FOLDER, SINEW_PACKAGE_FOLDER});

}  // namespace sinew::app
