#include "apps/search/pool.hpp"

#include <fmt/format.h>
#include <stdlib.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>

#include "apps/search/outcome_text.hpp"
#include "hal/platform.hpp"

namespace sinew::search {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

Result violated(const char* invariant, std::string what) {
  Result r;
  r.outcome.violation = Violation{invariant, {}, std::move(what)};
  return r;
}

}  // namespace

struct Pool::Job {
  ~Job() {
    child.reset();
    std::error_code ignored;  // it may never have been made
    if (!log.empty()) fs::remove(log, ignored);
  }
  std::unique_ptr<hal::ChildProcess> child;
  std::string log;
  hal::Time give_up;
  std::optional<Result> result;
};

Pool::Pool(std::vector<std::string> command, unsigned jobs, hal::Duration patience)
    : command_(std::move(command)), jobs_(jobs), patience_(patience) {
  std::string folder = (fs::temp_directory_path() / "sinew-fuzz-XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr) return;  // then they share the temporary folder with all others
  folder_ = folder;
  if (const char* before = std::getenv("TMPDIR")) tmpdir_ = before;
  setenv("TMPDIR", folder_.c_str(), 1);  // flights inherit it
}

Pool::~Pool() {
  if (folder_.empty()) return;
  if (tmpdir_)
    setenv("TMPDIR", tmpdir_->c_str(), 1);
  else
    unsetenv("TMPDIR");
  std::error_code ignored;  // nothing can be done about it here
  fs::remove_all(folder_, ignored);
}

std::unique_ptr<Pool::Job> Pool::start(const Case& c) {
  hal::Os& os = hal::system_os();
  auto job = std::make_unique<Job>();
  job->log = (fs::temp_directory_path() / fmt::format("sinew-fuzz-{}-{}.log", os.now().ns, runs_)).string();
  job->give_up = os.now() + patience_;
  std::vector<std::string> argv = command_;
  argv.insert(argv.end(), {"--case", to_string(c), "--json"});
  auto child = hal::ChildProcess::start(argv, job->log);
  ++runs_;
  if (child)
    job->child = std::move(*child);
  else
    job->result = Result{{}, fmt::format("cannot start {}: {}", argv[0], hal::to_string(child.error().code))};
  return job;
}

/// True when the job has its result.
bool Pool::collect(Job& job) {
  if (job.result) return true;
  const auto code = job.child->poll();
  if (!code && hal::system_os().now() > job.give_up) {
    job.result = violated("end", fmt::format("the process hangs: no outcome within {:.0f} s", msg::seconds(patience_)));
    job.child.reset();
    return true;
  }
  if (!code) return false;
  std::ifstream in(job.log);
  std::string line, last;
  std::optional<Outcome> outcome;
  while (std::getline(in, line)) {
    if (auto o = parse_outcome(line)) outcome = std::move(o);
    if (!line.empty()) last = line;
  }
  if (*code >= 128)
    job.result = violated("crash", fmt::format("the process died of signal {}: {}", *code - 128, last));
  else if (*code > 1 || !outcome)
    job.result = Result{{}, fmt::format("exit code {}: {}", *code, last)};
  else
    job.result = Result{std::move(*outcome), {}};
  return true;
}

bool Pool::run(const std::vector<Case>& cases, const std::function<bool(std::size_t, const Result&)>& done) {
  hal::Os& os = hal::system_os();
  std::vector<std::unique_ptr<Job>> jobs;  // from `told` on, in the order of the cases
  std::size_t told = 0, next = 0;
  while (told < cases.size()) {
    if (hal::stop_requested()) return false;
    unsigned busy = 0;
    for (auto& job : jobs) busy += !collect(*job);
    for (; busy < jobs_ && next < cases.size(); ++busy) jobs.push_back(start(cases[next++]));
    if (!jobs.front()->result) {
      os.sleep_until(os.now() + 3ms);
      continue;
    }
    const Result result = std::move(*jobs.front()->result);
    jobs.erase(jobs.begin());
    if (!done(told++, result)) return false;
  }
  return true;
}

}  // namespace sinew::search
