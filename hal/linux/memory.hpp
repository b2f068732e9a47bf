#pragma once
// The process's memory: how much is used for what, and how it is kept resident.
#include <cstdint>

#include "hal/result.hpp"

namespace sinew::hal {

/// Keeps all memory that a loop touches resident. All pages, now and later, are locked as they are touched. These are
/// touched at once: pages of the program, of libraries outside of the system's folders, the C library's code, and all
/// data and heap. Left to the first touch are: other system libraries (a loop calls few of them, and their
/// initialisation has touched those), stacks of Os::start_thread(), which touch their own pages, and tables that no
/// loop reads: symbols and relocations, which the start has used, and the tables of exceptions. Errors:  denied:
/// nothing is locked.
Status lock_process_memory();

/// Bytes in memory now, by their use.
struct MemoryUse {
  std::uint64_t total = 0;
  std::uint64_t slots = 0;      // our memory that may be given to others: the messages
  std::uint64_t peers = 0;      // memory from other processes
  std::uint64_t program = 0;    // its code and data
  std::uint64_t libraries = 0;  // code and data of libraries
  std::uint64_t heap = 0;       // allocated blocks
  std::uint64_t stacks = 0;
  std::uint64_t other = 0;
};
MemoryUse memory_use();

}  // namespace sinew::hal
