#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace sinew::app {

/// The header of one file in a tar stream (512 bytes). The file follows, filled up with tar_padding(); kTarEnd ends
/// all. Empty: a name of more than 255 bytes (or that cannot be cut at a '/'), or a file of 8 GiB or more. Source:
/// POSIX.1-2017, pax, "ustar Interchange Format".
std::string tar_header(std::string_view name, std::uint64_t size, bool executable, std::int64_t changed_s);

/// Zeros up to the next block.
std::string tar_padding(std::uint64_t size);
inline constexpr std::size_t kTarEnd_bytes = 1024;  // of zeros

}  // namespace sinew::app
