#include "apps/run/plant_process.hpp"

#include <fmt/format.h>

#include <atomic>
#include <charconv>
#include <filesystem>

#include "apps/command/place.hpp"
#include "hal/linux/run_dir.hpp"
#include "hal/linux/socket.hpp"
#include "hal/platform.hpp"

namespace sinew::app {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr std::string_view kFileBegin = "sinew-plant-";  // then the process that starts the plant
constexpr std::string_view kReportBegin = "{";           // of the line with the plant's last report in its log

/// That process, of a file of a plant; 0: it is no such file.
int starter_of(const fs::path& file) {
  const std::string name = file.filename().string();
  if (!name.starts_with(kFileBegin) || (file.extension() != ".sock" && file.extension() != ".log")) return 0;
  int pid = 0;
  const auto read = std::from_chars(name.data() + kFileBegin.size(), name.data() + name.size(), pid);
  return read.ec == std::errc() && *read.ptr == '-' ? pid : 0;
}

/// A run that was killed while its plant started left the plant's files: nobody had the time to remove them.
void remove_files_of_killed_runs(const fs::path& folder) {
  std::error_code ignored;  // what cannot be removed is another user's
  std::vector<fs::path> left;
  for (fs::directory_iterator file(folder, ignored), end; !ignored && file != end; file.increment(ignored))
    if (const int pid = starter_of(file->path()); pid != 0 && !hal::process_exists(pid)) left.push_back(file->path());
  for (const fs::path& file : left)  // a listening plant belongs to a container with process numbers of its own
    if (file.extension() != ".sock" || !hal::connect_stream("unix:" + file.string(), 1ms)) fs::remove(file, ignored);
}

}  // namespace

std::string to_string(const PlantExit& exit) {
  if (exit.code > 128) return fmt::format("died (signal {})", exit.code - 128);
  return fmt::format("ended (exit code {})", exit.code);
}

std::unique_ptr<PlantProcess> PlantProcess::open(const PlantRequest& request, std::string& why) {
  std::unique_ptr<PlantProcess> plant(new PlantProcess());
  plant->endpoint_ = request.endpoint;
  if (request.endpoint == "auto" && !plant->start(request, why)) return nullptr;
  hal::Os& os = hal::system_os();
  const hal::Time give_up = os.now() + 20s;
  // Across a network the first packets may take their time. Between the tries, checks that a plant of our own still
  // runs.
  hal::Duration patience = request.endpoint.starts_with("tcp:") ? 10s : 1s;
  if (plant->own()) patience = 100ms;
  while (true) {
    auto stream = hal::connect_stream_until(plant->endpoint_, patience, [] { return hal::stop_requested(); });
    if (stream) {
      plant->stream_ = std::move(*stream);
      return plant;
    }
    if (hal::stop_requested()) {
      why = plant->own() ? "interrupted while the simulator started"
                         : fmt::format("interrupted while connecting to {}", plant->endpoint_);
      return nullptr;
    }
    if (plant->ended(0s)) {
      why = plant->with_its_end({});
      return nullptr;
    }
    if (!plant->child_ || os.now() > give_up) {
      why = fmt::format("no plant at {}: {}", plant->endpoint_, hal::to_string(stream.error().code));
      return nullptr;
    }
    os.sleep_until(os.now() + 5ms);
  }
}

