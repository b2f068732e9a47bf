#pragma once
#include <memory>
#include <string>

#include "hal/file.hpp"

namespace sinew::hal {

/// Makes a new file; when this returns, its name survives a loss of power, too.
/// Errors:  busy when there is something of that name already; denied, not_found (the folder), io.
Result<std::unique_ptr<OutputFile>> create_file(const std::string& path);

/// Opens a file to append to, or makes one, for this process alone: as long as it is open, nobody else can open it this
/// way. Each append() of one part is one write at the end of the file, wherever another process has moved it.
/// Errors:  busy when it is open already; bad_argument when it is no ordinary file; denied, not_found (the folder), io.
Result<std::unique_ptr<OutputFile>> open_to_append(const std::string& path);

/// Errors:  not_found, denied, io; bad_argument when it is no ordinary file.
Result<std::unique_ptr<InputFile>> open_file(const std::string& path);

}  // namespace sinew::hal
