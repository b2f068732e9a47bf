#include "apps/sweep/results_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <thread>

#include "hal/linux/file.hpp"

namespace sinew::sweep {
namespace {

constexpr const char* kFormat = "sinew_sweep";
constexpr int kVersion = 1;
constexpr std::size_t kWindow = std::size_t{1} << 18;         // cases that are sorted at a time: 16 bytes each
constexpr std::size_t kBlock = std::size_t{1} << 18;          // bytes that are read or written at a time
constexpr std::size_t kMostLineBytes = std::size_t{1} << 20;  // a longer line is no result
constexpr std::size_t kMostMissing = 20;

std::string header_line(const Identity& identity, const Shard& shard) {
  Json j{{kFormat, kVersion}, {"cases", identity.cases}};
  if (shard.count > 1) j["shard"] = fmt::format("{}/{}", shard.index + 1, shard.count);
  j["what"] = identity.what;
  return app::to_line(j);
}

bool read_whole(std::string_view text, std::uint64_t& value) {
  const char* const end = text.data() + text.size();
  const auto r = std::from_chars(text.data(), end, value);
  return r.ec == std::errc() && r.ptr == end;
}

/// False: the line is no header of such a file.
bool read_header(std::string_view line, Identity& identity, Shard& shard, std::string& why) {
  const Json j = Json::parse(line, nullptr, false);
  if (!j.is_object() || !j.contains(kFormat) || !j.contains("cases") || !j.contains("what") ||
      !j["cases"].is_number_unsigned()) {
    why = "not a file of results of a sweep";
    return false;
  }
  if (j[kFormat] != kVersion) {
    why = fmt::format("results of version {}; this program reads version {}", j[kFormat].dump(), kVersion);
    return false;
  }
  identity = {j["cases"].get<std::uint64_t>(), j["what"]};
  std::optional<Shard> part = Shard{};
  if (j.contains("shard")) part = j["shard"].is_string() ? parse_shard(j["shard"].get<std::string>()) : std::nullopt;
  if (!part || identity.cases > kMostCases) {
    why = "the first line: its shard or its number of cases is no such";
    return false;
  }
  shard = *part;
  return true;
}

/// The number of the case, which every line of ours begins with; nothing: it is no such line.
std::optional<std::uint64_t> number_of(std::string_view line) {
  constexpr std::string_view kBegin = "{\"case\":";
  if (!line.starts_with(kBegin) || !line.ends_with('}')) return std::nullopt;
  const std::string_view rest = line.substr(kBegin.size());
  const auto end = rest.find_first_not_of("0123456789");
  std::uint64_t number = 0;
  if (end == std::string_view::npos || (rest[end] != ',' && rest[end] != '}') ||
      !read_whole(rest.substr(0, end), number))
    return std::nullopt;
  return number;
}

/// The lines of a file, without their ends, one in memory at a time. A line that is longer than any of ours is cut, and
/// so is no result.
class Lines {
 public:
  explicit Lines(const std::string& path) : path_(path), in_(path, std::ios::binary), block_(kBlock) {}

  /// False: there is no further line that has its end.
  bool next() {
    begin_ = end_;
    line_.clear();
    for (;;) {
      if (used_ == filled_) {
        in_.read(block_.data(), static_cast<std::streamsize>(block_.size()));
        used_ = 0, filled_ = static_cast<std::size_t>(in_.gcount());
        if (filled_ == 0) return false;
      }
      const char* const from = block_.data() + used_;
      const auto* const at = static_cast<const char*>(std::memchr(from, '\n', filled_ - used_));
      const std::size_t bytes = at ? static_cast<std::size_t>(at - from) : filled_ - used_;
      if (line_.size() < kMostLineBytes) line_.append(from, bytes);
      end_ += bytes + (at ? 1 : 0);
      used_ += bytes + (at ? 1 : 0);
      if (at) break;
    }
    ++number_;
    return true;
  }
  const std::string& line() const { return line_; }
  std::uint64_t begin() const { return begin_; }  // of the line, in the file; after the last: of what has no end
  bool begun_without_end() const { return number_ == 0 && !line_.empty(); }

  /// Reads the header. False, with `why`.
  bool header(Identity& identity, Shard& shard, std::string& why) {
    std::error_code bad;
    if (!in_ || std::filesystem::is_directory(path_, bad))
      why = fmt::format("{}: {}", path_, std::strerror(errno));
    else if (!next())
      why = path_ + ": no results of a sweep: it has no line";
    else if (read_header(line_, identity, shard, why))
      return true;
    else
      why = path_ + ": " + why;
    return false;
  }
  /// The case of this line. Nothing, with `why`: it is none, or none of this sweep.
  std::optional<std::uint64_t> number(const Identity& identity, const Shard& shard, std::string& why) const {
    const auto number = number_of(line_);
    if (number && *number < identity.cases && shard.has(*number)) return number;
    why = fmt::format("{}:{}: {}", path_, number_,
                      number ? fmt::format("case {} is none of its sweep or shard", *number) : "no result of a case");
    return std::nullopt;
  }

