#include "apps/sweep/process_pool.hpp"

#include <fmt/format.h>
#include <stdlib.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <memory>

#include "hal/linux/process.hpp"
#include "hal/platform.hpp"

namespace sinew::sweep {
namespace {

using namespace std::chrono_literals;

constexpr int kKilled = 128 + 9, kNotStarted = 127;  // the latter as a shell has it
constexpr hal::Duration kLook = 100ms;               // for a request_stop() of another thread, which wakes nobody
constexpr hal::Duration kGrace = 2s;                 // from SIGTERM to SIGKILL
constexpr hal::Duration kLongest = 24h * 365 * 100;
constexpr std::size_t kFilesOfJob = 3, kOtherFiles = 64;
void keep_last(std::string& text) {
  if (text.size() > ProcessPool::kMostOutput) text.erase(0, text.size() - ProcessPool::kMostOutput);
}

struct UnderWay {
  std::uint64_t number = 0;
  std::unique_ptr<hal::ChildProcess> child{};
  hal::Time give_up{};
  JobResult result{};
};

/// One run() of a pool.
class PoolRun {
 public:
  PoolRun(unsigned jobs, hal::Duration patience, ProcessPool::Order order, const ProcessPool::Next& next,
          const ProcessPool::Done& done)
      : jobs_(jobs), patience_(patience), order_(order), next_(next), done_(done) {}

  bool run() {
    while (!(all_given_ && under_way_.empty())) {
      if (hal::stop_requested() || !fill() || !collect()) {
        end_all();
        return false;
      }
    }
    return true;
  }

  std::uint64_t started() const { return started_; }

 private:
  /// False: stop.
  bool fill() {
    while (!all_given_ && under_way_.size() < jobs_ && waiting_.size() < ProcessPool::kMostAhead) {
      std::optional<Job> job = next_();
      all_given_ = !job.has_value();
      if (job && (!start(*job) || hal::stop_requested())) return false;
    }
    return true;
  }

  bool start(const Job& job) {
    hal::ChildOptions options;
    options.piped = true;
    options.own_group = true;
    options.killed_when_we_die = true;
    auto child =
        job.argv.empty() ? hal::ChildProcess::fork(job.body, options) : hal::ChildProcess::start(job.argv, options);
    const std::uint64_t number = started_++;
    if (!child) {
      const std::string what = job.argv.empty() ? std::string(child.error().where) : job.argv[0];
      JobResult none;
      none.code = kNotStarted;
      none.not_started = fmt::format("cannot start {}: {}", what, hal::to_string(child.error().code));
      return tell(number, std::move(none));
    }
    under_way_.push_back({number, std::move(*child), hal::system_os().now() + patience_, {}});
    return true;
  }

  /// Waits for news of the jobs under way. False: stop.
  bool collect() {
    if (under_way_.empty()) return true;
    const hal::Time now = hal::system_os().now();
    hal::Duration patience = kLook;
    for (const UnderWay& job : under_way_) patience = std::min(patience, job.give_up - now);
    look(std::max<hal::Duration>(patience, 0ns));
    if (!tell_ended()) return false;
    give_up();
    return true;
  }

  /// Reads what the jobs have written, for as long as `patience` when they write nothing and none ends.
  void look(hal::Duration patience) {
    children_.clear();
    for (const UnderWay& job : under_way_) children_.push_back(job.child.get());
    hal::ChildProcess::wait_for_any(children_, patience, ready_);
    for (const std::size_t i : ready_) read(under_way_[i], 1);
  }

  static void read(UnderWay& job, int times) {
    while (times-- > 0 && job.child->read_output(job.result.output, job.result.errors)) {
      keep_last(job.result.output);
      keep_last(job.result.errors);
    }
  }

