#pragma once
#include <atomic>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/file.hpp"

namespace sinew::record {

/// Memory for the last parts of a recording, each a complete file: kSlots of equal size, written one after the other
/// and over again. Any process with the memory can read the parts, also after their writer has ended.
/// Shape:   header, then kSlots x slot_bytes().
/// Thread:  the writer's; parts(): any, for what is not written meanwhile.
class RingMemory {
 public:
  static constexpr unsigned kSlots = 8;
  static constexpr std::size_t kLeastBytes = 1 << 20;  // the beginning of a part needs room, too
  static constexpr std::size_t kMaxFolder = 1023;

  /// Initialises the memory, zeroed or not. Errors: bad_argument for less than kLeastBytes.
  static hal::Result<RingMemory> create(std::span<std::byte> memory);
  /// Opens another writer's memory; the writer may be dead. Nothing when it is no ring memory.
  static std::optional<RingMemory> open(std::span<std::byte> memory);

  std::size_t slot_bytes() const;
  /// The slot of the oldest part becomes an empty file. The memory outlives it.
  std::unique_ptr<hal::OutputFile> next_part();
  unsigned next_slot() const;
  /// The parts as they are, oldest first; the last may be unfinished.
  std::vector<std::span<const std::byte>> parts() const;
  std::size_t bytes_used() const;

  /// The folder for dumps; empty: not known yet. A path that is too long is not kept.
  void set_folder(std::string_view folder);
  std::string folder() const;

 private:
  struct Header;
  class Part;
  explicit RingMemory(std::span<std::byte> memory) : memory_(memory) {}
  Header& header() const;
  std::span<std::byte> slot(unsigned i) const;

  std::span<std::byte> memory_;
};

}  // namespace sinew::record
