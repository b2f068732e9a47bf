#include "apps/robot/write_stall.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <vector>

#include "hal/linux/file.hpp"
#include "hal/platform.hpp"

namespace sinew::app {
namespace {

constexpr std::size_t kPieceBytes = 256 * 1024;              // as the chunks of recordings
constexpr double kStepBytes = 100, kMessageBytes = 31 + 16;  // around the content: record and index
constexpr double kSafety = 1.5;

/// Bytes that no file system can compress.
std::vector<std::byte> noise() {
  std::vector<std::byte> bytes(kPieceBytes);
  std::uint32_t x = 2463534242;  // xorshift32 (Marsaglia, 2003)
  for (std::byte& b : bytes) {
    x ^= x << 13, x ^= x >> 17, x ^= x << 5;
    b = static_cast<std::byte>(x);
  }
  return bytes;
}

std::string system_text(const hal::Error& error) {
  return error.code == hal::Errc::io && error.detail != 0 ? std::strerror(static_cast<int>(error.detail))
                                                          : hal::to_string(error.code);
}

}  // namespace

hal::Result<WriteStall> measure_write_stall(hal::OutputFile& file, hal::Os& os, double bytes_per_s,
                                            hal::Duration length) {
  const std::vector<std::byte> piece = noise();
  const std::span<const std::byte> part = piece;
  const auto every = hal::Duration{static_cast<std::int64_t>(1e9 * static_cast<double>(kPieceBytes) / bytes_per_s)};
  WriteStall stall;
  const hal::Time begin = os.now();
  for (hal::Time due = begin; due - begin < length; due = due + every) {
    os.sleep_until(due);
    const hal::Time before = os.now();
    if (before - begin >= length) break;  // it is too slow for what comes due
    if (auto done = file.append({&part, 1}); !done) return done.error();
    if (auto done = file.sync(); !done) return done.error();
    stall.worst = std::max(stall.worst, os.now() - before);
    stall.bytes += kPieceBytes;
  }
  stall.length = os.now() - begin;
  return stall;
}

double recorded_bytes_per_s(const rt::Graph& graph, const RecordOptions& record) {
  double sum = 0;
  bool images = false;
  for (std::uint32_t t = 0; t < graph.topics().size(); ++t) {
    const msg::TypeInfo& type = *graph.topics()[t].type;
    images |= type.has_bulk();
    sum += std::max(graph.planned_rate_hz(t), 0.0) * (static_cast<double>(type.size) + kMessageBytes + kStepBytes);
  }
  return sum + (images ? record.pixel_mb_per_s * 1e6 : 0);
}

hal::SystemCheck write_stall_check(const WriteStall& stall, double bytes_per_s, const RecordOptions& record) {
  const double worst_s = msg::seconds(stall.worst), length_s = msg::seconds(stall.length);
  // Pixels of a second may come at once: their budget saves that much.
  const double needed_mb = std::ceil(1e-6 * kSafety * worst_s * bytes_per_s + record.pixel_mb_per_s);
  const double written = 1e-6 * static_cast<double>(stall.bytes);
  hal::SystemCheck check{"write_stall", hal::CheckState::ok,
                         fmt::format("{}: worst write stall {:.3f} s in {:.0f} s ({:.1f} of {:.1f} MB written); that "
                                     "needs a buffer of {:.0f} MB, record.buffer_mb is {:g}",
                                     record.folder, worst_s, length_s, written, 1e-6 * bytes_per_s * length_s,
                                     needed_mb, record.buffer_mb),
                         ""};
  if (written < 0.9e-6 * bytes_per_s * length_s - 1 - 1e-6 * worst_s * bytes_per_s) {
    check.state = hal::CheckState::problem;
    check.advice = "the disk is too slow for this recording: fewer topics, a lower record.pixel_mb_per_s, another disk";
  } else if (needed_mb > record.buffer_mb) {
    check.state = hal::CheckState::warning;
    check.advice = fmt::format(
        "[record] buffer_mb = {:.0f} in the robot file, or another disk: else a recording lacks "
        "what comes during such a stall",
        needed_mb);
  }
  return check;
}

hal::SystemCheck check_write_stall(const RecordOptions& record, double bytes_per_s, double seconds) {
  const auto failed = [&](const std::string& why) {
    return hal::SystemCheck{"write_stall", hal::CheckState::problem, record.folder + ": " + why,
                            "[record] folder: one that can be written to"};
  };
  namespace fs = std::filesystem;
  std::error_code error;
  const bool is_new = fs::create_directories(record.folder, error);
  if (error) return failed(error.message());
  const std::string path = fmt::format("{}/write-test-{}", record.folder, ::getpid());
  const auto remove = [&] {
    std::error_code none;  // it may not have been made
    fs::remove(path, none);
    if (is_new) fs::remove(record.folder, none);
  };
  auto file = hal::create_file(path);
  if (!file) {
    remove();
    return failed(system_text(file.error()));
  }
  const auto free = (*file)->free_bytes();
  const double most = bytes_per_s * seconds + record.free_floor_mb * 1e6;
  if (free && static_cast<double>(*free) < most) {
    remove();
    return failed(
        fmt::format("{:.0f} MB free, the test needs {:.0f} MB", 1e-6 * static_cast<double>(*free), 1e-6 * most));
  }
  const auto stall = measure_write_stall(**file, hal::system_os(), bytes_per_s,
                                         hal::Duration{static_cast<std::int64_t>(seconds * 1e9)});
  file->reset();
  remove();
  if (!stall) return failed(system_text(stall.error()));
  return write_stall_check(*stall, bytes_per_s, record);
}

}  // namespace sinew::app
