#include "apps/run/trace_file.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>

#include "rt/exec/chrome_trace.hpp"

namespace sinew::app {

bool write_trace(const std::string& path, const rt::Runner& runner) {
  errno = 0;
  std::ofstream out(path, std::ios::binary);
  out << rt::chrome_trace(runner.graph(), runner.timeline().snapshot());
  out.close();
  if (out) return true;
  std::fprintf(stderr, "sinew: --trace %s: %s\n", path.c_str(), std::strerror(errno));
  return false;
}

}  // namespace sinew::app
