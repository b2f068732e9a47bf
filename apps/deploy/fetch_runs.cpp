#include "apps/deploy/fetch_runs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <set>

#include "apps/deploy/board_shell.hpp"

namespace sinew::app {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kBeingWritten_s = 5;  // a recorder writes at least once a second

constexpr std::array<std::uint32_t, 256> crc_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t crc = i << 24;
    for (int bit = 0; bit < 8; ++bit) crc = (crc << 1) ^ (crc >> 31 ? 0x04C11DB7u : 0);
    table[i] = crc;
  }
  return table;
}
constexpr auto kCrc = crc_table();

std::uint32_t crc_step(std::uint32_t crc, unsigned byte) { return (crc << 8) ^ kCrc[(crc >> 24) ^ (byte & 0xff)]; }

template <class T>
bool take_number(std::string_view& line, T& out) {
  const auto got = std::from_chars(line.data(), line.data() + line.size(), out);
  if (got.ec != std::errc()) return false;
  line.remove_prefix(static_cast<std::size_t>(got.ptr - line.data()));
  return line.starts_with(' ') ? (line.remove_prefix(1), true) : line.empty();
}

/// Does not trust a board with our disk: a name must stay below the folder, and be text.
bool harmless(std::string_view name) {
  const fs::path path(name);
  return !name.empty() && path.is_relative() && std::find(path.begin(), path.end(), "..") == path.end() &&
         std::none_of(name.begin(), name.end(), [](char c) { return static_cast<unsigned char>(c) < 32 || c == 127; });
}

/// "runs/quad-1" of "runs/quad-1/run.mcap".
std::string folder_of_run(const std::string& name) {
  const auto first = name.find('/');
  const auto second = first == std::string::npos ? first : name.find('/', first + 1);
  return second == std::string::npos ? name : name.substr(0, second);
}

std::uint64_t size_of(const fs::path& path) {
  std::error_code none;
  const auto size = fs::file_size(path, none);
  return none ? 0 : size;
}

}  // namespace

void PosixCksum::add(std::string_view bytes) {
  for (const char c : bytes) crc_ = crc_step(crc_, static_cast<unsigned char>(c));
  length_ += bytes.size();
}

std::uint32_t PosixCksum::value() const {
  std::uint32_t crc = crc_;
  for (std::uint64_t left = length_; left != 0; left >>= 8) crc = crc_step(crc, static_cast<unsigned>(left & 0xff));
  return ~crc;
}

BoardListing parse_listing(std::string_view now, std::string_view lines) {
  BoardListing listing;
  take_number(now, listing.now_s);
  each_line(lines, [&](std::string_view line) {
    if (line.empty()) return;
    BoardFile file;
    std::string_view rest = line;
    if (take_number(rest, file.size) && take_number(rest, file.changed_s) && harmless(rest)) {
      file.name = rest;
      listing.files.push_back(std::move(file));
    } else {
      listing.problems.emplace_back(line);
    }
  });
  std::sort(listing.files.begin(), listing.files.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return listing;
}

FetchPlan plan_fetch(const BoardListing& listing, const std::string& into) {
  std::set<std::string> recording;
  for (const auto& file : listing.files)
    if (listing.now_s - file.changed_s < kBeingWritten_s) recording.insert(folder_of_run(file.name));
  FetchPlan plan;
  plan.recording.assign(recording.begin(), recording.end());
  for (const auto& file : listing.files) {
    const fs::path here = fs::path(into) / file.name;
    std::error_code none;
    if (recording.contains(folder_of_run(file.name))) continue;
    if (fs::exists(here, none)) {
      ++plan.here;
      if (size_of(here) != file.size) plan.different.push_back(file.name);
      continue;
    }
    const std::uint64_t part = size_of(here.string() + ".part");
    const std::uint64_t offset = part <= file.size ? part : 0;
    plan.parts.push_back({file.name, offset, file.size});
    plan.bytes += file.size - offset;
  }
  return plan;
}

std::string request_text(const FetchPlan& plan) {
  std::string text;
  for (const auto& part : plan.parts)
    text += fmt::format("{} {} {}\n", part.offset, part.size - part.offset, part.name);
  return text;
}

FetchSink::FetchSink(const FetchPlan& plan, std::string into) : plan_(plan), into_(std::move(into)) {}

std::string FetchSink::path() const { return (fs::path(into_) / plan_.parts[index_].name).string(); }

void FetchSink::begin_part() {
  const FetchPart& part = plan_.parts[index_];
  const fs::path file = path() + ".part";
  std::error_code none;
  fs::create_directories(file.parent_path(), none);
  sum_ = {};
  if (part.offset > 0) {
    std::ifstream before(file, std::ios::binary);
    std::vector<char> piece(1 << 16);
    while (before.read(piece.data(), static_cast<std::streamsize>(piece.size())), before.gcount() > 0)
      sum_.add({piece.data(), static_cast<std::size_t>(before.gcount())});
  }
  out_ = std::ofstream(file, std::ios::binary | (part.offset > 0 ? std::ios::app : std::ios::trunc));
  if (!out_) failure_ = file.string() + ": cannot be written";
  left_ = part.size - part.offset;
  begun_ = true;
}

void FetchSink::take_content(std::string_view& bytes) {
  const auto n = static_cast<std::size_t>(std::min<std::uint64_t>(left_, bytes.size()));
  const auto piece = bytes.substr(0, n);
  bytes.remove_prefix(n);
  out_.write(piece.data(), static_cast<std::streamsize>(n));
  if (!out_) failure_ = path() + ".part: cannot be written: is the disk full?";
  sum_.add(piece);
  left_ -= n, bytes_ += n;
}

void FetchSink::take_line(std::string_view& bytes) {
  const auto end = bytes.find('\n');
  line_ += bytes.substr(0, end);
  bytes.remove_prefix(end == std::string_view::npos ? bytes.size() : end + 1);
  if (end == std::string_view::npos) {
    if (synced_ && line_.size() > 200) failure_ = "the board sends what was not asked for";
    return;
  }
  if (!synced_)
    synced_ = line_ == "::sinew begin";
  else if (!line_.empty())  // an empty line ends the file's last line
    end_part();
  line_.clear();
}

void FetchSink::end_part() {
  const FetchPart& part = plan_.parts[index_];
  out_.close();
  if (out_.fail()) {
    failure_ = path() + ".part: cannot be written: is the disk full?";
    return;
  }
  std::error_code none;
  if (line_ != fmt::format("::sinew end {} {}", sum_.value(), part.size)) {
    fs::remove(path() + ".part", none);
    failure_ = part.name + ": what came is not what the board has; the next time it is fetched from its beginning";
    return;
  }
  if (fs::exists(path(), none)) {
    failure_ = path() + ": somebody has made this file meanwhile; it is left alone";
    return;
  }
  fs::rename(path() + ".part", path(), none);
  if (none) failure_ = path() + ": " + none.message();
  ++index_, ++done_;
  begun_ = false;
}

void FetchSink::take(std::string_view bytes) {
  while (failure_.empty() && index_ < plan_.parts.size()) {
    if (synced_ && !begun_) begin_part();
    if (!failure_.empty() || bytes.empty()) return;
    if (synced_ && left_ > 0)
      take_content(bytes);
    else
      take_line(bytes);
  }
}

std::string FetchSink::failure() const {
  if (!failure_.empty() || index_ == plan_.parts.size()) return failure_;
  return plan_.parts[index_].name + ": the connection ended in the middle; what came is kept, the next time goes on";
}

}  // namespace sinew::app
