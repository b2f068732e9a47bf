#include "apps/match/match_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>

#include "apps/command/place.hpp"
#include "apps/command/progress.hpp"
#include "apps/match/match_result.hpp"
#include "apps/robot_file/robot_file.hpp"
#include "apps/sweep/case_text.hpp"
#include "apps/sweep/process_pool.hpp"
#include "apps/sweep/results_file.hpp"
#include "apps/sweep/statistics.hpp"
#include "apps/sweep/summary.hpp"
#include "hal/linux/file.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"
#include "math/hash.hpp"
#include "math/random.hpp"

namespace sinew::app {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kResamples = 10000;

double measure(const sweep::CaseResult& r, std::string_view name) {
  const auto it = std::ranges::find(r.measures, name, &sweep::MeasuredValue::name);
  return it == r.measures.end() ? 0 : it->value;
}

MatchStatistics::Estimate bootstrap(const std::vector<double>& values) {
  MatchStatistics::Estimate e;
  if (values.empty()) return e;
  for (const double v : values) e.mean += v / static_cast<double>(values.size());
  math::Random random(values.size(), 0x6d617463);
  std::vector<double> means(kResamples);
  for (double& mean : means) {
    for (std::size_t i = 0; i < values.size(); ++i)
      mean += values[std::min(values.size() - 1,
                              static_cast<std::size_t>(random.uniform(0, static_cast<double>(values.size()))))];
    mean /= static_cast<double>(values.size());
  }
  std::ranges::sort(means);
  e.low = means[kResamples * 25 / 1000];
  e.high = means[kResamples * 975 / 1000 - 1];
  return e;
}

std::string last_line(const std::string& text) {
  const auto end = text.find_last_not_of(" \n");
  if (end == std::string::npos) return {};
  const auto begin = text.find_last_of('\n', end);
  return text.substr(begin == std::string::npos ? 0 : begin + 1,
                     end - (begin == std::string::npos ? 0 : begin + 1) + 1);
}

/// Of a file's content. Empty: it cannot be read.
std::string hash_of_file(const std::string& path) {
  auto file = hal::open_file(path);
  if (!file) return {};
  std::vector<std::byte> bytes(static_cast<std::size_t>((*file)->size()));
  if (!(*file)->read_at(0, bytes)) return {};
  return fmt::format("{:016x}", math::hash64(bytes.data(), bytes.size()));
}

class MatchStudy {
 public:
  explicit MatchStudy(const MatchOptions& options) : o_(options) {}

  int run() {
    static_cast<void>(hal::stop_requested());  // from here on a signal only asks for the end
    hal::end_at_second_signal("\nsinew: ended at once by a second signal; the same command goes on where it stopped\n");
    std::string why;
    if (!open(why)) return fail(why);
    if (!play(why)) return fail(why);
    if (!file_->finish(o_.count, why)) return fail(why);
    return tell();
  }

 private:
  bool open(std::string& why) {
    const auto shard = o_.shard.empty() ? sweep::Shard{} : sweep::parse_shard(o_.shard).value_or(sweep::Shard{0, 0});
    if (shard.count == 0) return why = fmt::format("--shard {}: NUMBER/COUNT, as 2/5", o_.shard), false;
    shard_ = shard;
    Json what{{"study", "match"}, {"words", words_of(o_, false)}, {"first_seed", o_.seed}};
    for (unsigned t = 0; t < 2; ++t) {
      LoadedRobot loaded = load_robot(o_.teams[t]);
      for (const auto& p : loaded.problems) std::fprintf(stderr, "%s\n", to_string(p, loaded.robot).c_str());
      if (!loaded.problems.empty()) return why = o_.teams[t] + ": not a robot file that can be played", false;
      if (why = why_no_player(loaded.robot); !why.empty()) return why = o_.teams[t] + ": " + why, false;
      math::Hash64 hash;
      hash.add(loaded.robot.text.data(), loaded.robot.text.size());
      for (const PolicyTable& p : loaded.robot.policies) hash.add(p.file->bytes.data(), p.file->bytes.size());
      what[t == 0 ? "a" : "b"] = fmt::format("{:016x}", hash.value());
    }
    what["program"] = hash_of_file(hal::program_path());
    what["sinew-sim"] = hash_of_file(find_program("sinew-sim"));
    identity_ = {o_.count, what};
    const std::string part = shard_.count > 1 ? fmt::format("-{}of{}", shard_.index + 1, shard_.count) : "";
    path_ = o_.results.empty() ? fmt::format("{}/{}-{}-{:08x}{}.jsonl", folder(), team_name(o_, 0), team_name(o_, 1),
                                             math::fnv1a64(fmt::format("{} {}", o_.count, what.dump())) >> 32, part)
                               : o_.results;
    std::error_code ignored;  // opening the file tells
    if (const auto parent = fs::path(path_).parent_path(); !parent.empty()) fs::create_directories(parent, ignored);
    file_ = sweep::ResultsFile::open(path_, identity_, shard_, why);
    if (file_ && file_->count() > 0)
      std::fprintf(stderr, "sinew: %s has %llu matches\n", path_.c_str(),
                   static_cast<unsigned long long>(file_->count()));
    return static_cast<bool>(file_);
  }

