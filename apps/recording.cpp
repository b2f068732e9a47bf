#include "apps/recording.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "apps/run_setup.hpp"
#include "hal/linux/file.hpp"
#include "hal/linux/os.hpp"
#include "rt/graph_check.hpp"

namespace sinew::app {
namespace {

namespace fs = std::filesystem;

std::int64_t unix_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

void warn(const std::string& why) { std::fprintf(stderr, "warning: this run is not recorded: %s\n", why.c_str()); }

/// A new folder of its own; empty, with `why`, when there can be none.
std::string make_folder(const std::string& under, const std::string& robot, std::string& why) {
  const std::string name = fmt::format("{}-{:%Y%m%d-%H%M%S}", robot, fmt::gmtime(std::time(nullptr)));
  std::error_code error;
  fs::create_directories(under, error);
  for (int again = 1; !error && again < 1000; ++again) {
    const fs::path path = fs::path(under) / (again == 1 ? name : fmt::format("{}-{}", name, again));
    if (fs::create_directory(path, error)) return path.string();
  }
  why = under + ": " + (error ? error.message() : "no name is left");
  return {};
}

std::string part_path(const std::string& folder, unsigned part) {
  return folder + (part == 0 ? "/run.mcap" : fmt::format("/run-{}.mcap", part));
}

record::Attachment file_attachment(const std::string& path, std::int64_t at) {
  std::ifstream in(path, std::ios::binary);
  const auto time = static_cast<std::uint64_t>(at);
  return {time, time, "robot.toml", "application/toml", {std::istreambuf_iterator<char>(in), {}}};
}

std::string verdict_text(const std::vector<record::ModuleVerdict>& verdict) {
  std::string text;
  std::size_t bad = 0;
  for (const auto& v : verdict)
    if (!v.reasons.empty()) text += fmt::format("{}{}: {}", bad++ == 0 ? "" : ", ", v.module, v.reasons.front());
  return bad == 0 ? "every module can be replayed"
                  : fmt::format("{} of {} modules cannot be replayed: {}", bad, verdict.size(), text);
}

}  // namespace

std::vector<rt::Problem> check_recording(const RecordOptions& record, const rt::Graph& graph) {
  std::vector<rt::Problem> problems;
  const auto look = [&](int line, const char* key, const std::string& topic) {
    if (graph.find_topic(topic) != rt::kNone) return;
    std::vector<std::string> names;
    for (const auto& t : graph.topics()) names.push_back(t.name);
    problems.push_back({line, std::string("record.") + key, rt::quoted(topic), "a topic: " + rt::listed(names)});
  };
  for (const auto& topic : record.topics) look(topic.line, "topics", topic.value);
  for (const auto& [topic, rate] : record.rate_hz) look(rate.line, "rate_hz", topic);
  return problems;
}

bool Recording::wanted(const Prepared& prepared, const RunOptions& options) {
  const char* const said = std::getenv("SINEW_RECORD");
  return prepared.robot.record.enabled && !options.no_record && !(said && std::strcmp(said, "off") == 0);
}

std::unique_ptr<Recording> Recording::open(const Prepared& prepared, const RunOptions& options, rt::Graph& graph,
                                           const hal::Clock& clock) {
  if (!wanted(prepared, options)) return nullptr;
  const RecordOptions& from = prepared.robot.record;
  std::string why;
  const std::string folder =
      make_folder(options.record_folder.empty() ? from.folder : options.record_folder, graph.spec().robot, why);
  if (folder.empty()) return warn(why), nullptr;

  record::RecorderOptions how;
  how.files.writer.compression = from.compression;
  how.files.writer.free_floor_bytes = static_cast<std::uint64_t>(from.free_floor_mb * 1e6);
  how.files.file_bytes = static_cast<std::uint64_t>(from.split_mb * 1e6);
  how.files.file_duration = rt::Duration{static_cast<std::int64_t>(from.split_s * 1e9)};
  how.pixel_bytes_per_s = options.record_images ? 1e18 : from.pixel_mb_per_s * 1e6;
  for (const auto& topic : from.topics) how.topics.push_back(topic.value);
  for (const auto& [topic, rate] : from.rate_hz) how.rate_hz.emplace(topic, rate.value);

  record::RunDescription about;
  // Virtual time has no date, so that the same run gives the same file.
  about.unix_ns = options.virtual_time ? 0 : unix_ns() - clock.now().ns;
  about.run = {{"robot", graph.spec().robot},
               {"board", graph.spec().board},
               {"seed", std::to_string(graph.spec().seed)},
               {"virtual_time", options.virtual_time ? "true" : "false"},
               {"rate", fmt::format("{}", options.rate)},
               {"build", "sinew " SINEW_VERSION ", " __VERSION__}};
  about.attachments.push_back(file_attachment(options.robot, options.virtual_time ? 0 : unix_ns()));

  const auto open_part = [folder](unsigned part) { return hal::create_file(part_path(folder, part)); };
  auto recorder = record::RunRecorder::open(
      graph, options.virtual_time ? record::RunRecorder::Pace::waited_for : record::RunRecorder::Pace::follows,
      open_part, std::move(about), how);
  if (!recorder) {
    const hal::Error& e = recorder.error();
    return warn(fmt::format("{}: {}: {} {}", part_path(folder, 0), hal::to_string(e.code), e.where, e.detail)), nullptr;
  }
  if (!options.virtual_time)
    if (const auto started = (*recorder)->start(hal::linux_os()); !started) return warn(started.error().where), nullptr;
  return std::unique_ptr<Recording>(new Recording(folder, std::move(*recorder)));
}

void Recording::finish(RunSummary& summary) {
  const hal::Status finished = recorder_->finish();
  const auto verdict = recorder_->verdict();
  Json modules = Json::object(), messages = Json::object(), steps = Json::object();
  for (const auto& v : verdict) modules[v.module] = v.reasons;
  for (const auto& [topic, lost] : recorder_->lost_messages()) messages[topic] = lost.count;
  for (const auto& [thread, lost] : recorder_->lost_steps()) steps[thread] = lost.count;
  const std::string path = part_path(folder_, 0);
  std::uintmax_t bytes = 0;
  for (unsigned part = 0; part < recorder_->files(); ++part) {
    std::error_code error;
    const auto size = fs::file_size(part_path(folder_, part), error);
    bytes += error ? 0 : size;
  }
  const std::string files = recorder_->files() > 1 ? fmt::format(" and {} more", recorder_->files() - 1) : "";
  summary.add("recorded",
              fmt::format("{}{}, {:.1f} MB; {}", path, files, 1e-6 * static_cast<double>(bytes), verdict_text(verdict)),
              {{"recording",
                {{"path", path},
                 {"bytes", bytes},
                 {"files", recorder_->files()},
                 {"not_replayable", modules},
                 {"lost_messages", messages},
                 {"lost_steps", steps}}}});
  const hal::Status& trouble = finished ? recorder_->trouble() : finished;
  if (!trouble)
    std::fprintf(stderr, "warning: the recording has gaps: %s: %s (%lld)\n", trouble.error().where,
                 trouble.error().code == hal::Errc::io ? std::strerror(static_cast<int>(trouble.error().detail))
                                                       : hal::to_string(trouble.error().code),
                 static_cast<long long>(trouble.error().detail));
}

}  // namespace sinew::app
