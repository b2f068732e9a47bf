#include "apps/run/recording.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "apps/command/command.hpp"
#include "apps/parent/run_folder.hpp"
#include "apps/run/run_setup.hpp"
#include "hal/linux/file.hpp"
#include "hal/platform.hpp"
#include "rt/graph_check.hpp"

namespace sinew::app {
namespace {

namespace fs = std::filesystem;
using record::RunRecorder;

constexpr std::size_t kMostAnswers = 64;  // more than the number of clients

/// Without std::chrono: on 32-bit Debian its library counts seconds only to 2038.
std::int64_t unix_ns() {
  std::timespec now{};
  std::timespec_get(&now, TIME_UTC);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

void warn(const std::string& why) { std::fprintf(stderr, "warning: this run is not recorded: %s\n", why.c_str()); }

std::string part_path(const std::string& folder, unsigned part) {
  return folder + (part == 0 ? "/run.mcap" : fmt::format("/run-{}.mcap", part));
}

std::uintmax_t bytes_of(const std::string& path, unsigned parts) {
  std::uintmax_t bytes = 0;
  for (unsigned part = 0; part < parts; ++part) {
    std::error_code error;
    const auto size = fs::file_size(part_path(fs::path(path).parent_path().string(), part), error);
    bytes += error ? 0 : size;
  }
  return bytes;
}

record::Attachment robot_attachment(const std::string& text, std::int64_t at) {
  const auto time = static_cast<std::uint64_t>(at);
  return {time, time, "robot.toml", "application/toml", text};
}

std::string verdict_text(const std::vector<record::ModuleVerdict>& verdict) {
  std::string text;
  std::size_t bad = 0;
  for (const auto& v : verdict)
    if (!v.reasons.empty()) text += fmt::format("{}{}: {}", bad++ == 0 ? "" : ", ", v.module, v.reasons.front());
  return bad == 0 ? "every module can be replayed"
                  : fmt::format("{} of {} modules cannot be replayed: {}", bad, verdict.size(), text);
}

std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

tap::RecordControl::Answer refusal(hal::Errc code, std::string why) { return {code, std::move(why)}; }

record::RecorderOptions recorder_options(const RecordOptions& from, const RunOptions& options) {
  record::RecorderOptions how;
  how.files.writer.compression = from.compression;
  how.files.writer.free_floor_bytes = static_cast<std::uint64_t>(from.free_floor_mb * 1e6);
  how.files.file_bytes = static_cast<std::uint64_t>(from.split_mb * 1e6);
  how.files.file_duration = rt::Duration{static_cast<std::int64_t>(from.split_s * 1e9)};
  how.buffer_bytes = static_cast<std::uint64_t>(from.buffer_mb * 1e6);
  how.disk_os = &hal::system_os();
  how.pixel_bytes_per_s = options.record_images ? 1e18 : from.pixel_mb_per_s * 1e6;
  for (const auto& topic : from.topics) how.topics.push_back(topic.value);
  for (const auto& thread : from.threads) how.threads.push_back(thread.value);
  for (const auto& [topic, rate] : from.rate_hz) how.rate_hz.emplace(topic, rate.value);
  how.ring.pixel_bytes_per_s = how.pixel_bytes_per_s;
  how.ring.free_floor_bytes = how.files.writer.free_floor_bytes;
  return how;
}

}  // namespace

bool Recording::wanted(const Prepared&, const RunOptions& options) {
  const char* const said = std::getenv("SINEW_RECORD");
  return !options.no_record && !(said && std::strcmp(said, "off") == 0);
}

std::string Recording::folder_of(const Prepared& prepared, const RunOptions& options) {
  return options.record_folder.empty() ? prepared.robot.record.folder : options.record_folder;
}

std::unique_ptr<Recording> Recording::open(const Prepared& prepared, const RunOptions& options, rt::Graph& graph,
                                           hal::Os& os) {
  if (!wanted(prepared, options)) return nullptr;
  const RecordOptions& from = prepared.robot.record;
  std::unique_ptr<Recording> made(new Recording(folder_of(prepared, options), graph.spec().robot));
  record::RunDescription about;
  // Virtual time has no date, so that the same run gives the same file (but for padding inside of saved states).
  about.unix_ns = options.virtual_time ? 0 : unix_ns() - os.now().ns;
  about.run = {{"robot", graph.spec().robot},
               {"board", graph.spec().board},
               {"seed", std::to_string(graph.spec().seed)},
               {"virtual_time", options.virtual_time ? "true" : "false"},
               {"rate", fmt::format("{}", options.rate)},
               {"build", "sinew " + version() + ", " __VERSION__}};
  about.more = run_metadata(prepared, options);
  made->dated_ = !options.virtual_time;
  const std::int64_t written = options.virtual_time ? 0 : unix_ns();
  about.attachments.push_back(robot_attachment(prepared.robot.text, written));
  for (const PolicyTable& p : prepared.robot.policies)  // the network that acts, whatever becomes of its file
    about.attachments.push_back({static_cast<std::uint64_t>(written), static_cast<std::uint64_t>(written),
                                 policy::attachment_name(p.options.name), "application/octet-stream", p.file->bytes});

  record::RecorderOptions how = recorder_options(from, options);
  const std::size_t least = record::FlightRing::least_bytes(graph);
  if (from.ring.enabled && from.ring.megabytes * 1e6 < static_cast<double>(least)) {
    std::fprintf(
        stderr, "warning: no flight ring: record.ring.megabytes: %g: %.1f or more for what this robot's modules save\n",
        from.ring.megabytes, 1e-6 * static_cast<double>(least) + 0.05);
  } else if (from.ring.enabled) {
    auto memory = hal::system_os().shared_memory("sinew-ring", static_cast<std::size_t>(from.ring.megabytes * 1e6));
    if (!memory) std::fprintf(stderr, "warning: no flight ring: %s\n", error_text(memory.error()).c_str());
    if (memory) made->ring_memory_ = std::move(*memory);
  }
  if (made->ring_memory_) {
    how.ring.length = rt::Duration{static_cast<std::int64_t>(from.ring.seconds * 1e9)};
    how.ring.memory = {made->ring_memory_->data(), made->ring_memory_->size()};
    how.ring.next_file = [recording = made.get()] { return recording->next_dump(); };
  }
  auto recorder =
      RunRecorder::open(graph, options.virtual_time ? RunRecorder::Pace::waited_for : RunRecorder::Pace::follows, {},
                        std::move(about), how);
  if (!recorder) {
    warn(error_text(recorder.error()));
    return nullptr;
  }
  made->recorder_ = std::move(*recorder);
  if (from.enabled)
    if (const std::string why = made->begin_file(); !why.empty()) warn(why);
  if (!options.virtual_time)
    if (const auto started = made->recorder_->start(os); !started) {
      warn(started.error().where);
      return nullptr;
    }
  return made;
}

Recording::~Recording() {
  if (finished_ || !recorder_ || path_.empty()) return;
  static_cast<void>(recorder_->finish(end_with({.end = RunResult::kEndFailed})));
  if (recorder_->now() != rt::Time{}) return;
  std::error_code none;  // a file that cannot be removed stays, complete
  fs::remove(path_, none);
  remove_run_folder(folder_);
}

// ---- files and folders

std::string Recording::begin_file() {
  std::string why;
  const std::string folder = make_run_folder(under_, robot_, why);
  if (folder.empty()) return why;
  const auto begun =
      recorder_->begin_file([folder](unsigned part) { return hal::create_file(part_path(folder, part)); });
  if (!begun) return part_path(folder, 0) + ": " + error_text(begun.error());
  path_ = part_path(folder, 0);
  const std::lock_guard lock(folder_mutex_);
  folder_ = folder;
  recording_ = path_;
  if (ring_memory_)
    if (auto ring = record::RingMemory::open({ring_memory_->data(), ring_memory_->size()})) ring->set_folder(folder);
  return {};
}

record::RunEnd Recording::end_with(const RunResult& result, const std::string& report) const {
  return end_of_run(result, report, dated_ ? static_cast<std::uint64_t>(unix_ns()) : 0);
}

/// While the run goes on.
Recording::File Recording::end_file() {
  const hal::Status finished = recorder_->end_file(end_with({.end = RunResult::kEndRecordingStopped}));
  {
    const std::lock_guard lock(folder_mutex_);
    recording_.clear();
  }
  const record::RunSink& file = *recorder_->file();
  files_.push_back({path_, file.files(), file.verdict(), file.lost_messages(), file.lost_steps(),
                    finished ? file.trouble() : finished});
  return files_.back();
}

record::DumpFile Recording::next_dump() {
  const std::lock_guard lock(folder_mutex_);
  if (folder_.empty()) {
    std::string why;
    const std::string made = make_run_folder(under_, robot_, why);
    if (made.empty()) {
      const auto none = [] { return hal::Error{hal::Errc::denied, "no folder can be made there"}; };
      return {why, [none]() -> hal::Result<std::unique_ptr<hal::OutputFile>> { return none(); },
              [none]() -> hal::Result<std::unique_ptr<hal::InputFile>> { return none(); }};
    }
    folder_ = made;
    if (auto ring = record::RingMemory::open({ring_memory_->data(), ring_memory_->size()})) ring->set_folder(folder_);
  }
  return next_ring_file(folder_);
}

// ---- record control

std::uint64_t Recording::ask(Command command) {
  const std::uint64_t number = ++asked_;
  if (command == Command::status) {  // at once: the recorder may be busy for long, and then this is of interest
    const std::lock_guard lock(answers_mutex_);
    answers_[number] = {{}, text_of(status())};
    if (answers_.size() > kMostAnswers) answers_.erase(answers_.begin());  // of clients that went away
    return number;
  }
  if (recorder_->later([this, command, number] { serve(command, number); })) return number;
  const std::lock_guard lock(answers_mutex_);
  answers_[number] = refusal(hal::Errc::closed, "the run is over");
  return number;
}

std::optional<tap::RecordControl::Answer> Recording::answer(std::uint64_t number) {
  const std::lock_guard lock(answers_mutex_);
  if (const auto dump = dumping_.find(number); dump != dumping_.end()) {
    const record::RingDumpReport report = recorder_->ring()->reports()[dump->second];
    if (!report.done) return std::nullopt;
    dumping_.erase(dump);
    if (!report.status)
      return refusal(report.status.error().code, report.path + ": " + error_text(report.status.error()));
    return Answer{{}, text_of({{"path", report.path}, {"bytes", report.dumped.bytes}})};
  }
  const auto found = answers_.find(number);
  if (found == answers_.end()) return std::nullopt;
  Answer answer = std::move(found->second);
  answers_.erase(found);
  return answer;
}

/// On the recorder's thread.
void Recording::serve(Command command, std::uint64_t number) {
  Answer answer;
  if (command == Command::snapshot) {
    if (const auto report = recorder_->snapshot("asked for")) {
      const std::lock_guard lock(answers_mutex_);
      dumping_[number] = *report;
      return;
    }
    answer = recorder_->ring() ? refusal(hal::Errc::busy, "the ring is being dumped already")
                               : refusal(hal::Errc::not_supported, "this robot has no flight ring: [record.ring]");
  } else {
    answer = command == Command::start ? start() : stop();
  }
  const std::lock_guard lock(answers_mutex_);
  answers_[number] = std::move(answer);
  if (answers_.size() > kMostAnswers) answers_.erase(answers_.begin());  // of clients that went away
}

tap::RecordControl::Answer Recording::start() {
  if (recorder_->has_file()) return refusal(hal::Errc::busy, "it is being recorded already: " + path_);
  if (const std::string why = begin_file(); !why.empty()) return refusal(hal::Errc::io, why);
  return {{}, text_of({{"path", path_}})};
}

tap::RecordControl::Answer Recording::stop() {
  if (!recorder_->has_file()) return refusal(hal::Errc::not_found, "nothing is being recorded");
  const File file = end_file();
  if (!file.trouble) return refusal(file.trouble.error().code, file.path + ": " + error_text(file.trouble.error()));
  return {{}, text_of(to_json(file))};
}

Json Recording::to_json(const File& file) {
  Json modules = Json::object(), messages = Json::object(), steps = Json::object();
  for (const auto& v : file.verdict) modules[v.module] = v.reasons;
  for (const auto& [topic, lost] : file.messages) messages[topic] = lost.count;
  for (const auto& [thread, lost] : file.steps) steps[thread] = lost.count;
  return {{"path", file.path},         {"bytes", bytes_of(file.path, file.parts)},
          {"files", file.parts},       {"not_replayable", modules},
          {"lost_messages", messages}, {"lost_steps", steps}};
}

Json Recording::dumps() const {
  Json all = Json::array();
  for (const auto& r : recorder_->ring()->reports()) {
    Json dump{{"reason", r.reason}, {"at_s", msg::seconds(r.at)}, {"path", r.path}, {"bytes", r.dumped.bytes}};
    if (!r.done) dump["done"] = false;
    if (!r.status) dump["error"] = error_text(r.status.error());
    all.push_back(std::move(dump));
  }
  return all;
}

Json Recording::status() const {
  Json all{{"recording", nullptr}, {"ring", nullptr}};
  const record::RecorderProgress so_far = recorder_->progress();
  std::string path;
  {
    const std::lock_guard lock(folder_mutex_);
    path = recording_;
  }
  if (so_far.file && !path.empty()) {
    const auto& file = *so_far.file;
    all["recording"] = {{"path", path},
                        {"bytes", bytes_of(path, file.files)},
                        {"files", file.files},
                        {"seconds", msg::seconds(so_far.now - file.began)},
                        {"lost_messages", file.lost_messages},
                        {"lost_steps", file.lost_steps}};
  }
  if (so_far.ring) {
    const record::FlightRing& ring = *recorder_->ring();
    all["ring"] = {{"seconds", msg::seconds(so_far.ring->held)},
                   {"bytes", so_far.ring->bytes_used},
                   {"room_bytes", ring.bytes()},
                   {"dumps", dumps()},
                   {"not_dumped", ring.not_dumped()}};
    if (!so_far.ring->trouble) all["ring"]["error"] = error_text(so_far.ring->trouble.error());
  }
  return all;
}

// ---- the end

void Recording::finish(RunSummary& summary, const RunResult& result, const std::string& report) {
  finished_ = true;
  const hal::Status finished = recorder_->finish(end_with(result, report));  // it answers requests to the end
  if (!path_.empty() && (files_.empty() || files_.back().path != path_)) {
    const record::RunSink& file = *recorder_->file();
    files_.push_back({path_, file.files(), file.verdict(), file.lost_messages(), file.lost_steps(),
                      finished ? file.trouble() : finished});
  }
  Json all = Json::array();
  for (const File& file : files_) {
    const std::string more = file.parts > 1 ? fmt::format(" and {} more", file.parts - 1) : "";
    Json json = to_json(file);
    all.push_back(json);
    const std::string size = fmt::format("{:.1f} MB", 1e-6 * json["bytes"].get<double>());
    const std::string verdict = verdict_text(file.verdict);
    summary.add("recorded", fmt::format("{}{}, {}; {}", file.path, more, size, verdict), {{"recording", json}});
    summary.recorded(file.path, size + "; " + verdict.substr(0, verdict.find(':')));  // without the reasons
    if (!file.trouble)
      std::fprintf(stderr, "warning: the recording has gaps: %s: %s\n", file.path.c_str(),
                   error_text(file.trouble.error()).c_str());
  }
  if (files_.size() > 1) summary.keep({{"recordings", all}});
  if (recorder_->ring()) tell_ring(summary);
}

void Recording::tell_ring(RunSummary& summary) const {
  const std::uint64_t not_dumped = recorder_->ring()->not_dumped();
  for (const auto& r : recorder_->ring()->reports())
    summary.add("ring dumped",
                fmt::format("{}: {} at {:.3f} s{}", r.path, r.reason, msg::seconds(r.at),
                            r.status ? "" : ": " + error_text(r.status.error())),
                Json::object());
  if (not_dumped != 0)
    summary.add("not dumped", fmt::format("{} that happened within the ring's length of another", not_dumped),
                Json::object());
  if (!recorder_->ring()->trouble())
    std::fprintf(stderr, "warning: the flight ring has gaps: %s\n",
                 error_text(recorder_->ring()->trouble().error()).c_str());
  summary.keep({{"ring", {{"dumps", dumps()}, {"not_dumped", not_dumped}}}});
}

}  // namespace sinew::app