  std::string folder() const { return o_.out.empty() ? "matches" : o_.out; }

  std::vector<std::string> words(std::uint64_t number) const {
    MatchOptions one = o_;
    one.seed += number;
    return words_of(one);
  }
  std::string folder_of(std::uint64_t number) const {
    return fmt::format("{}/{}-{}-{}", folder(), team_name(o_, 0), team_name(o_, 1), o_.seed + number);
  }

  bool play(std::string& why) {
    std::map<std::uint64_t, std::uint64_t> under_way;
    std::uint64_t next = shard_.index, started = 0;
    const auto give = [&]() -> std::optional<sweep::Job> {
      while (next < o_.count && file_->has(next)) next += shard_.count;
      if (next >= o_.count) return std::nullopt;
      const std::uint64_t number = under_way[started++] = next;
      next += shard_.count;
      sweep::Job job{{hal::program_path(), "match"}};
      const auto own = words(number);
      job.argv.insert(job.argv.end(), own.begin(), own.end());
      job.argv.emplace_back("--json");
      if (o_.no_record) job.argv.emplace_back("--no-record");
      if (o_.record_all) job.argv.emplace_back("--record-all");
      if (o_.no_goal_pictures) job.argv.emplace_back("--no-goal-pictures");
      if (!o_.no_record) {
        std::error_code ignored;  // of a match that has no result in the file; playing says what cannot be written
        fs::remove(fs::path(folder_of(number)) / "result.json", ignored);
        job.argv.insert(job.argv.end(), {"--out", folder_of(number)});
      }
      return job;
    };
    Progress progress("match", true, ProgressOf::cases);
    progress.expect(o_.count / shard_.count + (shard_.index < o_.count % shard_.count ? 1 : 0));
    progress.add_before(file_->count());
    const auto take = [&](std::uint64_t job, const sweep::JobResult& said) {
      const std::uint64_t number = under_way.extract(job).mapped();
      if (hal::stop_requested()) return false;
      Json result = Json::parse(last_line(said.output), nullptr, false);
      if (!result.is_object() || !result.contains("outcome")) {
        if (said.not_started.empty() && said.code != kNotBegun) {  // a crash or a hang is a result
          sweep::CaseResult bad;
          bad.code = said.code;
          bad.outcome = "not finished";
          bad.why = sweep::describe_end(said);
          bad.run = "match " + sweep::joined(words(number));
          result = sweep::to_json(bad);
        } else {
          why = fmt::format("seed {}: {}{}", o_.seed + number, sweep::describe_end(said),
                            said.errors.empty() ? "" : ": " + said.errors);
          return false;
        }
      }
      if (!file_->append(number, result, why)) return false;
      progress.add(1);
      return true;
    };
    sweep::ProcessPool pool(o_.jobs, hal::Duration{static_cast<std::int64_t>(o_.patience_s * 1e9)});
    pool.run(give, take);
    return why.empty();
  }

