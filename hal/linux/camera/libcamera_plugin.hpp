#pragma once
#include <memory>
#include <string>
#include <vector>

#include "hal/connectors.hpp"
#include "hal/os.hpp"

namespace sinew::hal {

/// Opens a camera of libcamera through the library libsinew_libcamera.so. The library is loaded at the first call: from
/// the folder of the program, from an installed Sinew, or from the system's folders. Only this library links libcamera:
/// libcamera starts threads as soon as it is loaded, and a runtime is forked from a process with one thread.
/// Errors:  not_supported when there is no such library, with the reason in `why`; else those of LibcameraCamera.
Result<std::unique_ptr<Camera>> open_libcamera_plugin(const CameraSpec& spec, Os& os, std::string& why);

/// The function that the library exports under kLibcameraPluginEntry.
using LibcameraPluginEntry = void(const CameraSpec& spec, Os& os, std::string& why,
                                  Result<std::unique_ptr<Camera>>& out);
inline constexpr const char* kLibcameraPluginEntry = "sinew_open_libcamera";
inline constexpr const char* kLibcameraPluginFile = "libsinew_libcamera.so";

/// Possible places of the library for a program, in the order of the search: beside it, and in the library folder of
/// the prefix whose bin/ holds it.
std::vector<std::string> libcamera_plugin_paths(const std::string& program);

}  // namespace sinew::hal
