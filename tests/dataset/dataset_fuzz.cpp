// Any bytes as the text files and images of a dataset: the first byte chooses the reader, the rest is the file.
#include <cstdlib>

#include "dataset/dataset_files.hpp"
#include "dataset/png_image.hpp"

using namespace sinew;
using namespace sinew::dataset;

namespace {
template <class T, class Stamp>
void check(const std::vector<T>& values, bool good, const std::string& why, const Stamp& stamp) {
  if (good != why.empty()) std::abort();
  for (std::size_t i = 1; i < values.size(); ++i)
    if (stamp(values[i]) <= stamp(values[i - 1])) std::abort();
}
}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data + 1), size - 1);
  std::string why;
  switch (data[0] % 4) {
    case 0: {
      std::vector<msg::ImuSample> out;
      const bool good = parse_imu_csv(text, "f", out, why);
      check(out, good, why, [](const auto& s) { return s.stamp.ns; });
      break;
    }
    case 1: {
      std::vector<ImageEntry> out;
      const bool good = parse_image_list(text, "f", out, why);
      check(out, good, why, [](const auto& e) { return e.stamp_ns; });
      for (const auto& e : out)
        if (e.file.find('/') != std::string::npos) std::abort();
      break;
    }
    case 2: {
      std::vector<GroundTruthSample> out;
      const bool good = parse_ground_truth_csv(text, "f", out, why);
      check(out, good, why, [](const auto& s) { return s.stamp_ns; });
      break;
    }
    case 3: {
      DecodedImage image;
      if (decode_png({data + 1, size - 1}, image, why) &&
          image.pixels.size() != std::size_t{image.width} * image.height * bytes_per_pixel(image.format))
        std::abort();
      break;
    }
  }
  return 0;
}