  int tell() {
    std::vector<sweep::CaseResult> matches;
    sweep::Summary summary;
    sweep::Identity ignored;
    sweep::Shard shard;
    std::string why;
    const auto each = [&](const sweep::ResultLine& line) {
      matches.push_back(sweep::case_result(line.number, line.result));
      summary.add(matches.back());
      return true;
    };
    if (!sweep::read_results(path_, ignored, shard, each, why)) return fail(why);
    const MatchStatistics s = statistics_of(matches);
    if (o_.json)
      std::printf("%s", to_line(json_of(s)).c_str());
    else
      std::printf("%s\nA %s, B %s\n%sresults: %s\n", summary.text(o_.count).c_str(), o_.teams[0].c_str(),
                  o_.teams[1].c_str(), verdict_text(s).c_str(), path_.c_str());
    std::fflush(stdout);
    const std::uint64_t all = o_.count / shard_.count + (shard_.index < o_.count % shard_.count ? 1 : 0);
    if (matches.size() < all)
      std::fprintf(stderr, "sinew: %zu of %llu matches; the same command goes on\n", matches.size(),
                   static_cast<unsigned long long>(all));
    return matches.size() == all && s.unfinished == 0 ? kDone : kFailed;
  }

  static Json json_of(const MatchStatistics& s) {
    const auto estimate = [](const MatchStatistics::Estimate& e) {
      return Json{{"mean", e.mean}, {"low", e.low}, {"high", e.high}};
    };
    return {{"matches", s.matches},
            {"won", s.won},
            {"drawn", s.drawn},
            {"lost", s.lost},
            {"unfinished", s.unfinished},
            {"points_share", estimate(s.points)},
            {"goal_difference", estimate(s.goal_difference)},
            {"p", s.p}};
  }

  const MatchOptions& o_;
  sweep::Identity identity_;
  sweep::Shard shard_;
  std::string path_;
  std::unique_ptr<sweep::ResultsFile> file_;
};

}  // namespace

MatchStatistics statistics_of(const std::vector<sweep::CaseResult>& matches) {
  MatchStatistics s;
  std::vector<double> points, differences;
  for (const sweep::CaseResult& m : matches) {
    ++s.matches;
    if (!m.good) {
      ++s.unfinished;
      continue;
    }
    const double difference = measure(m, "goals_a") - measure(m, "goals_b");
    ++(difference > 0 ? s.won : difference < 0 ? s.lost : s.drawn);
    points.push_back(difference > 0 ? 1.0 : difference < 0 ? 0.0 : 0.5);
    differences.push_back(difference);
  }
  s.points = bootstrap(points);
  s.goal_difference = bootstrap(differences);
  s.p = sweep::mcnemar_p(s.won, s.lost);
  return s;
}

std::string verdict_text(const MatchStatistics& s) {
  const std::uint64_t played = s.won + s.drawn + s.lost;
  if (played == 0) return "no match was played to its end\n";
  const sweep::Interval wins = sweep::wilson_95(s.won, played);
  std::string text = fmt::format(
      "A won {} of {} ({:.0f} %; {:.0f} to {:.0f} %), drew {}, lost {}\n"
      "points share of A {:.3f} (95 %: {:.3f} to {:.3f}), goal difference {:+.2f} a match ({:+.2f} to {:+.2f})\n",
      s.won, played, 100.0 * static_cast<double>(s.won) / static_cast<double>(played), 100 * wins.low, 100 * wins.high,
      s.drawn, s.lost, s.points.mean, s.points.low, s.points.high, s.goal_difference.mean, s.goal_difference.low,
      s.goal_difference.high);
  const bool a = s.points.low > 0.5, b = s.points.high < 0.5;
  if ((a || b) && s.p < 0.05)
    text += fmt::format("{} is better: as uneven a result of equal teams has p = {:.4f}\n", a ? "A" : "B", s.p);
  else
    text += fmt::format("these matches do not show which team is better (p = {:.3f})\n", s.p);
  return text;
}

int run_matches(const MatchOptions& options, const rt::ModuleTypes& /*types*/) { return MatchStudy(options).run(); }

}  // namespace sinew::app
