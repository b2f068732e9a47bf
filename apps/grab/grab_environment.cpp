#include "apps/grab/grab_environment.hpp"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "grab/grab_memory.hpp"
#include "hal/linux/process.hpp"

namespace sinew::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLibrary = "libsinew_grab.so";

/// "lib/x86_64-linux-gnu/sinew" of "../lib/x86_64-linux-gnu/sinew/libsinew_grab.so".
fs::path folder_from_programs() { return fs::path(SINEW_GRAB_FROM_PROGRAMS).parent_path(); }

void prepend(const char* variable, const std::string& value) {
  const char* present = std::getenv(variable);
  const std::string joined = present && *present ? value + ":" + present : value;
  ::setenv(variable, joined.c_str(), 1);
}

/// The folder of the layer's manifest beside the library; empty: this library has no Vulkan.
std::string layer_folder(const fs::path& library) {
  const fs::path folder = library.parent_path() / "vulkan";
  std::error_code ignored;
  return fs::exists(folder / "VkLayer_sinew_grab.json", ignored) ? folder.string() : std::string();
}

}  // namespace

bool set_grab_environment(const std::string& socket, bool buffered, std::string& why) {
  std::error_code error;
  const fs::path programs = fs::path(hal::program_path()).parent_path();
  const fs::path library = fs::weakly_canonical(programs / SINEW_GRAB_FROM_PROGRAMS, error);
  if (!fs::exists(library, error)) {
    why = library.string() + " is missing: it belongs to sinew grab";
    return false;
  }
  // The same path for programs of 64 and 32 bits, if both libraries are there.
  const fs::path prefix = fs::weakly_canonical(programs / "..", error);
  const std::string preload = (prefix / "$LIB" / "sinew" / kLibrary).string();
  if (preload.find_first_of(" :") != std::string::npos) {
    why = preload + ": the dynamic linker takes no path with blanks or colons in LD_PRELOAD; install sinew elsewhere";
    return false;
  }
  // Where the linker's $LIB is another folder than where the library was installed, only the latter is there.
  const bool standard = folder_from_programs().parent_path().filename() != "lib";
  prepend("LD_PRELOAD", standard ? preload : library.string());
  ::setenv(grab::kSocketVariable, socket.c_str(), 1);
  ::setenv(grab::kReadVariable, buffered ? "buffered" : "direct", 1);
  const fs::path library_32 = prefix / "lib/i386-linux-gnu/sinew" / kLibrary;
  for (const fs::path& one : {library_32, library}) {
    const std::string layers = layer_folder(one);
    if (layers.empty()) continue;
    prepend("VK_ADD_LAYER_PATH", layers);
    if (one == library) prepend("VK_INSTANCE_LAYERS", "VK_LAYER_SINEW_grab");
  }
  return true;
}

}  // namespace sinew::app
