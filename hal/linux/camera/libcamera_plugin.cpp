#include "hal/linux/camera/libcamera_plugin.hpp"

#include <dlfcn.h>
#include <unistd.h>

#include "hal/linux/process.hpp"

namespace sinew::hal {

std::vector<std::string> libcamera_plugin_paths(const std::string& program) {
  const std::string folder = program.substr(0, program.rfind('/') + 1);  // with the final slash
  const std::string file = std::string("/") + kLibcameraPluginFile;
  return {folder + kLibcameraPluginFile, folder + "../" SINEW_PLUGIN_FOLDER + file};
}

Result<std::unique_ptr<Camera>> open_libcamera_plugin(const CameraSpec& spec, Os& os, std::string& why) {
  std::vector<std::string> paths = libcamera_plugin_paths(program_path());
  paths.push_back(std::string("/usr/" SINEW_PLUGIN_FOLDER "/") +
                  kLibcameraPluginFile);     // for programs in other folders
  paths.emplace_back(kLibcameraPluginFile);  // where the system looks
  void* library = nullptr;
  std::string refused;  // why a file that exists was refused, else the first file's error
  for (const std::string& path : paths) {
    if (!library) library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    const char* const said = library ? nullptr : dlerror();
    if (said && (refused.empty() || (path[0] == '/' && access(path.c_str(), F_OK) == 0))) refused = said;
  }
  void* entry = library ? dlsym(library, kLibcameraPluginEntry) : nullptr;
  if (!entry) {
    why = "libcamera cannot be used: " + (refused.empty() ? "its library is another one" : refused) +
          "; it is built where libcamera-dev is installed: sudo apt install libcamera-dev, then build again";
    return Error{Errc::not_supported, "libcamera"};
  }
  Result<std::unique_ptr<Camera>> camera = Error{Errc::io, "libcamera"};
  reinterpret_cast<LibcameraPluginEntry*>(entry)(spec, os, why, camera);
  return camera;
}

}  // namespace sinew::hal
