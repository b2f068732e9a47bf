// For any file, its reading ends with results or with a reason, and what is merged from it is read again.
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "apps/sweep/case_result.hpp"
#include "apps/sweep/results_file.hpp"
#include "apps/sweep/summary.hpp"

namespace {

std::string place(const char* name) {
  return (std::filesystem::temp_directory_path() / (std::to_string(::getpid()) + name)).string();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sinew::sweep;
  if (size > 65536) return 0;
  const std::string path = place(".jsonl"), merged_path = place(".merged");
  std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  Identity identity;
  Shard shard;
  Summary summary;
  std::string why;
  const auto see = [&](const ResultLine& line) {
    summary.add(case_result(line.number, line.result));
    return true;
  };
  if (!read_results(path, identity, shard, see, why) && why.empty()) std::abort();
  if (summary.text(identity.cases).empty() || summary.json(identity.cases).empty()) std::abort();
  Merged merged;
  std::string again;
  // A file with as many cases as the format allows takes long to merge, and shows nothing new.
  if (identity.cases < 10'000 && merge_results({path}, merged_path, merged, again) &&
      !read_results(
          merged_path, identity, shard, [](const ResultLine&) { return true; }, again) &&
      why.empty())
    std::abort();
  std::filesystem::remove(path);
  std::filesystem::remove(merged_path);
  return 0;
}
