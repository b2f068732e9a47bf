#pragma once
#include <string>

// Defined by find_package(Sinew) for programs of other projects, which stand elsewhere than ours.
#ifndef SINEW_PROGRAMS_FOLDER
#define SINEW_PROGRAMS_FOLDER ""
#endif
#ifndef SINEW_PACKAGE_FOLDER
#define SINEW_PACKAGE_FOLDER ""
#endif

namespace sinew::app {

/// Where the Sinew is that a program was built with. Both empty: around the program itself, as for `sinew`.
struct Place {
  std::string programs{};  // folder with sinew and sinew-sim
  std::string package{};   // folder with SinewConfig.cmake
};

/// Thread:  owner, before the two below.
void set_place(const Place& place);

/// The path of one of our programs: beside the one that runs, in the place, or in PATH; empty: in none of them.
std::string find_program(const std::string& name);

/// The folder with SinewConfig.cmake; empty: it is not installed where the program that runs is.
std::string package_folder();

}  // namespace sinew::app
