#include "apps/sweep_runs/sweep_run.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "apps/command/command.hpp"
#include "apps/command/progress.hpp"
#include "apps/sweep/case_text.hpp"
#include "apps/sweep/statistics.hpp"
#include "apps/sweep_runs/pack.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"
#include "math/hash.hpp"

namespace sinew::app {
namespace {

constexpr std::size_t kMostTold = 20;  // recordings

hal::Duration from_seconds(double s) { return hal::Duration{static_cast<std::int64_t>(s * 1e9)}; }

/// A file that only this sweep has: the same command finds it again, another command takes another one.
std::string own_file(const SweepPlan& plan, const sweep::Identity& identity, const sweep::Shard& shard) {
  const std::uint64_t hash = math::fnv1a64(fmt::format("{} {}", identity.cases, identity.what.dump()));
  const std::string part = shard.count > 1 ? fmt::format("-{}of{}", shard.index + 1, shard.count) : "";
  return fmt::format("{}/sweeps/{}-{:08x}{}.jsonl", plan.runs_folder(), plan.robot_name(), hash >> 32, part);
}

/// Equal for runs that went equally.
std::uint64_t print_of(const sweep::CaseResult& result) {
  return math::fnv1a64(fmt::format("{} {} {}", result.code, result.outcome, result.hash));
}

std::string without_ending(const std::string& path) {
  return path.ends_with(".jsonl") ? path.substr(0, path.size() - 6) : path;
}

}  // namespace

std::vector<std::string> SweepRun::argv_of(const std::vector<std::string>& words) const {
  std::vector<std::string> argv{hal::program_path(), "run"};
  argv.insert(argv.end(), words.begin(), words.end());
  argv.insert(argv.end(), {"--virtual", "--json"});
  return argv;
}

/// Makes the folder for other machines.
int SweepRun::pack() {
  plan_ = SweepPlan::make(options_.axes, types_);
  if (!plan_) return kNotBegun;
  PackRequest request{options_.pack, plan_->options(), plan_->files()};
  if (options_.patience_s != SweepOptions{}.patience_s)
    request.words.push_back(fmt::format("--patience={}", options_.patience_s));
  Packed packed;
  std::string why;
  if (!pack_sweep(request, packed, why)) return fail(why);
  fmt::print(
      "{}: {} runs, {} files, {:.1f} MB\non each machine: {}/run --shard I/N --results FILE\nat the end: {}/run "
      "merge FILE... --into FILE\n",
      options_.pack, plan_->cases(), packed.files, static_cast<double>(packed.bytes) * 1e-6, options_.pack,
      options_.pack);
  return kDone;
}

bool SweepRun::open() {
  const auto shard = options_.shard.empty() ? sweep::Shard{} : sweep::parse_shard(options_.shard);
  if (!shard) return fail(fmt::format("--shard {}: NUMBER/COUNT, as 2/5", options_.shard)) == kDone;
  shard_ = *shard;
  plan_ = SweepPlan::make(options_.axes, types_);
  if (!plan_) return false;
  identity_ = {plan_->cases(), plan_->identity()};
  path_ = options_.results.empty() ? own_file(*plan_, identity_, shard_) : options_.results;
  std::string why;
  file_ = sweep::ResultsFile::open(path_, identity_, shard_, why);
  if (!file_) return fail(why) == kDone;
  good_.assign(static_cast<std::size_t>(identity_.cases), false);
  return read_earlier();
}

/// What is there of an earlier time.
bool SweepRun::read_earlier() {
  if (file_->count() == 0) return true;
  sweep::Identity identity;
  sweep::Shard shard;
  std::string why;
  const auto see = [&](const sweep::ResultLine& line) {
    note(line.number, sweep::case_result(line.number, line.result).good);
    return true;
  };
  if (!sweep::read_results(path_, identity, shard, see, why)) return fail(why) == kDone;
  std::fprintf(stderr, "sinew: %s has %llu of %llu runs\n", path_.c_str(),
               static_cast<unsigned long long>(file_->count()),
               static_cast<unsigned long long>(cases_of(identity_, shard_)));
  return true;
}

void SweepRun::note(std::uint64_t number, bool good) {
  good_[static_cast<std::size_t>(number)] = good;
  while (!narrow_ && prefix_ < identity_.cases && file_->has(prefix_)) {
    if (good_[static_cast<std::size_t>(prefix_)]) ++prefix_good_;
    ++prefix_;
    narrow_ = options_.until_width > 0 && sweep::wilson_95(prefix_good_, prefix_).width() <= options_.until_width;
  }
}

bool SweepRun::fly() {
  if (narrow_) return true;
  struct Flying {
    std::uint64_t number;
    std::string run;
  };
  std::map<std::uint64_t, Flying> flying;
  std::uint64_t next = shard_.index, started = 0;
  const auto give = [&]() -> std::optional<sweep::Job> {
    while (next < identity_.cases && file_->has(next)) next += shard_.count;
    if (next >= identity_.cases) return std::nullopt;
    const auto words = plan_->words(next);
    flying[started++] = {next, sweep::joined(words)};
    next += shard_.count;
    sweep::Job job{argv_of(words)};
    job.argv.emplace_back("--no-record");
    return job;
  };
  Progress progress("sweep", true, ProgressOf::cases);
  progress.expect(cases_of(identity_, shard_));
  progress.add_before(file_->count());
  std::string why;
  const auto take = [&](std::uint64_t job, const sweep::JobResult& said) {
    const auto flight = flying.extract(job).mapped();
    const RunEnd end = end_of_run(flight.run, said, options_.patience_s);
    interrupted_ = end.interrupted;
    if (end.interrupted) return false;
    if (!end.not_begun.empty()) {
      why = fmt::format("{}: {}", sweep::repeat_command(flight.run), end.not_begun);
      return false;
    }
    if (!file_->append(flight.number, sweep::to_json(end.result), why)) return false;
    ++flown_;
    note(flight.number, end.result.good);
    progress.add(1);
    return !narrow_;
  };
  const hal::Time begin = hal::system_os().now();
  {
    sweep::ProcessPool pool(options_.jobs, from_seconds(options_.patience_s));
    pool.run(give, take);
  }
  wall_s_ = msg::seconds(hal::system_os().now() - begin);
  if (hal::stop_requested()) interrupted_ = true;
  return why.empty() || fail(why) == kDone;
}

/// What a failed run has to come to again.
bool SweepRun::read_failures(std::map<std::uint64_t, std::uint64_t>& prints) const {
  sweep::Identity identity;
  sweep::Shard shard;
  std::string why;
  const auto see = [&](const sweep::ResultLine& line) {
    const sweep::CaseResult result = sweep::case_result(line.number, line.result);
    if (!result.good) prints[line.number] = print_of(result);
    return true;
  };
  return sweep::read_results(path_, identity, shard, see, why) || fail(why) == kDone;
}

bool SweepRun::record_failures() {
  std::map<std::uint64_t, std::uint64_t> prints;
  if (!read_failures(prints)) return false;
  if (prints.empty()) return true;
  const std::string folder = without_ending(path_) + "-failures";
  const auto folder_of = [&](std::uint64_t number) { return fmt::format("{}/case-{}", folder, number); };
  std::map<std::uint64_t, std::uint64_t> flying;
  auto next = prints.begin();
  std::uint64_t started = 0;
  const auto give = [&]() -> std::optional<sweep::Job> {
    if (next == prints.end()) return std::nullopt;
    const std::uint64_t number = (next++)->first;
    flying[started++] = number;
    std::error_code ignored;  // a folder that cannot be removed gets one more recording
    std::filesystem::remove_all(folder_of(number), ignored);
    sweep::Job job{argv_of(plan_->words(number))};
    job.argv.insert(job.argv.end(), {"--runs", folder_of(number)});
    return job;
  };
  ::unsetenv("SINEW_RECORD");  // what it forbids is asked for here
  Progress progress("record", true, ProgressOf::cases);
  progress.expect(prints.size());
  std::string why;
  const auto take = [&](std::uint64_t job, const sweep::JobResult& said) {
    const std::uint64_t number = flying.extract(job).mapped();
    const std::string run = sweep::joined(plan_->words(number));
    const RunEnd end = end_of_run(run, said, options_.patience_s);
    if (end.interrupted) return false;
    if (!end.not_begun.empty()) {
      why = fmt::format("{}: {}", sweep::repeat_command(run), end.not_begun);
      return false;
    }
    progress.add(1);
    const bool same = print_of(end.result) == prints.at(number);
    if (!same) failed_ = true;
    if (!same || recorded_.size() < kMostTold)
      recorded_.push_back(fmt::format("{}  {}{}", folder_of(number), end.result.outcome,
                                      same ? "" : "; NOT THE SAME as without a recording"));
    return true;
  };
  sweep::ProcessPool pool(options_.jobs, from_seconds(options_.patience_s));
  if (!pool.run(give, take, sweep::ProcessPool::Order::as_they_began) && hal::stop_requested()) interrupted_ = true;
  return why.empty() || fail(why) == kDone;
}

int SweepRun::tell() {
  Reported told;
  std::string why, remark;
  if (flown_ > 0)
    remark =
        fmt::format(", {} runs in {:.1f} s: {:.2f} a second", flown_, wall_s_, static_cast<double>(flown_) / wall_s_);
  if (!report_results(path_, options_.report, remark, told, why)) return fail(why);
  std::fwrite(told.text.data(), 1, told.text.size(), stdout);
  if (!options_.report.json && !recorded_.empty()) {
    std::string text = "recorded\n";
    for (const std::string& one : recorded_) text += "  " + one + "\n";
    std::fwrite(text.data(), 1, text.size(), stdout);
  }
  std::fflush(stdout);
  const std::uint64_t all = cases_of(identity_, shard_);
  if (interrupted_)
    std::fprintf(stderr, "sinew: interrupted after %llu of %llu runs; the same command goes on\n",
                 static_cast<unsigned long long>(told.runs), static_cast<unsigned long long>(all));
  const bool complete = narrow_ || told.runs == all;
  return complete && told.good == told.runs && !failed_ ? kDone : kFailed;
}

int SweepRun::run() {
  if (!options_.pack.empty()) return pack();
  static_cast<void>(hal::stop_requested());  // from here on a signal only asks for the end
  hal::end_at_second_signal("\nsinew: ended at once by a second signal; the same command goes on where it stopped\n");
  ::setenv("LP_NUM_THREADS", "0", 1);  // the drawing library's own threads would fight for the cores of other runs
  if (!open()) return kNotBegun;
  if (!fly()) return kNotBegun;
  std::string why;
  if (!file_->finish(narrow_ ? prefix_ : identity_.cases, why)) return fail(why);
  if (options_.record_failures && !interrupted_ && !record_failures()) return kNotBegun;
  return tell();
}

}  // namespace sinew::app
