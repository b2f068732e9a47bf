#include "apps/sweep/comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <tuple>

#include "apps/sweep/case_text.hpp"
#include "apps/sweep/results_file.hpp"
#include "apps/sweep/summary.hpp"
#include "hal/linux/file.hpp"
#include "math/hash.hpp"

namespace sinew::sweep {
namespace {

std::uint64_t run_key(const std::string& run) { return math::fnv1a64(run); }
std::uint64_t seed_key(const std::string& run) { return math::fnv1a64(seed_of(run).value_or("none")); }

std::string plural(std::uint64_t n, const char* word) { return fmt::format("{} {}{}", n, word, n == 1 ? "" : "s"); }

/// What the test says, in words.
std::string chance_text(std::uint64_t better, std::uint64_t worse) {
  if (better + worse == 0) return "no pair differs in its outcome";
  const double p = mcnemar_p(better, worse);
  const char* const says = p < 0.05 ? (better > worse ? "better, and not by chance" : "worse, and not by chance")
                                    : "no evidence of a difference: chance explains it";
  return fmt::format("{} (p = {:.3g}, exact McNemar test)", says, p);
}

}  // namespace

std::unique_ptr<Comparison> Comparison::open(const std::string& path, std::string& why) {
  auto file = hal::open_file(path);
  if (!file) {
    why = fmt::format("{}: {}", path, file.error().where);
    return nullptr;
  }
  std::unique_ptr<Comparison> made(new Comparison(path, std::move(*file)));
  Identity ignored;
  Shard shard;
  const auto note = [&](const ResultLine& line) {
    const std::string run = case_result(line.number, line.result).run;
    made->earlier_.push_back({run_key(run), seed_key(run), line.begin, static_cast<std::uint32_t>(line.text.size())});
    return true;
  };
  return read_results(path, ignored, shard, note, why) ? std::move(made) : nullptr;
}

const Comparison::Earlier* Comparison::find(std::uint64_t key) const {
  const auto at =
      std::partition_point(earlier_.begin(), earlier_.end(), [&](const Earlier& e) { return key_of(e) < key; });
  return at != earlier_.end() && key_of(*at) == key ? &*at : nullptr;
}

bool Comparison::choose(const CaseResult& first, std::string& why) {
  const std::uint64_t run = run_key(first.run);
  by_ = std::any_of(earlier_.begin(), earlier_.end(), [&](const Earlier& e) { return e.run == run; }) ? By::run
                                                                                                      : By::seed;
  std::sort(earlier_.begin(), earlier_.end(),
            [&](const Earlier& a, const Earlier& b) { return key_of(a) < key_of(b); });
  taken_.assign(earlier_.size(), false);
  const auto same = [&](const Earlier& a, const Earlier& b) { return key_of(a) == key_of(b); };
  if (std::adjacent_find(earlier_.begin(), earlier_.end(), same) == earlier_.end()) return true;
  why = fmt::format("{}: its runs have other options than these, and several of them have the same seed: no pairs",
                    path_);
  return false;
}

bool Comparison::add(const CaseResult& now, std::string& why) {
  if (by_ == By::not_known && !choose(now, why)) return false;
  const Earlier* const earlier = find(by_ == By::run ? run_key(now.run) : seed_key(now.run));
  if (!earlier) {
    ++alone_;
    return true;
  }
  const auto index = static_cast<std::size_t>(earlier - earlier_.data());
  if (taken_[index]) {
    why = fmt::format("{}: its runs have other options than these, and several of these have the same seed: no pairs",
                      path_);
    return false;
  }
  taken_[index] = true;
  std::string line(earlier->bytes, '\0');
  if (const auto done = file_->read_at(earlier->begin, std::as_writable_bytes(std::span(line))); !done) {
    why = fmt::format("{}: {}", path_, done.error().where);
    return false;
  }
  compare(case_result(0, app::Json::parse(line, nullptr, false)), now);
  return true;
}

void Comparison::compare(const CaseResult& before, const CaseResult& now) {
  if (before.good == now.good) {
    ++(now.good ? both_good_ : both_bad_);
  } else {
    ++(now.good ? better_ : worse_);
    auto& list = now.good ? got_better_ : got_worse_;
    if (list.size() < kMostListed)
      list.push_back(fmt::format("{} -> {}\n    {}", before.outcome, now.outcome, repeat_command(now.run)));
  }
  for (const MeasuredValue& m : now.measures)
    for (const MeasuredValue& b : before.measures) {
      if (m.name != b.name) continue;
      if (!changes_.contains(m.name)) order_.push_back(m.name);
      Change& change = changes_[m.name];
      change.before.add(b.value);
      change.now.add(m.value);
      change.difference.add(m.value - b.value);
      if (m.value < b.value) ++change.smaller;
      if (m.value > b.value) ++change.larger;
    }
}

std::string Comparison::text() const {
  const std::string how = by_ == By::seed ? " by seed, since their options differ" : "";
  std::string text = fmt::format("against {}: {}{}", path_, plural(pairs(), "pair"), how);
  if (alone_ > 0) text += fmt::format("; {} without one there", plural(alone_, "run"));
  text += "\n";
  if (pairs() == 0) return text;
  text += fmt::format("  good before and now {}, bad before and now {}, better {}, worse {}\n  {}\n", both_good_,
                      both_bad_, better_, worse_, chance_text(better_, worse_));
  if (!order_.empty()) {
    std::vector<std::vector<std::string>> rows{
        {"measure", "median before", "now", "median of differences", "smaller in", "larger in"}};
    for (const std::string& name : order_) {
      const Change& c = changes_.at(name);
      rows.push_back({name, fmt::format("{:.4g}", c.before.at(0.5)), fmt::format("{:.4g}", c.now.at(0.5)),
                      fmt::format("{:+.3g}", c.difference.at(0.5)), fmt::format("{}", c.smaller),
                      fmt::format("{}", c.larger)});
    }
    text += "\n" + table_text(rows, "<>>>>>");
  }
  for (const auto& [title, list, all] :
       {std::tuple("worse", &got_worse_, worse_), std::tuple("better", &got_better_, better_)}) {
    if (list->empty()) continue;
    text += fmt::format("\n{}\n", title);
    for (const std::string& one : *list) text += "  " + one + "\n";
    if (all > list->size()) text += fmt::format("  and {} more\n", all - list->size());
  }
  return text;
}

app::Json Comparison::json() const {
  app::Json all{{"file", path_},
                {"paired_by", by_ == By::seed ? "seed" : "run"},
                {"pairs", pairs()},
                {"without_pair", alone_},
                {"both_good", both_good_},
                {"both_bad", both_bad_},
                {"better", better_},
                {"worse", worse_},
                {"mcnemar_p", mcnemar_p(better_, worse_)}};
  all["measures"] = app::Json::array();
  for (const std::string& name : order_) {
    const Change& c = changes_.at(name);
    all["measures"].push_back({{"name", name},
                               {"median_before", c.before.at(0.5)},
                               {"median_now", c.now.at(0.5)},
                               {"median_difference", c.difference.at(0.5)},
                               {"smaller", c.smaller},
                               {"larger", c.larger}});
  }
  return all;
}

}  // namespace sinew::sweep
