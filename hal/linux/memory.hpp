#pragma once
// What of the process is in memory: where it goes, and how it is kept there.
#include <cstdint>

#include "hal/result.hpp"

namespace sinew::hal {

/// Nothing that a loop touches may be taken away or come late: all pages, now and later, are locked as they are
/// touched; those of the program, of libraries outside of the system's folders, the C library's code, and all data and
/// heap are touched at once. Left to the first touch are: other system libraries (a loop calls few of them, and their
/// initialisation has touched those), stacks of Os::start_thread(), which touch themselves what was asked for, and
/// tables that no loop reads: symbols and relocations, which the start has used, and where exceptions are caught.
/// Errors:  denied: nothing is locked.
Status lock_process_memory();

/// Bytes in memory now, by what they are for.
struct MemoryUse {
  std::uint64_t total = 0;
  std::uint64_t slots = 0;      // memory of our own that others may be given: the messages
  std::uint64_t peers = 0;      // memory that others gave us
  std::uint64_t program = 0;    // its code and data
  std::uint64_t libraries = 0;  // theirs
  std::uint64_t heap = 0;       // what was allocated
  std::uint64_t stacks = 0;
  std::uint64_t other = 0;
};
MemoryUse memory_use();

}  // namespace sinew::hal
