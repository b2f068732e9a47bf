#pragma once
#include <string>

// Defined by find_package(Sinew) for programs of other projects, which are not in the folder of our programs.
#ifndef SINEW_PROGRAMS_FOLDER
#define SINEW_PROGRAMS_FOLDER ""
#endif
#ifndef SINEW_PACKAGE_FOLDER
#define SINEW_PACKAGE_FOLDER ""
#endif

namespace sinew::app {

/// The Sinew that a program was built with. Both empty: the Sinew that contains the program itself, as for `sinew`.
struct Place {
  std::string programs{};  // folder with sinew and sinew-sim
  std::string package{};   // folder with SinewConfig.cmake
};

/// Thread:  owner, before the two below.
void set_place(const Place& place);

/// The path of one of our programs: beside the running program, else in the place, else in PATH; empty: not found.
std::string find_program(const std::string& name);

/// The program with this name in PATH; folders of PATH that are no absolute paths are passed over. Empty: not found.
std::string find_in_path(const std::string& name);

/// The folder with SinewConfig.cmake; empty: none belongs to the running program.
std::string package_folder();

}  // namespace sinew::app
