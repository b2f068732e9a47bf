#pragma once
#include <memory>
#include <string>
#include <vector>

#include "hal/connectors.hpp"
#include "hal/os.hpp"

namespace sinew::hal {

/// Opens a camera of libcamera by the library libsinew_libcamera.so, which is loaded at the first call: from the folder
/// of the program, from where an installed Sinew has it, or from where the system looks for libraries. Nobody else
/// links libcamera: it starts threads as soon as it is loaded, and a runtime is forked from a process that has one.
/// Errors:  not_supported when there is no such library, with the reason in `why`; else those of LibcameraCamera.
Result<std::unique_ptr<Camera>> open_libcamera_plugin(const CameraSpec& spec, Os& os, std::string& why);

/// What the library exports under kLibcameraPluginEntry.
using LibcameraPluginEntry = void(const CameraSpec& spec, Os& os, std::string& why,
                                  Result<std::unique_ptr<Camera>>& out);
inline constexpr const char* kLibcameraPluginEntry = "sinew_open_libcamera";
inline constexpr const char* kLibcameraPluginFile = "libsinew_libcamera.so";

/// Where it may stand for a program, in the order of the search: beside it, and in the library folder of the prefix
/// whose bin/ it stands in.
std::vector<std::string> libcamera_plugin_paths(const std::string& program);

}  // namespace sinew::hal
