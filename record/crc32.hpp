#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace sinew::record {

/// The CRC-32 of zlib, PNG and MCAP; carries on from the sum of the bytes before. Gigabytes a second on processors that
/// can multiply polynomials; the same sum on all.
/// Thread:  any.   RT: yes.
std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t before = 0);

/// The sum of two pieces from the sums of each, without their bytes.
std::uint32_t crc32_joined(std::uint32_t first, std::uint32_t second, std::uint64_t second_bytes);

}  // namespace sinew::record
