#include "hal/linux/libcamera_plugin.hpp"

#include <dlfcn.h>

#include "hal/linux/process.hpp"

namespace sinew::hal {

Result<std::unique_ptr<Camera>> open_libcamera_plugin(const CameraSpec& spec, Os& os, std::string& why) {
  const std::string program = program_path();
  const std::string beside = program.substr(0, program.rfind('/') + 1) + kLibcameraPluginFile;
  void* library = nullptr;
  for (const std::string& path : {beside, std::string(kLibcameraPluginFile)})
    if (!library) library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* entry = library ? dlsym(library, kLibcameraPluginEntry) : nullptr;
  if (!entry) {
    const char* said = dlerror();
    why = "libcamera cannot be used: " + std::string(said ? said : "its library is another one") +
          "; it is built where libcamera-dev is installed: sudo apt install libcamera-dev, then build again";
    return Error{Errc::not_supported, "libcamera"};
  }
  Result<std::unique_ptr<Camera>> camera = Error{Errc::io, "libcamera"};
  reinterpret_cast<LibcameraPluginEntry*>(entry)(spec, os, why, camera);
  return camera;
}

}  // namespace sinew::hal