  bool tell_ended() {
    constexpr int kFullPipe = 32;  // times 64 KiB: more than a pipe holds
    for (const std::size_t i : ready_) {
      UnderWay& job = under_way_[i];
      const auto code = job.child->poll();
      if (!code) continue;
      read(job, kFullPipe);
      job.result.code = job.result.hung ? kKilled : *code;
      const UnderWay ended = std::move(job);
      if (!tell(ended.number, ended.result)) return false;
    }
    std::erase_if(under_way_, [](const UnderWay& job) { return !job.child; });
    return true;
  }

  /// Passes a result on, in the order that was asked for. False: stop.
  bool tell(std::uint64_t number, JobResult result) {
    if (order_ == ProcessPool::Order::as_they_end) return done_(number, result);
    waiting_.emplace(number, std::move(result));
    for (auto first = waiting_.begin(); first != waiting_.end() && first->first == told_; first = waiting_.begin()) {
      const auto next = waiting_.extract(first);
      ++told_;
      if (!done_(next.key(), next.mapped())) return false;
    }
    return true;
  }

  void give_up() {
    const hal::Time now = hal::system_os().now();
    for (UnderWay& job : under_way_) {
      if (now < job.give_up) continue;
      if (job.result.hung)
        job.child->kill_now();
      else
        job.child->terminate();
      job.result.hung = true;
      job.give_up = now + kGrace;
    }
  }

  /// Ends all at the same time, so that many jobs do not take many times as long.
  void end_all() {
    std::erase_if(under_way_, [](const UnderWay& job) { return !job.child; });
    for (UnderWay& job : under_way_) job.child->terminate();
    hal::Os& os = hal::system_os();
    for (const hal::Time end = os.now() + kGrace; !under_way_.empty() && os.now() < end;) {
      look(std::min<hal::Duration>(kLook, end - os.now()));
      std::erase_if(under_way_, [](const UnderWay& job) { return job.child->poll().has_value(); });
    }
    for (UnderWay& job : under_way_) job.child->kill_now();
    under_way_.clear();
  }

  const unsigned jobs_;
  const hal::Duration patience_;
  const ProcessPool::Order order_;
  const ProcessPool::Next& next_;
  const ProcessPool::Done& done_;
  std::vector<UnderWay> under_way_{};
  std::vector<hal::ChildProcess*> children_{};    // of under_way_
  std::vector<std::size_t> ready_{};              // indices in under_way_
  std::map<std::uint64_t, JobResult> waiting_{};  // for an earlier one
  std::uint64_t started_ = 0, told_ = 0;
  bool all_given_ = false;
};

}  // namespace

std::string describe_end(const JobResult& result) {
  if (!result.not_started.empty()) return result.not_started;
  if (result.hung) return "hung";
  return (result.code > 128 ? "crashed: " : "") + hal::describe_exit(result.code);
}

ProcessPool::ProcessPool(unsigned jobs, hal::Duration patience)
    : jobs_(jobs ? jobs : hal::usable_cpus()), patience_(std::clamp<hal::Duration>(patience, 0ns, kLongest)) {
  const std::size_t files = hal::most_open_files();
  const std::size_t most = files > kOtherFiles ? (files - kOtherFiles) / kFilesOfJob : 0;
  jobs_ = static_cast<unsigned>(std::clamp<std::size_t>(most, 1, jobs_));
  auto folder = hal::TemporaryFolder::make("sinew-pool-");
  if (!folder) return;  // then they share the temporary folder with all others
  folder_ = std::move(*folder);
  if (const char* before = std::getenv("TMPDIR")) tmpdir_ = before;
  setenv("TMPDIR", folder_->path().c_str(), 1);  // jobs inherit it
}

ProcessPool::~ProcessPool() {
  if (!folder_) return;
  if (tmpdir_)
    setenv("TMPDIR", tmpdir_->c_str(), 1);
  else
    unsetenv("TMPDIR");
}

bool ProcessPool::run(const Next& next, const Done& done, Order order) {
  PoolRun run(jobs_, patience_, order, next, done);
  const bool through = run.run();
  started_ += run.started();
  return through;
}

}  // namespace sinew::sweep
