#include "apps/bag/bag_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <set>

#include "apps/command/command.hpp"
#include "hal/did_you_mean.hpp"
#include "hal/linux/file.hpp"
#include "hal/linux/process.hpp"
#include "record/run/recorded_run.hpp"

namespace sinew::app {
namespace {

class WatchedFile final : public hal::InputFile {
 public:
  WatchedFile(std::unique_ptr<hal::InputFile> file, Progress& progress) : file_(std::move(file)), progress_(progress) {}
  std::uint64_t size() const noexcept override { return file_->size(); }
  hal::Status read_at(std::uint64_t offset, std::span<std::byte> into) noexcept override {
    progress_.add(into.size());
    return file_->read_at(offset, into);
  }

 private:
  std::unique_ptr<hal::InputFile> file_;
  Progress& progress_;
};

/// `s` seconds after `start` in the file's time; clamped for any number, also NaN.
std::uint64_t time_after(std::uint64_t start, double s) {
  const double ns = std::round(s * 1e9), room = static_cast<double>(~std::uint64_t{0} - start);
  if (!(ns > 0)) return start;
  return ns >= room ? ~std::uint64_t{0} : start + static_cast<std::uint64_t>(ns);
}

}  // namespace

std::string file_error(const std::string& path, const hal::Error& error) {
  const bool of_system = error.code == hal::Errc::io && error.detail != 0;
  return path + ": " + (of_system ? std::strerror(static_cast<int>(error.detail)) : hal::to_string(error.code)) +
         (error.where[0] != 0 && !of_system ? std::string(": ") + error.where : "");
}

std::unique_ptr<hal::InputFile> open_input(const std::string& path, Progress& progress, unsigned passes) {
  auto file = hal::open_file(path);
  if (!file) {
    const bool absent = file.error().code == hal::Errc::not_found;
    fail(absent ? path + ": no such file" : file_error(path, file.error()));
    return nullptr;
  }
  progress.expect(passes * (*file)->size());
  return std::make_unique<WatchedFile>(std::move(*file), progress);
}

std::unique_ptr<record::Reader> open_recording(const std::string& path, Progress& progress, unsigned passes) {
  auto file = open_input(path, progress, passes);
  if (!file) return nullptr;
  record::FileProblem why;
  auto reader = record::Reader::open(std::move(file), why);
  if (!reader) fail(path + ": " + to_string(why));
  return reader;
}

std::vector<std::string> each_file_once(const std::vector<std::string>& paths) {
  std::vector<std::string> once;
  for (const std::string& path : paths) {
    std::error_code none;  // what is not there is told by the one who opens it
    const auto same = [&](const std::string& other) { return std::filesystem::equivalent(path, other, none); };
    if (std::none_of(once.begin(), once.end(), same)) once.push_back(path);
  }
  return once;
}

std::unique_ptr<hal::OutputFile> create_output(const std::string& path) {
  auto file = hal::create_file(path);
  if (file) return std::move(*file);
  if (file.error().code == hal::Errc::busy)
    fail(path + ": exists; nothing is overwritten");
  else
    fail(file.error().code == hal::Errc::not_found ? path + ": no such folder" : file_error(path, file.error()));
  return nullptr;
}

void say_problems(const std::string& path, const std::vector<record::FileProblem>& problems) {
  constexpr std::size_t kSaid = 5;
  for (std::size_t i = 0; i < std::min(kSaid, problems.size()); ++i)
    std::fprintf(stderr, "%s: %s\n", path.c_str(), to_string(problems[i]).c_str());
  if (problems.size() > kSaid)
    std::fprintf(stderr, "%s: and %zu problems more; `bag check` lists all\n", path.c_str(), problems.size() - kSaid);
}

std::string window_problem(record::Reader& reader, std::optional<double> from_s, std::optional<double> until_s) {
  constexpr double kRounded = 0.001;  // lengths are shown with three digits
  const std::uint64_t start = record::recorded_start(reader), end = end_time(reader);
  const double length_s = end > start ? 1e-9 * static_cast<double>(end - start) : 0;
  const std::string allowed = fmt::format("the file has 0.0 to {:.3f} s", length_s);
  if (from_s && *from_s > length_s + kRounded) return fmt::format("--from {:g}: {}", *from_s, allowed);
  if (until_s && *until_s > length_s + kRounded) return fmt::format("--until {:g}: {}", *until_s, allowed);
  if (from_s && until_s && *until_s < *from_s)
    return fmt::format("--until {:g}: at least --from {:g}; {}", *until_s, *from_s, allowed);
  return {};
}

std::optional<record::Query> query_of(record::Reader& reader, const Selection& selection) {
  std::set<std::string> known;
  for (const auto& [id, channel] : reader.channels()) known.insert(channel.topic);
  for (const std::string& topic : selection.topics) {
    if (known.contains(topic)) continue;
    std::string names;
    for (const std::string& name : known) names += " " + name;
    fail("no topic " + topic + " in the file; it has" + names +
         hal::did_you_mean(topic, std::vector<std::string>(known.begin(), known.end())));
    return std::nullopt;
  }
  if (const std::string why = window_problem(reader, selection.from_s, selection.until_s); !why.empty()) {
    fail(why);
    return std::nullopt;
  }
  record::Query query{.topics = selection.topics};
  const std::uint64_t start = record::recorded_start(reader);
  if (selection.from_s) query.from = time_after(start, *selection.from_s);
  if (selection.until_s) query.until = time_after(start, *selection.until_s);
  return query;
}

bool each_message(record::Reader& reader, const record::Query& query,
                  const std::function<bool(const record::Message&)>& f) {
  auto messages = reader.messages(query);
  record::Message m;
  bool good = true;
  for (record::Next next; !hal::stop_requested() && (next = messages.next(m)) != record::Next::end;) {
    if (next == record::Next::problem) {
      std::fprintf(stderr, "%s\n", to_string(messages.problem()).c_str());
      good = false;
    } else if (!f(m)) {
      break;
    }
  }
  return good;
}

std::uint64_t end_time(const record::Reader& reader) {
  if (reader.statistics()) return reader.statistics()->end_time;
  std::uint64_t end = 0;
  for (const auto& chunk : reader.chunks()) end = std::max(end, chunk.end_time);
  return end;
}

double channel_rate_hz(record::Reader& reader, const record::Channel& channel) {
  const auto& all = reader.statistics();
  if (!all) return 0;
  const auto count = all->channel_messages.find(channel.id);
  if (count == all->channel_messages.end() || count->second < 2) return 0;
  std::uint64_t behind = 0;  // the chunk that begins last has messages of it
  for (const auto& chunk : reader.chunks())
    if (chunk.message_indexes.contains(channel.id)) behind = std::max(behind, chunk.start_time);
  std::optional<std::uint64_t> first, last;
  const auto look = [&](std::uint64_t from, bool one) {
    record::MessageReader messages = reader.messages({.topics = {channel.topic}, .from = from});
    record::Message m;
    for (record::Next next; (next = messages.next(m)) != record::Next::end;) {
      if (next == record::Next::problem || m.channel->id != channel.id) continue;
      if (!first) first = m.stamps.log_time;
      last = m.stamps.log_time;
      if (one) return;
    }
  };
  look(0, true);
  look(behind, false);
  if (!first || *last <= *first) return 0;
  return static_cast<double>(count->second - 1) / (1e-9 * static_cast<double>(*last - *first));
}

}  // namespace sinew::app
