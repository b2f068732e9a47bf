#pragma once
// Files in memory that play the failures of disks.
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hal/file.hpp"
#include "record/memory_input.hpp"

namespace sinew::record {

using Bytes = std::vector<std::byte>;

/// A test's view of a file, and the failures that it orders. Outlives the file.
struct Disk {
  Bytes bytes;
  /// append() fails where the file would grow beyond, like a full disk.
  std::atomic<std::uint64_t> room{~std::uint64_t{0}};
  std::uint64_t free = ~std::uint64_t{0};  // the answer of free_bytes()
  bool sync_fails = false, cut_fails = false, settle_fails = false;
  bool stalls = false;  // settled() is false, until somebody waits in settle()
  bool removed = false;
  int appends = 0, syncs = 0, cuts = 0, waits = 0;
  std::size_t synced = 0;                        // bytes that a loss of power leaves
  std::function<void()> on_append{}, on_sync{};  // a stall

  Disk() = default;
  Disk(const Disk&) = delete;
  Disk& operator=(const Disk&) = delete;
  ~Disk() { keep(); }

 private:
  /// Keeps whole files in the folder SINEW_KEEP_FILES, for foreign readers.
  void keep() const {
    static int kept = 0;
    const char* folder = std::getenv("SINEW_KEEP_FILES");
    const bool whole =
        bytes.size() > 8 && std::equal(bytes.end() - 8, bytes.end(), bytes.begin());  // magic at both ends
    if (folder == nullptr || !whole) return;
    const std::string path =
        std::string(folder) + "/" + std::to_string(::getpid()) + "-" + std::to_string(kept++) + ".mcap";
    if (std::FILE* file = std::fopen(path.c_str(), "wb")) {
      std::fwrite(bytes.data(), 1, bytes.size(), file);
      std::fclose(file);
    }
  }
};

class MemoryOutput final : public hal::OutputFile {
 public:
  explicit MemoryOutput(Disk& disk) : disk_(disk) {}
  hal::Status append(hal::Parts parts) noexcept override {
    ++disk_.appends;
    if (disk_.on_append) disk_.on_append();
    for (const auto& part : parts) {
      const std::uint64_t room = disk_.room > disk_.bytes.size() ? disk_.room - disk_.bytes.size() : 0;
      const auto fits = part.first(static_cast<std::size_t>(std::min<std::uint64_t>(part.size(), room)));
      disk_.bytes.insert(disk_.bytes.end(), fits.begin(), fits.end());  // a part of it arrives, as with writev()
      if (fits.size() != part.size()) return hal::Error{hal::Errc::io, "memory file", ENOSPC};
    }
    return {};
  }
  hal::Status sync() noexcept override {
    ++disk_.syncs;
    if (disk_.on_sync) disk_.on_sync();
    if (disk_.sync_fails) return hal::Error{hal::Errc::io, "memory file", EIO};
    disk_.synced = disk_.bytes.size();
    return {};
  }
  hal::Status cut(std::uint64_t size) noexcept override {
    ++disk_.cuts;
    if (disk_.cut_fails) return hal::Error{hal::Errc::io, "memory file", EIO};
    disk_.bytes.resize(static_cast<std::size_t>(size));
    return {};
  }
  hal::Result<std::uint64_t> free_bytes() noexcept override { return disk_.free; }
  hal::Status settle() noexcept override {
    ++disk_.waits;
    if (disk_.settle_fails) return hal::Error{hal::Errc::io, "memory file", ENOSPC};
    disk_.stalls = false;
    return {};
  }
  bool settled() noexcept override { return !disk_.stalls; }
  hal::Status remove() noexcept override {
    disk_.removed = true;
    return {};
  }

 private:
  Disk& disk_;
};

}  // namespace sinew::record
