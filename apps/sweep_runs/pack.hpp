#pragma once
// A folder with all that a sweep needs on another machine: programs, their libraries, robot files, options.
#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::app {

struct PackRequest {
  std::string folder;              // is made; must not be there, or be empty
  std::vector<std::string> words;  // for `sinew sweep`: robot files and options that decide the cases
  std::set<std::string> files;     // which these name, and files that those name
};

struct Packed {
  std::uint64_t files = 0, bytes = 0;
};

/// Makes bin/ with `sinew` and `sinew-sim`, lib/ with their libraries except those of the C library, the files under
/// their own names, `options`, SHA256SUMS, and the script `run`. Results name files as the options do, so that every
/// name has to lie below the current folder: results of the packed sweep are then the same bytes as here.
/// Errors:  false, with `why`; nothing is left behind.
bool pack_sweep(const PackRequest& request, Packed& packed, std::string& why);

/// `run`, which checks the folder and flies.
std::string_view pack_script();

/// The libraries that a listing of `ldd` names, without the C library's, as name and path. Errors: false, with `why`:
/// one is not found.
struct Library {
  std::string name, path;
};
bool read_ldd(const std::string& listing, std::vector<Library>& libraries, std::string& why);

/// Whether a file of this name keeps it in another folder: relative, and not above the folder.
bool stays_below(const std::string& name);

}  // namespace sinew::app