 private:
  std::string path_, line_;
  std::ifstream in_;
  std::vector<char> block_;
  std::size_t used_ = 0, filled_ = 0;  // of the block
  std::uint64_t begin_ = 0, end_ = 0, number_ = 0;
};

std::string words_of(const hal::Error& error) {
  return error.detail > 0 ? fmt::format("{}: {}", error.where, std::strerror(static_cast<int>(error.detail)))
                          : error.where;
}

void add_difference(const std::string& name, const Json& there, const Json& here, std::string& all) {
  if (there == here) return;
  if (there.is_object() && here.is_object()) {
    for (const auto& [key, value] : there.items())
      add_difference(name.empty() ? key : name + "." + key, value, here.contains(key) ? here[key] : Json(), all);
    for (const auto& [key, value] : here.items())
      if (!there.contains(key)) add_difference(name.empty() ? key : name + "." + key, Json(), value, all);
    return;
  }
  const auto text = [](const Json& j) {
    return j.is_null()     ? std::string("none")
           : j.is_string() ? j.get<std::string>()
                           : j.dump(-1, ' ', false, Json::error_handler_t::replace);
  };
  all += fmt::format("{}{}: {} there, {} here", all.empty() ? "" : "; ", name, text(there), text(here));
}

/// Lines written a block at a time.
class Written {
 public:
  explicit Written(hal::OutputFile& file) : file_(file) { block_.reserve(kBlock); }
  bool line(std::string_view text, std::string& why) {
    block_ += text;
    return block_.size() < kBlock || flush(why);
  }
  bool flush(std::string& why) {
    const std::span<const std::byte> part = std::as_bytes(std::span(block_));
    const auto done = file_.append({&part, 1});
    if (!done) why = words_of(done.error());
    block_.clear();
    return static_cast<bool>(done);
  }

 private:
  hal::OutputFile& file_;
  std::string block_;
};

/// Sorts the lines of files by their case, some cases at a time, so that memory does not grow with their number.
class Sorting {
 public:
  /// Of one sweep, whose shards these are.
  bool open(const std::vector<std::string>& paths, std::string& why) {
    for (const std::string& path : paths) {
      Source source{path, nullptr, {}, {}};
      if (Lines lines(path); !lines.header(source.identity, source.shard, why)) return false;
      if (!sources_.empty())
        if (const std::string differs = what_differs(sources_[0].identity, source.identity); !differs.empty()) {
          why = fmt::format("{} and {} are of different sweeps: {}", sources_[0].path, path, differs);
          return false;
        }
      auto file = hal::open_file(path);
      if (!file) {
        why = path + ": " + words_of(file.error());
        return false;
      }
      source.file = std::move(*file);
      sources_.push_back(std::move(source));
    }
    return true;
  }

  const Identity& identity() const { return sources_[0].identity; }

  /// Writes the cases below `end`; those that are missing are noted in `merged`.
  bool write(const Shard& shard, std::uint64_t end, hal::OutputFile& file, Merged& merged, std::string& why) {
    Written out(file);
    if (!out.line(header_line(identity(), shard), why)) return false;
    for (std::uint64_t from = 0; from < end; from += kWindow) {
      places_.assign(static_cast<std::size_t>(std::min<std::uint64_t>(kWindow, end - from)), {});
      for (std::uint32_t i = 0; i < sources_.size(); ++i)
        if (!find(from, i, why)) return false;
      for (std::size_t i = 0; i < places_.size(); ++i) {
        if (!shard.has(from + i)) continue;
        if (places_[i].bytes > 0) {
          if (!read(places_[i], line_, why) || !out.line(line_, why)) return false;
        } else if (++merged.missing_count <= kMostMissing) {
          merged.missing.push_back(from + i);
        }
      }
    }
    return out.flush(why);
  }

 private:
  struct Source {
    std::string path;
    std::unique_ptr<hal::InputFile> file;
    Identity identity;
    Shard shard;
  };
  struct Place {
    std::uint64_t begin = 0;
    std::uint32_t bytes = 0, source = 0;  // with the end of the line; 0: no file has the case
  };

