#include "apps/team/team_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>

#include "apps/command/command.hpp"
#include "apps/run/plant_process.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;

/// One robot's `sinew run`.
/// Thread:  owner.
class MemberRun {
 public:
  MemberRun(std::string name, std::size_t name_width, bool prints)
      : name_(std::move(name)), head_(fmt::format("{:<{}} | ", name_, name_width)), prints_(prints) {}

  /// False, after saying why: it could not be started.
  bool start(const std::vector<std::string>& argv) {
    hal::ChildOptions how;
    how.piped = true;
    how.hears_terminal = false;
    auto child = hal::ChildProcess::start(argv, how);
    if (!child) {
      fail(fmt::format("{}: cannot start {}: {}", name_, argv[0], hal::to_string(child.error().code)));
      return false;
    }
    child_ = std::move(*child);
    return true;
  }
  /// Passes on what it has written.
  void look() {
    if (!code_) code_ = child_->poll();
    while (child_->read_output(output_, errors_)) {
    }
    print_lines(output_, stdout, code_.has_value());
    print_lines(errors_, stderr, code_.has_value());
  }

  const std::string& name() const { return name_; }
  hal::ChildProcess* child() { return child_.get(); }
  const std::optional<int>& code() const { return code_; }
  /// Its JSON object, of a run with --json.
  Json summary() const {
    Json said = Json::parse(output_, nullptr, false);
    return said.is_object() ? said : Json();
  }

 private:
  /// Whole lines, and at the end the rest.
  void print_lines(std::string& text, std::FILE* to, bool all) const {
    if (to == stdout && !prints_) return;
    for (auto end = text.find('\n'); !text.empty(); end = text.find('\n')) {
      if (end == std::string::npos && !all) return;
      const std::string line = text.substr(0, end);
      text.erase(0, end == std::string::npos ? end : end + 1);
      std::fprintf(to, "%s%s\n", head_.c_str(), line.c_str());
    }
    std::fflush(to);
  }

  std::string name_, head_;
  bool prints_;
  std::unique_ptr<hal::ChildProcess> child_;
  std::optional<int> code_;
  std::string output_, errors_;
};

bool all_ended(const std::vector<std::unique_ptr<MemberRun>>& runs) {
  return std::ranges::all_of(runs, [](const auto& run) { return run->code().has_value(); });
}

/// Runs them to their end. When the run is interrupted, or one of them could not begin, the others are asked to end.
void watch(std::vector<std::unique_ptr<MemberRun>>& runs) {
  bool asked = false;
  std::vector<std::size_t> ready;
  while (!all_ended(runs)) {
    std::vector<hal::ChildProcess*> running;
    for (const auto& run : runs)
      if (!run->code()) running.push_back(run->child());
    hal::ChildProcess::wait_for_any(running, 200ms, ready);
    for (const auto& run : runs) run->look();
    const auto not_begun = std::ranges::find_if(runs, [](const auto& run) { return run->code() == kNotBegun; });
    if (asked || (not_begun == runs.end() && !hal::stop_requested())) continue;
    asked = true;
    if (not_begun != runs.end() && !all_ended(runs))
      std::fprintf(stderr, "sinew: %s could not begin, so the team does not\n", (*not_begun)->name().c_str());
    for (const auto& run : runs)
      if (!run->code()) run->child()->terminate();
  }
}

}  // namespace

TeamEnd run_members(const TeamSetup& setup, const TeamRunOptions& options) {
  std::string why;
  const auto plant = PlantProcess::open(setup.plant, why);
  TeamEnd end;
  if (!plant) {
    end.code = fail(why, hal::stop_requested() ? kFailed : kNotBegun);
    return end;
  }
  plant->take_stream().reset();  // it was only to see that the plant is there
  std::size_t width = 0;
  for (const TeamMember& m : setup.members) width = std::max(width, m.name.size());
  std::vector<std::unique_ptr<MemberRun>> runs;
  for (const TeamMember& m : setup.members) {
    std::vector<std::string> argv{hal::program_path()};
    argv.insert(argv.end(), m.arguments.begin(), m.arguments.end());
    argv.insert(argv.end(), {"--plant", plant->endpoint()});
    runs.push_back(std::make_unique<MemberRun>(m.name, width, !options.json));
    if (!runs.back()->start(argv)) {
      end.code = kNotBegun;
      return end;  // the others end with this process's objects
    }
  }
  watch(runs);
  why = plant->wait_for_end(hal::stop_requested() ? 1s : 3s);
  if (const auto exit = plant->ended(0s); why.empty() && exit && exit->code > 128)
    why = "the simulator " + to_string(*exit);
  if (!why.empty() && !hal::stop_requested()) std::fprintf(stderr, "sinew: %s\n", why.c_str());
  for (const auto& run : runs) {
    const int code = *run->code();
    end.members.push_back({run->name(), code, run->summary()});
    end.code = std::max(end.code, code == kNotBegun ? kNotBegun : std::min(code, kFailed));
  }
  end.plant = Json::parse(plant->last_report(), nullptr, false);
  if (!end.plant.is_object()) end.plant = Json();
  return end;
}

}  // namespace sinew::app