bool PlantProcess::start(const PlantRequest& request, std::string& why) {
  const std::string program = find_program("sinew-sim");
  if (program.empty()) {
    why =
        "sinew-sim is neither beside this program nor in PATH; Debian package sinew-sim has it, and the build has it "
        "where MuJoCo is installed (Debian: libmujoco-dev)";
    return false;
  }
  const fs::path folder = fs::temp_directory_path();
  remove_files_of_killed_runs(folder);
  const fs::path base =
      folder / fmt::format("{}{}-{}-{}", kFileBegin, hal::process_id(), hal::system_os().now().ns, request.seed);
  socket_path_ = base.string() + ".sock";
  const std::string log_path = base.string() + ".log";
  endpoint_ = "unix:" + socket_path_;
  std::vector<std::string> argv{program,
                                "--listen",
                                endpoint_,
                                "--world",
                                request.world,
                                "--seed",
                                std::to_string(request.seed),
                                "--camera",
                                fmt::format("{}x{}", request.camera_width, request.camera_height),
                                request.lockstep ? "--lockstep" : "--free",
                                "--report=-"};
  argv.insert(argv.end(), request.extra.begin(), request.extra.end());
  if (auto memory = hal::system_os().shared_memory("sinew_plant_state", sizeof(int))) {
    state_ = std::move(*memory);
    *reinterpret_cast<int*>(state_->data()) = kRuns;
  }
  // It has no terminal of its own to hear a Ctrl-C from: the run ends it.
  hal::ChildOptions child_options;
  child_options.log_path = log_path;
  child_options.hears_terminal = false;
  child_options.killed_when_we_die = true;
  auto child = hal::ChildProcess::start(argv, child_options);
  log_.open(log_path);
  std::error_code ignored;  // it may never have been made
  fs::remove(log_path, ignored);
  if (!child) {
    why = fmt::format("cannot start {}: {}", program, hal::to_string(child.error().code));
    return false;
  }
  child_ = std::move(*child);
  own_ = true;
  return true;
}

int PlantProcess::state() const {
  if (!state_) return own_state_;
  return std::atomic_ref<int>(*reinterpret_cast<int*>(state_->data())).load(std::memory_order_acquire);
}

void PlantProcess::look() {
  if (!child_) return;
  const auto code = child_->poll();
  const int now = code.value_or(child_->is_stopped() ? kStopped : kRuns);
  own_state_ = now;
  if (state_) std::atomic_ref<int>(*reinterpret_cast<int*>(state_->data())).store(now, std::memory_order_release);
}

std::optional<PlantExit> PlantProcess::ended(hal::Duration patience) {
  if (!own_) return std::nullopt;
  hal::Os& os = hal::system_os();
  const hal::Time give_up = os.now() + patience;
  for (look(); state() < 0 && os.now() < give_up; look()) os.sleep_until(os.now() + 2ms);
  if (state() < 0) return std::nullopt;
  return PlantExit{state(), last_words()};
}

std::string PlantProcess::last_words() {
  constexpr std::string_view kOwn = "sinew-sim: ", kGreeting = "listening on ";
  log_.clear();
  log_.seekg(0);
  std::string line, last;
  while (std::getline(log_, line))
    if (!line.empty() && !line.starts_with(kGreeting) && !line.starts_with(kReportBegin))
      last = line.starts_with(kOwn) ? line.substr(kOwn.size()) : line;
  return last;
}

std::string PlantProcess::last_report() {
  if (!child_ || state() < 0) return {};
  log_.clear();
  log_.seekg(0);
  std::string line, last;
  while (std::getline(log_, line))
    if (line.starts_with(kReportBegin)) last = line;
  return last;
}

std::string PlantProcess::with_its_end(std::string why) {
  // A peer often sees the connection close before the process that closed it has ended.
  if (const auto exit = ended(500ms)) {
    const std::string how = "sinew-sim: " + hal::describe_exit(exit->code) + ": ";
    why += (why.empty() ? "" : "; ") + how + (exit->words.empty() ? "it said nothing" : exit->words);
  }
  return why;
}

std::string PlantProcess::wait_for_end(hal::Duration patience) {
  if (!child_) return {};
  hal::Os& os = hal::system_os();
  const hal::Time give_up = os.now() + patience;
  for (look(); state() == kRuns && os.now() < give_up; look()) os.sleep_until(os.now() + 2ms);
  if (state() >= 0) return {};
  std::string why = state() == kStopped ? "the simulator is stopped, and was killed"
                                        : fmt::format("the simulator did not end within {:g} s, and was killed",
                                                      msg::seconds(patience));
  kill_now();
  return why;
}

void PlantProcess::kill_now() {
  if (!child_) return;
  child_->kill_now();
  child_->wait(1s);
  look();
}

void PlantProcess::hide() {
  std::error_code ignored;  // it may never have been made
  if (!socket_path_.empty()) fs::remove(socket_path_, ignored);
  socket_path_.clear();
}

void PlantProcess::leave_to_parent() {
  if (child_) child_->disown();
  child_.reset();
  socket_path_.clear();
}

PlantProcess::~PlantProcess() {
  kill_now();
  hide();
}

}  // namespace sinew::app