  /// Finds the lines of the cases from `from` on in one file.
  bool find(std::uint64_t from, std::uint32_t index, std::string& why) {
    const Source& source = sources_[index];
    Lines lines(source.path);
    Identity identity;
    Shard shard;
    if (!lines.header(identity, shard, why)) return false;
    while (lines.next()) {
      const auto number = lines.number(identity, shard, why);
      if (!number) return false;
      if (*number < from || *number - from >= places_.size()) continue;
      Place& place = places_[static_cast<std::size_t>(*number - from)];
      if (place.bytes == 0) {
        place = {lines.begin(), static_cast<std::uint32_t>(lines.line().size() + 1), index};
        continue;
      }
      if (!read(place, line_, why)) return false;
      line_.pop_back();
      if (line_ != lines.line()) {
        why = fmt::format("case {} has two results, in {} and in {}: the runs do not repeat", *number,
                          sources_[place.source].path, source.path);
        return false;
      }
    }
    return true;
  }

  bool read(const Place& place, std::string& line, std::string& why) {
    line.resize(place.bytes);
    const auto done = sources_[place.source].file->read_at(place.begin, std::as_writable_bytes(std::span(line)));
    if (!done) why = sources_[place.source].path + ": " + words_of(done.error());
    return static_cast<bool>(done);
  }

  std::vector<Source> sources_;
  std::vector<Place> places_;
  std::string line_;
};

/// Writes the cases of `paths` into a new file, which then takes the place of `path`; it stays open for us alone.
std::unique_ptr<hal::OutputFile> replace(const std::vector<std::string>& paths, const std::string& path,
                                         const Shard& shard, std::uint64_t end, Merged& merged, std::string& why) {
  Sorting sorting;
  if (!sorting.open(paths, why)) return nullptr;
  merged.identity = sorting.identity();
  const std::string fresh = path + ".new";
  auto file = hal::open_to_append(fresh);
  if (!file) {
    why = fresh + ": " + words_of(file.error());
    return nullptr;
  }
  hal::Status done = (*file)->cut(0);  // one that was killed here before us
  if (!done) {
    why = fresh + ": " + words_of(done.error());
    return nullptr;
  }
  if (!sorting.write(shard, std::min(end, merged.identity.cases), **file, merged, why)) {
    std::remove(fresh.c_str());
    return nullptr;
  }
  if (done = (*file)->sync(); !done) {
    why = fresh + ": " + words_of(done.error());
    return nullptr;
  }
  if (std::rename(fresh.c_str(), path.c_str()) != 0) {
    why = fmt::format("{}: {}", path, std::strerror(errno));
    return nullptr;
  }
  return std::move(*file);
}

constexpr int kTries = 20;
constexpr std::chrono::milliseconds kBetweenTries{50};

class OpenResults final : public ResultsFile {
 public:
  OpenResults(std::string path, const Identity& identity, const Shard& shard)
      : path_(std::move(path)), identity_(identity), shard_(shard), have_(static_cast<std::size_t>(identity.cases)) {}

  bool open(std::string& why) {
    std::error_code bad;
    if (const auto folder = std::filesystem::path(path_).parent_path(); !folder.empty())
      std::filesystem::create_directories(folder, bad);
    if (bad) {
      why = fmt::format("{}: its folder cannot be made: {}", path_, bad.message());
      return false;
    }
    auto file = hal::open_to_append(path_);
    // The cases of a sweep that was just killed hold the file until they have ended, too.
    for (int tries = 0; !file && file.error().code == hal::Errc::busy && tries < kTries; ++tries) {
      std::this_thread::sleep_for(kBetweenTries);
      file = hal::open_to_append(path_);
    }
    if (!file) {
      why = file.error().code == hal::Errc::busy ? path_ + ": another program writes it now"
                                                 : path_ + ": " + words_of(file.error());
      return false;
    }
    file_ = std::move(*file);
    return read(why);
  }

  bool has(std::uint64_t number) const override { return have_[static_cast<std::size_t>(number)]; }
  std::uint64_t count() const override { return count_; }

  bool append(std::uint64_t number, const Json& result, std::string& why) override {
    Json line{{"case", number}};
    for (const auto& [key, value] : result.items())
      if (key != "case") line[key] = value;
    if (!write(app::to_line(line), why)) return false;
    note(number);
    return true;
  }

  bool finish(std::uint64_t end, std::string& why) override {
    if (sorted_ && last_ < end) return true;
    Merged ignored;
    auto file = replace({path_}, path_, shard_, end, ignored, why);
    if (!file) return false;
    file_ = std::move(file);
    have_.assign(have_.size(), false);
    sorted_ = true, last_ = 0, count_ = 0, size_ = 0;
    return read(why);
  }

