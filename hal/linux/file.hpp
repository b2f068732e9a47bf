#pragma once
#include <memory>
#include <string>

#include "hal/file.hpp"

namespace sinew::hal {

/// Makes a new file; when this returns, its name survives a loss of power, too.
/// Errors:  busy when there is something of that name already; denied, not_found (the folder), io.
Result<std::unique_ptr<OutputFile>> create_file(const std::string& path);

/// Errors:  not_found, denied, io; bad_argument when it is no ordinary file.
Result<std::unique_ptr<InputFile>> open_file(const std::string& path);

}  // namespace sinew::hal
