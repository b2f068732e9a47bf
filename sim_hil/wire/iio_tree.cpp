#include "sim_hil/wire/iio_tree.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

namespace sinew::sim_hil {
namespace {

constexpr const char* kDevices = "/sys/bus/iio/devices/";
constexpr std::array<const char*, 3> kAxis{"_x", "_y", "_z"};
constexpr const char* kStampForm = "le:s64/64>>0";

bool write(const std::string& path, const std::string& text) {
  std::ofstream out(path);
  out << text << '\n';
  return out.good();
}

}  // namespace

hal::Result<std::unique_ptr<IioTree>> IioTree::make(const IioTreeSpec& spec) {
  std::unique_ptr<IioTree> tree(new IioTree(spec));
  if (!spec.mount_matrix.empty()) {
    const auto matrix = wire::parse_iio_mount_matrix(spec.mount_matrix);
    if (!matrix) return hal::Error{hal::Errc::bad_argument, "iio tree: mount matrix"};
    tree->mount_ = *matrix;
  }
  const auto form = wire::parse_iio_form(spec.form);
  if (!form) return hal::Error{hal::Errc::bad_argument, "iio tree: form"};
  std::uint32_t index = 0;
  for (const bool there : {spec.accel, spec.gyro})
    for (std::size_t i = 0; there && i < 3; ++i) tree->layout_.add(index++, *form);
  if (spec.stamps) tree->layout_.add(index, *wire::parse_iio_form(kStampForm));

  std::error_code failed;
  std::filesystem::create_directories(tree->folder_ + "/scan_elements", failed);
  std::filesystem::create_directories(tree->folder_ + "/buffer", failed);
  std::filesystem::create_directories(tree->folder_ + "/trigger", failed);
  std::filesystem::create_directories(spec.root + "/dev", failed);
  if (failed || !write(tree->folder_ + "/name", spec.name)) return hal::Error{hal::Errc::io, "iio tree: folder"};
  tree->make_files();
  return tree;
}

IioTree::IioTree(const IioTreeSpec& spec)
    : spec_(spec), folder_(spec.root + kDevices + "iio:device" + std::to_string(spec.number)) {}

IioTree::~IioTree() { unplug(); }

void IioTree::make_files() {
  if (!spec_.label.empty()) set_file("label", spec_.label);
  if (!spec_.mount_matrix.empty()) set_file("in_mount_matrix", spec_.mount_matrix);
  set_file("sampling_frequency", "200");
  set_file("current_timestamp_clock", "realtime");
  set_file("trigger/current_trigger", "");
  std::ofstream(folder_ + "/trigger/current_trigger");
  std::uint32_t index = 0;
  const auto add = [&](const std::string& element, const std::string& form) {
    set_file("scan_elements/" + element + "_en", "0");
    set_file("scan_elements/" + element + "_index", std::to_string(index++));
    set_file("scan_elements/" + element + "_type", form);
  };
  const auto add_sensor = [&](const std::string& name, double scale) {
    std::ostringstream text;
    text.precision(9);
    text << std::fixed << scale;
    set_file("in_" + name + "_scale", text.str());
    if (spec_.offset != 0) set_file("in_" + name + "_offset", std::to_string(spec_.offset));
    for (const char* axis : kAxis) {
      set_file("in_" + name + axis + "_raw", "0");
      add("in_" + name + axis, spec_.form);
    }
  };
  if (spec_.accel) add_sensor("accel", spec_.accel_scale);
  if (spec_.gyro) add_sensor("anglvel", spec_.gyro_scale);
  if (spec_.stamps) add("in_timestamp", kStampForm);
  set_file("buffer/enable", "0");
  set_file("buffer/length", "2");
  set_file("buffer/watermark", "1");
  if (!spec_.buffer) {
    std::filesystem::remove_all(folder_ + "/scan_elements");
    std::filesystem::remove_all(folder_ + "/buffer");
  }
}

std::string IioTree::buffer_path() const { return spec_.root + "/dev/iio:device" + std::to_string(spec_.number); }

bool IioTree::enabled() const { return file("buffer/enable") == "1"; }

std::array<std::int64_t, 3> IioTree::counts(const msg::Vec3& v, double scale) const {
  // The matrix takes the chip's axes to the board's; it is a rotation, so its transpose goes back.
  std::array<std::int64_t, 3> out{};
  for (std::size_t i = 0; i < 3; ++i)
    out[i] = std::llround((mount_[i] * v.x + mount_[3 + i] * v.y + mount_[6 + i] * v.z) / scale - spec_.offset);
  return out;
}

hal::Status IioTree::feed(const msg::ImuSample& sample) {
  if (!there_) return hal::Error{hal::Errc::closed, "iio tree: unplugged"};
  std::vector<std::uint8_t> scan(layout_.scan_bytes());
  std::uint32_t index = 0;
  const auto put = [&](const std::string& name, const msg::Vec3& v, double scale) {
    const auto raw = counts(v, scale);
    for (std::size_t i = 0; i < 3; ++i) {
      put_iio_raw(scan, *layout_.find(index++), raw[i]);
      if (!spec_.buffer) set_file("in_" + name + kAxis[i] + "_raw", std::to_string(raw[i]));
    }
  };
  if (spec_.accel) put("accel", sample.accel_mps2, spec_.accel_scale);
  if (spec_.gyro) put("anglvel", sample.gyro_radps, spec_.gyro_scale);
  if (spec_.stamps) put_iio_raw(scan, *layout_.find(index), sample.stamp.ns);
  return spec_.buffer && enabled() ? feed_raw(scan) : hal::Status{};
}

hal::Status IioTree::feed_raw(std::span<const std::uint8_t> bytes) {
  if (!pipe_) return hal::Error{hal::Errc::closed, "iio tree: no buffer"};
  const auto n = pipe_->write_now(bytes);
  if (!n) return n.error();
  if (*n == bytes.size()) return {};
  return hal::Error{hal::Errc::timeout, "iio tree: buffer full"};
}

void IioTree::unplug() {
  there_ = false;
  std::error_code ignored;  // gone is gone
  std::filesystem::remove_all(folder_, ignored);
  pipe_.reset();
}

void IioTree::make_trigger(const std::string& root, unsigned number, const std::string& name) {
  const std::string folder = root + kDevices + "trigger" + std::to_string(number);
  std::filesystem::create_directories(folder);
  write(folder + "/name", name);
  write(folder + "/sampling_frequency", "100");
}

std::string IioTree::file(const std::string& name) const {
  std::ifstream in(folder_ + "/" + name);
  std::string line;
  std::getline(in, line);
  return line;
}

void IioTree::set_file(const std::string& name, const std::string& text) {
  if (text.empty())
    std::filesystem::remove(folder_ + "/" + name);
  else
    write(folder_ + "/" + name, text);
}

}  // namespace sinew::sim_hil
