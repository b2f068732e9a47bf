#pragma once
#include <memory>
#include <span>
#include <string_view>

#include "hal/os.hpp"
#include "hal/stream.hpp"

namespace sinew::hal {

/// Zeroed pages as a memfd, sealed against shrinking, growing and (later mappings) writing. `name` is only seen in
/// /proc. Locked where permitted. Closed and unmapped by the destructor; peers keep their own mapping.
/// Errors:  bad_argument for 0 bytes; io, out_of_memory.
Result<std::unique_ptr<SharedMemory>> create_shared_memory(std::string_view name, std::size_t bytes);

/// Maps a handle from another process read-only, or opens it for copying; owns the handle from then on, also on
/// failure.
/// Errors:  bad_data when it is no memfd, empty, or its owner could shrink it (our read would then be a bus error); io.
Result<std::unique_ptr<SharedMemory>> open_shared_memory(int fd, Stream::MemoryAccess access);

/// Sleeps, across processes, while the word of a shared memory holds `expected`, at most until `deadline`; read access
/// is enough. May return early; callers look again.
void wait_shared(const WakeWord& word, std::uint32_t expected, Time deadline) noexcept;
/// A word of several that a thread waits for, and what it held when the thread looked.
struct SeenWord {
  const WakeWord* word;
  std::uint32_t seen;
};
/// Sleeps, across processes, until one of the words is woken that does not hold what was seen any more; at most until
/// `deadline`. May return early; callers look again. One call of the kernel takes kMostWords; with more of them, or
/// before Linux 5.16, it returns after 5 ms at the latest.
void wait_any_shared(std::span<const SeenWord> words, Time deadline) noexcept;
inline constexpr std::size_t kMostWords = 128;
/// Wakes all sleepers on it, in any process.
void wake_shared(const WakeWord& word) noexcept;

}  // namespace sinew::hal
