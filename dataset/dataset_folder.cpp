#include "dataset/dataset_folder.hpp"

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace sinew::dataset {

namespace fs = std::filesystem;
using hal::Errc;
using hal::Error;

bool read_file(const std::string& path, std::string& out, std::string& why) {
  why.clear();
  std::error_code error;
  if (!fs::exists(path, error)) return false;
  std::ifstream in(path, std::ios::binary);
  if (!fs::is_regular_file(path, error) || !in) {
    why = path + ": cannot be read";
    return false;
  }
  out.assign(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  if (in.bad()) why = path + ": reading failed";
  return !in.bad();
}

namespace {

/// Images of the flat form, whose names are their stamps.
bool list_images(const std::string& folder, std::vector<ImageEntry>& out, std::string& why) {
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    ImageEntry e{0, name};
    if (!name.ends_with(".png")) continue;
    if (!stamp_of_image_name(name, e.stamp_ns)) {
      why = folder + name + ": the name of an image must be its stamp in nanoseconds";
      return false;
    }
    out.push_back(e);
  }
  if (error) {
    why = folder + ": " + error.message();
    return false;
  }
  std::sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.stamp_ns < b.stamp_ns; });
  const auto twice =
      std::adjacent_find(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.stamp_ns == b.stamp_ns; });
  if (twice != out.end()) why = folder + (twice + 1)->file + ": the stamp of " + twice->file + " again";
  return twice == out.end();
}

/// False with an empty `why`: there is no such file.
template <class Parse, class Out>
bool read_list(const std::string& path, const Parse& parse, Out& out, std::string& why) {
  std::string text;
  return read_file(path, text, why) && parse(text, path, out, why);
}

}  // namespace

hal::Result<DatasetFolder> DatasetFolder::open(const std::string& folder, std::string& why) {
  const char* const where = "DatasetFolder::open";
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    why = folder + ": no such folder";
    return Error{Errc::not_found, where};
  }
  DatasetFolder out;
  const bool asl = fs::is_directory(folder + "/mav0", error);
  const std::string imu = folder + (asl ? "/mav0/imu0/data.csv" : "/imu0.csv");
  if (!read_list(imu, parse_imu_csv, out.imu, why) && !why.empty()) return Error{Errc::bad_data, where};
  if (asl) {
    out.image_folder = folder + "/mav0/cam0/data/";
    const std::string list = folder + "/mav0/cam0/data.csv";
    if (!read_list(list, parse_image_list, out.images, why) && !why.empty()) return Error{Errc::bad_data, where};
  } else if (out.image_folder = folder + "/cam0/"; fs::is_directory(out.image_folder, error)) {
    if (!list_images(out.image_folder, out.images, why)) return Error{Errc::bad_data, where};
  }
  if (out.imu.empty() && out.images.empty()) {
    why = folder + ": neither IMU samples (" + imu + ") nor images (" + out.image_folder + ")";
    return Error{Errc::not_found, where};
  }
  return out;
}

hal::Status DatasetFolder::decode(const ImageEntry& image, DecodedImage& out, std::string& why) const {
  const std::string path = image_folder + image.file;
  std::string bytes;
  if (!read_file(path, bytes, why)) {
    if (why.empty()) why = path + ": no such file";
    return Error{Errc::io, "DatasetFolder::decode", errno};
  }
  std::string reason;
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  if (!decode_png({data, bytes.size()}, out, reason)) {
    why = path + ": " + reason;
    return Error{Errc::bad_data, "DatasetFolder::decode"};
  }
  return {};
}

}  // namespace sinew::dataset
