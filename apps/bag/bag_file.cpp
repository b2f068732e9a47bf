#include "apps/bag/bag_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <set>

#include "apps/command/command.hpp"
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

std::optional<record::Query> query_of(record::Reader& reader, const Selection& selection) {
  std::set<std::string> known;
  for (const auto& [id, channel] : reader.channels()) known.insert(channel.topic);
  for (const std::string& topic : selection.topics) {
    if (known.contains(topic)) continue;
    std::string names;
    for (const std::string& name : known) names += " " + name;
    fail("no topic " + topic + " in the file; it has" + names);
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

}  // namespace sinew::app