 private:
  void note(std::uint64_t number) {
    sorted_ = sorted_ && (count_ == 0 || number > last_);
    last_ = std::max(last_, number);
    if (!has(number)) ++count_;
    have_[static_cast<std::size_t>(number)] = true;
  }

  bool write(const std::string& line, std::string& why) {
    const std::span<const std::byte> part = std::as_bytes(std::span(line));
    if (const auto done = file_->append({&part, 1}); !done) {
      why = path_ + ": " + words_of(done.error());
      if (!file_->cut(size_)) why += "; a part of a line stays at its end";
      return false;
    }
    size_ += line.size();
    return true;
  }

  /// What is there; a new file gets its header.
  bool read(std::string& why) {
    Lines lines(path_);
    if (!lines.next()) return begin(lines, why);
    Identity identity;
    Shard shard;
    if (!read_header(lines.line(), identity, shard, why)) {
      why = path_ + ": " + why;
      return false;
    }
    std::string differs = what_differs(identity, identity_);
    if (shard.index != shard_.index || shard.count != shard_.count)
      differs += fmt::format("{}shard: {}/{} there, {}/{} here", differs.empty() ? "" : "; ", shard.index + 1,
                             shard.count, shard_.index + 1, shard_.count);
    if (!differs.empty()) {
      why = fmt::format("{}: results of another sweep: {}; take another file, or remove this one", path_, differs);
      return false;
    }
    while (lines.next()) {
      const auto number = lines.number(identity_, shard_, why);
      if (!number) return false;
      note(*number);
    }
    return cut(lines.begin(), why);
  }

  bool begin(const Lines& lines, std::string& why) {
    const std::string header = header_line(identity_, shard_);
    if (lines.begun_without_end() && !header.starts_with(lines.line())) {
      why = path_ + ": not a file of results of a sweep";
      return false;
    }
    return cut(0, why) && write(header, why);
  }

  /// Removes what has no end of its line: its writer was killed.
  bool cut(std::uint64_t size, std::string& why) {
    size_ = size;
    const auto done = file_->cut(size);
    if (!done) why = path_ + ": " + words_of(done.error());
    return static_cast<bool>(done);
  }

  const std::string path_;
  const Identity identity_;
  const Shard shard_;
  std::unique_ptr<hal::OutputFile> file_;
  std::vector<bool> have_;
  std::uint64_t count_ = 0, size_ = 0, last_ = 0;
  bool sorted_ = true;
};

}  // namespace

std::optional<Shard> parse_shard(std::string_view text) {
  const auto slash = text.find('/');
  std::uint64_t number = 0, count = 0;
  if (slash == std::string_view::npos || !read_whole(text.substr(0, slash), number) ||
      !read_whole(text.substr(slash + 1), count) || number < 1 || number > count)
    return std::nullopt;
  return Shard{number - 1, count};
}

std::string what_differs(const Identity& there, const Identity& here) {
  std::string all;
  add_difference("cases", there.cases, here.cases, all);
  add_difference("", there.what, here.what, all);
  return all;
}

std::unique_ptr<ResultsFile> ResultsFile::open(const std::string& path, const Identity& identity, const Shard& shard,
                                               std::string& why) {
  if (identity.cases > kMostCases) {
    why = fmt::format("{} cases: a sweep has at most {}", identity.cases, kMostCases);
    return nullptr;
  }
  auto file = std::make_unique<OpenResults>(path, identity, shard);
  return file->open(why) ? std::move(file) : nullptr;
}

bool read_results(const std::string& path, Identity& identity, Shard& shard, const EachResult& each, std::string& why) {
  Lines lines(path);
  if (!lines.header(identity, shard, why)) return false;
  while (lines.next()) {
    const auto number = lines.number(identity, shard, why);
    if (!number) return false;
    const Json result = Json::parse(lines.line(), nullptr, false);
    if (!result.is_object()) {
      why = fmt::format("{}: case {}: its line is no JSON object", path, *number);
      return false;
    }
    if (!each({*number, result, lines.line(), lines.begin()})) return true;
  }
  return true;
}

bool merge_results(const std::vector<std::string>& paths, const std::string& out, Merged& merged, std::string& why) {
  merged = {};
  if (paths.empty()) {
    why = "no files to merge";
    return false;
  }
  std::vector<std::string> sources = paths;
  std::error_code none;
  if (std::filesystem::exists(out, none) && std::find(paths.begin(), paths.end(), out) == paths.end())
    sources.push_back(out);
  return replace(sources, out, Shard{}, kMostCases, merged, why) != nullptr;
}

}  // namespace sinew::sweep
