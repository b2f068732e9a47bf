#include "hal/linux/memory.hpp"

#include <link.h>
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <span>
#include <string>
#include <vector>

#include "hal/linux/process.hpp"

/// Whole pages of code that no real-time thread runs, where the program is linked with cmake/set_aside.cmake.
extern "C" [[gnu::weak]] std::byte sinew_set_aside_begin[], sinew_set_aside_end[];

namespace sinew::hal {
namespace {

/// A line of /proc/self/maps or smaps. Source: proc(5)
struct Mapping {
  std::uintptr_t begin = 0, end = 0;
  std::string access, path;
  std::uint64_t resident = 0;  // of smaps only
  bool is_stack = false;

  bool holds(const void* p) const {
    const auto at = reinterpret_cast<std::uintptr_t>(p);
    return at >= begin && at < end;
  }
  bool is_file() const { return !path.empty() && path[0] == '/'; }
  bool is_memfd() const { return path.starts_with("/memfd:"); }
};

/// A stack of Os::start_thread() lies between two of them, so that no other mapping can merge with it.
bool is_guard(const Mapping& m) { return m.path.empty() && m.access == "---p"; }

std::vector<Mapping> mappings(const char* file) {
  std::vector<Mapping> all;
  std::FILE* in = std::fopen(file, "r");
  if (!in) return all;
  char line[4400];
  while (std::fgets(line, sizeof(line), in)) {
    unsigned long begin = 0, end = 0;
    unsigned long long kib = 0;
    char access[8] = "";
    int path = 0;
    if (std::sscanf(line, "%lx-%lx %7s %*s %*s %*s %n", &begin, &end, access, &path) == 3 && path > 0) {
      line[std::strcspn(line, "\n")] = 0;
      all.push_back({begin, end, access, line + path, 0, false});
      all.back().is_stack = all.back().path.starts_with("[stack");
    } else if (!all.empty() && std::sscanf(line, "Rss: %llu kB", &kib) == 1) {
      all.back().resident = kib * 1024;
    }
  }
  std::fclose(in);
  for (std::size_t i = 1; i + 1 < all.size(); ++i)
    if (all[i].path.empty() && is_guard(all[i - 1]) && is_guard(all[i + 1])) all[i].is_stack = true;
  return all;
}

bool is_the_systems(const std::string& path) { return path.starts_with("/usr/") || path.starts_with("/lib"); }

/// The C library's file; empty where the library is part of the program.
std::string c_library(const std::vector<Mapping>& all) {
  const void* in_it = reinterpret_cast<const void*>(&::clock_nanosleep);
  for (const Mapping& m : all)
    if (m.holds(in_it)) return m.path;
  return {};
}

struct PageRange {
  std::uintptr_t begin = 0, end = 0;
};

/// Whole pages of the program and its libraries that no loop reads: symbols and relocations, which the start has used
/// (a segment without data, in front of the code), and the tables for exceptions, which stand at the end of a segment.
/// Source: ELF gABI, program headers; PT_GNU_EH_FRAME in the Linux Standard Base
std::vector<PageRange> tables_without_use() {
  std::vector<PageRange> all;
  const auto add = [](dl_phdr_info* object, std::size_t, void* to) {
    const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
    const std::span headers(object->dlpi_phdr, object->dlpi_phnum);
    const auto frames = std::ranges::find(headers, PT_GNU_EH_FRAME, [](const auto& h) { return h.p_type; });
    if (frames == headers.end()) return 0;
    for (const auto& h : headers) {
      if (h.p_type != PT_LOAD || h.p_flags != PF_R) continue;
      const bool has_frames = frames->p_vaddr >= h.p_vaddr && frames->p_vaddr < h.p_vaddr + h.p_memsz;
      if (!has_frames && h.p_offset != 0) continue;  // data
      const std::uintptr_t begin = object->dlpi_addr + (has_frames ? frames->p_vaddr : h.p_vaddr);
      const std::uintptr_t end = object->dlpi_addr + h.p_vaddr + h.p_memsz;
      const PageRange pages{(begin + page - 1) / page * page, end / page * page};
      if (pages.begin < pages.end) static_cast<std::vector<PageRange>*>(to)->push_back(pages);
    }
    return 0;
  };
  ::dl_iterate_phdr(add, &all);
  const auto begin = reinterpret_cast<std::uintptr_t>(sinew_set_aside_begin);
  const auto end = reinterpret_cast<std::uintptr_t>(sinew_set_aside_end);
  if (begin < end) all.push_back({begin, end});
  std::ranges::sort(all, {}, &PageRange::begin);
  return all;
}

/// Locks [begin, end) without `left_out`, which are sorted.
bool lock_but(PageRange range, const std::vector<PageRange>& left_out) {
  const auto lock = [](std::uintptr_t begin, std::uintptr_t end) {
    return begin >= end || ::mlock(reinterpret_cast<const void*>(begin), end - begin) == 0;
  };
  for (const PageRange& out : left_out) {
    if (out.end <= range.begin || out.begin >= range.end) continue;
    if (!lock(range.begin, out.begin)) return false;
    range.begin = out.end;
  }
  return lock(range.begin, range.end);
}

/// Gives the pages back. This comes after the locks around: a fault brings in the pages around it up to the ends of
/// their mapping, and only these locks have made the range a mapping of its own and brought in its neighbours.
bool give_back(PageRange range) {
  auto* const begin = reinterpret_cast<void*>(range.begin);
  const std::size_t size = range.end - range.begin;
  return ::munlock(begin, size) == 0 && ::madvise(begin, size, MADV_DONTNEED) == 0;
}

}  // namespace

Status lock_process_memory() {
  ::malloc_trim(0);  // memory that the start has freed
  const std::vector<PageRange> tables = tables_without_use();
  if (::mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) != 0) {
    if (errno != EINVAL) return Error{Errc::denied, "mlockall", errno};
    // Kernels before 4.4 lock everything at once.
    if (::mlockall(MCL_CURRENT | MCL_FUTURE) != 0) return Error{Errc::denied, "mlockall", errno};
    return {};
  }
  const auto all = mappings("/proc/self/maps");
  const std::string libc = c_library(all), program = program_path();
  for (const Mapping& m : all) {
    const bool is_data = m.access == "rw-p" && !m.is_stack;
    const bool is_ours = m.is_file() && !m.is_memfd() && (m.path == program || !is_the_systems(m.path));
    const bool is_c_code = m.path == libc && m.access == "r-xp";  // its tables for languages and errors are left out
    if ((is_data || (is_ours && m.access[0] == 'r') || is_c_code) && !lock_but({m.begin, m.end}, tables))
      return Error{Errc::denied, "mlock", errno};
  }
  for (const PageRange& t : tables)
    if (!give_back(t)) return Error{Errc::denied, "munlock", errno};
  // Each of these pages is locked again when it is used.
  if (::mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) != 0) return Error{Errc::denied, "mlockall", errno};
  return {};
}

MemoryUse memory_use() {
  MemoryUse use;
  const std::string program = program_path();
  for (const Mapping& m : mappings("/proc/self/smaps")) {
    const bool nameless_data = m.path.empty() && !m.is_stack;
    use.total += m.resident;
    if (m.is_memfd())
      (m.access[1] == 'w' ? use.slots : use.peers) += m.resident;
    else if (m.is_file())
      (m.path == program ? use.program : use.libraries) += m.resident;
    else if (m.is_stack)
      use.stacks += m.resident;
    else if (m.path == "[heap]" || nameless_data)  // large blocks have their own mappings
      use.heap += m.resident;
    else
      use.other += m.resident;
  }
  return use;
}

}  // namespace sinew::hal
