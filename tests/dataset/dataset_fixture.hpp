#pragma once
// Small recorded folders, made where the tests run.
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "png_writer.hpp"

namespace sinew::dataset::test {

/// A folder that goes away with the test.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "sinew_dataset_XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  std::string path() const { return path_; }
  void write(const std::string& name, const std::string& text) const {
    const std::filesystem::path file = std::filesystem::path(path_) / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << text;
  }
  void write(const std::string& name, const std::vector<std::uint8_t>& bytes) const {
    write(name, std::string(bytes.begin(), bytes.end()));
  }

 private:
  std::string path_;
};

inline constexpr std::int64_t kFirst = 1'400'000'000'000'000'000;  // ns, as real datasets have it

/// `n` samples 5 ms apart, `after` the first stamp; gyro x counts them.
inline std::string imu_csv(int n, std::int64_t after_ns = 0) {
  std::string text = "#timestamp [ns],wx,wy,wz,ax,ay,az\n";
  for (int i = 0; i < n; ++i)
    text += std::to_string(kFirst + after_ns + i * 5'000'000LL) + "," + std::to_string(i) + ",0.5,-0.25,0,0,9.81\n";
  return text;
}

/// A grey picture, every pixel `value`.
inline std::vector<std::uint8_t> grey_png(std::uint8_t value, std::uint32_t width = 32, std::uint32_t height = 24) {
  return encode_png(std::vector<std::uint8_t>(std::size_t{width} * height, value), width, height, 1);
}

inline std::string image_name(std::int64_t after_ns) { return std::to_string(kFirst + after_ns) + ".png"; }

}  // namespace sinew::dataset::test
