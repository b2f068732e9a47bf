#include "apps/run/plant_process.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "apps/command/place.hpp"
#include "hal/linux/socket.hpp"
#include "hal/platform.hpp"

namespace sinew::app {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

}  // namespace

std::unique_ptr<PlantProcess> PlantProcess::open(const PlantRequest& request, std::string& why) {
  std::unique_ptr<PlantProcess> plant(new PlantProcess());
  plant->endpoint_ = request.endpoint;
  if (request.endpoint == "auto" && !plant->start(request, why)) return nullptr;
  hal::Os& os = hal::system_os();
  const hal::Time give_up = os.now() + 20s;
  // Across a network the first packets may take their time. Between the tries, checks that a plant of our own still
  // runs.
  const hal::Duration patience = request.endpoint.starts_with("tcp:") ? 10s : 1s;
  while (true) {
    auto stream = hal::connect_stream(plant->endpoint_, patience);
    if (stream) {
      plant->stream_ = std::move(*stream);
      return plant;
    }
    if (plant->child_ && plant->child_->poll()) {
      why = plant->end();
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
  const fs::path base = fs::temp_directory_path() / fmt::format("sinew-{}-{}", hal::system_os().now().ns, request.seed);
  socket_path_ = base.string() + ".sock";
  log_path_ = base.string() + ".log";
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
                                request.lockstep ? "--lockstep" : "--free"};
  argv.insert(argv.end(), request.extra.begin(), request.extra.end());
  auto child = hal::ChildProcess::start(argv, log_path_);
  if (!child) {
    why = fmt::format("cannot start {}: {}", program, hal::to_string(child.error().code));
    return false;
  }
  child_ = std::move(*child);
  return true;
}

std::string PlantProcess::end() const {
  std::ifstream in(log_path_);
  std::string line, last = "it said nothing";
  while (std::getline(in, line))
    if (!line.empty()) last = line;
  return fmt::format("sinew-sim: {}: {}", hal::describe_exit(*child_->poll()), last);
}

std::string PlantProcess::with_its_end(std::string why) {
  // A peer often sees the connection close before the process that closed it has ended.
  if (child_ && child_->wait(500ms)) why += "; " + end();
  return why;
}

void PlantProcess::wait_for_end() {
  if (child_) child_->wait(3s);
}

void PlantProcess::leave_to_parent() {
  if (child_) child_->disown();
  socket_path_.clear();
  log_path_.clear();
}

PlantProcess::~PlantProcess() {
  child_.reset();
  std::error_code ignored;  // both may never have been made
  if (!socket_path_.empty()) fs::remove(socket_path_, ignored);
  if (!log_path_.empty()) fs::remove(log_path_, ignored);
}

}  // namespace sinew::app
