#include "apps/run/run_summary.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "apps/run/trace_file.hpp"
#include "apps/view/gap_text.hpp"
#include "apps/view/graph_text.hpp"
#include "rt/exec/chain_budget.hpp"

namespace sinew::app {
namespace {

// Not fmt::print(), which throws where the reader is gone.
void put(const std::string& text) { std::fwrite(text.data(), 1, text.size(), stdout); }

std::string quantiles(const rt::Histogram& h) {
  if (h.count() == 0) return "none";
  return fmt::format("p50 {} p99 {} p99.9 {} max {}", human(h.quantile(0.5)), human(h.quantile(0.99)),
                     human(h.quantile(0.999)), human(h.max()));
}

const char* verdict_name(rt::ChainVerdict::Result result) {
  using R = rt::ChainVerdict::Result;
  switch (result) {
    case R::pass:
      return "pass";
    case R::fail:
      return "FAIL";
    case R::no_budget:
      return "no budget";
    case R::nothing_came:
      return "nothing came";
    case R::unknown:
      break;
  }
  return "?";
}

Json to_json(const WorldReport::Measure& m) {
  const bool ok = !(m.at_most && m.value > *m.at_most) && !(m.at_least && m.value < *m.at_least);
  Json measure{{"name", m.key}, {"label", m.label}, {"value", m.value}, {"unit", m.unit}};
  if (m.at_most) measure["at_most"] = *m.at_most;
  if (m.at_least) measure["at_least"] = *m.at_least;
  measure["ok"] = ok;
  return measure;
}

Json quantiles_ns(const rt::Histogram& h) {
  return {{"count", h.count()},
          {"p50", h.quantile(0.5).count()},
          {"p99", h.quantile(0.99).count()},
          {"p999", h.quantile(0.999).count()},
          {"max", h.max().count()}};
}

std::string tables(const rt::Graph& graph, rt::Runner& runner) {
  std::string out = "threads\n";
  for (std::uint32_t t = 0; t < graph.threads().size(); ++t) {
    const rt::ThreadStats& s = runner.thread_stats(t);
    out += fmt::format("  {:<14} {} cycles, {} overruns, {} skips, {} coalesced, {} time-outs, {} preemptions\n",
                       graph.threads()[t].spec.name, s.completions.value(), s.overruns.value(), s.skips.value(),
                       s.coalesced.value(), s.timeouts.value(), s.preemptions.value());
    out += fmt::format("  {:<14}   lateness {}\n  {:<14}   execution {}\n", "", quantiles(s.lateness), "",
                       quantiles(s.exec));
  }
  out += gap_lines(graph, runner);
  out += "modules\n";
  for (std::uint32_t m = 0; m < graph.modules().size(); ++m) {
    const rt::ModuleStats& s = runner.module_stats(m);
    out += fmt::format("  {:<14} {} steps, {} ok, {} stale, {} fault{}; {}\n", graph.modules()[m].spec.name,
                       s.steps.value(), s.ok.value(), s.stale.value(), s.fault.value(),
                       s.stopped.value() ? ", stopped" : "", quantiles(s.exec));
  }
  for (std::uint32_t i = 0; i < graph.topics().size(); ++i)
    if (runner.topic_drops(i) > 0)
      out += fmt::format("topic {}: {} messages lost to full queues\n", graph.topics()[i].name, runner.topic_drops(i));
  for (std::uint32_t c = 0; c < graph.chains().size(); ++c) {
    const rt::ChainStats& s = runner.chain_stats(c);
    out += fmt::format("chain {:<14} age {}, budget {} missed {} of {}: {}\n", graph.chains()[c].spec.name,
                       quantiles(s.age), human(graph.chains()[c].spec.budget), s.budget_misses.value(), s.age.count(),
                       verdict_name(rt::chain_within_budget(runner, c).result));
  }
  return out;
}

Json threads_json(const rt::Graph& graph, rt::Runner& runner) {
  Json all = Json::array();
  for (std::uint32_t t = 0; t < graph.threads().size(); ++t) {
    const rt::ThreadStats& s = runner.thread_stats(t);
    all.push_back({{"name", graph.threads()[t].spec.name},
                   {"cycles", s.completions.value()},
                   {"overruns", s.overruns.value()},
                   {"skips", s.skips.value()},
                   {"coalesced", s.coalesced.value()},
                   {"timeouts", s.timeouts.value()},
                   {"preemptions", s.preemptions.value()},
                   {"gaps_throttled", s.throttled.count.value()},
                   {"gaps_taken", s.taken.count.value()},
                   {"lateness_ns", quantiles_ns(s.lateness)},
                   {"execution_ns", quantiles_ns(s.exec)}});
  }
  return all;
}

Json modules_json(const rt::Graph& graph, rt::Runner& runner) {
  Json all = Json::array();
  for (std::uint32_t m = 0; m < graph.modules().size(); ++m) {
    const rt::ModuleStats& s = runner.module_stats(m);
    all.push_back({{"name", graph.modules()[m].spec.name},
                   {"steps", s.steps.value()},
                   {"ok", s.ok.value()},
                   {"stale", s.stale.value()},
                   {"fault", s.fault.value()},
                   {"stopped", s.stopped.value() != 0},
                   {"execution_ns", quantiles_ns(s.exec)}});
  }
  return all;
}

Json topics_json(const rt::Graph& graph, rt::Runner& runner) {
  Json all = Json::array();
  for (std::uint32_t t = 0; t < graph.topics().size(); ++t) {
    const rt::TopicStats& s = runner.topic_stats(t);
    all.push_back({{"name", graph.topics()[t].name},
                   {"messages", s.messages.value()},
                   {"lost", runner.topic_drops(t)},
                   {"age_ns", quantiles_ns(s.age)}});
  }
  return all;
}

Json chains_json(const rt::Graph& graph, rt::Runner& runner) {
  Json all = Json::array();
  for (std::uint32_t c = 0; c < graph.chains().size(); ++c) {
    const rt::ChainStats& s = runner.chain_stats(c);
    all.push_back({{"name", graph.chains()[c].spec.name},
                   {"budget_ns", graph.chains()[c].spec.budget.count()},
                   {"missed", s.budget_misses.value()},
                   {"verdict", verdict_name(rt::chain_within_budget(runner, c).result)},
                   {"age_ns", quantiles_ns(s.age)}});
  }
  return all;
}

}  // namespace

RunSummary::RunSummary(const rt::Graph& graph, bool virtual_time, Form form)
    : graph_(graph),
      form_(std::move(form)),
      virtual_(virtual_time),
      all_{{"robot", graph.spec().robot},
           {"board", graph.spec().board},
           {"virtual", virtual_time},
           {"seed", graph.spec().seed}} {}

void RunSummary::statistics(rt::Runner& runner) {
  if (!form_.trace.empty()) trace_failed_ = !write_trace(form_.trace, runner);
  for (std::uint32_t c = 0; c < graph_.chains().size(); ++c)
    if (const auto kept = rt::chain_within_budget(runner, c); kept.result == rt::ChainVerdict::Result::fail)
      failed_chains_.push_back(kept.text);
  if (form_.verbose) details_ += tables(graph_, runner);
  if (!form_.json) return;
  all_["threads"] = threads_json(graph_, runner);
  all_["modules"] = modules_json(graph_, runner);
  all_["topics"] = topics_json(graph_, runner);
  all_["chains"] = chains_json(graph_, runner);
}

void RunSummary::virtual_time(double run_s, double wall_s) {
  virtual_time_ = fmt::format("{:.3f} s in {:.3f} s", run_s, wall_s);
  add("virtual time", fmt::format("{}: {:.1f} times real time", virtual_time_, run_s / wall_s),
      {{"run_s", run_s}, {"wall_s", wall_s}});
}

void RunSummary::grants(std::uint32_t count, double run_s, double wall_s) {
  add("grants",
      fmt::format("{}, {:.2f} for each ms; {:.3f} ms each, with what the plant and the robot did", count,
                  count / (run_s * 1e3), wall_s * 1e3 / count),
      {{"grants", count}});
}

void RunSummary::start_up(double s) {
  add("start-up", fmt::format("{:.2f} s to the first cycle", s), {{"startup_s", s}});
}

void RunSummary::hashes(rt::Runner& runner) {
  for (std::uint32_t t = 0; t < graph_.topics().size(); ++t) {
    const std::string hash = fmt::format("{:016x}", runner.topic_hash(t));
    if (form_.json) all_["hashes"][graph_.topics()[t].name] = hash;
    if (form_.verbose) details_ += fmt::format("hash {:<24} {}\n", graph_.topics()[t].name, hash);
  }
}

void RunSummary::memory(const hal::MemoryUse& use) {
  const std::pair<const char*, std::uint64_t> parts[] = {
      {"slots", use.slots}, {"peers", use.peers},   {"program", use.program}, {"libraries", use.libraries},
      {"heap", use.heap},   {"stacks", use.stacks}, {"other", use.other}};
  std::string text = fmt::format("{:.1f} MB", static_cast<double>(use.total) * 1e-6);
  Json keys;
  const char* between = " = ";
  for (const auto& [name, bytes] : parts) {
    keys[name] = bytes;
    text += fmt::format("{}{} {:.1f}", between, name, static_cast<double>(bytes) * 1e-6);
    between = " + ";
  }
  add("memory", text, {{"memory_bytes", use.total}, {"memory", keys}});
}

void RunSummary::add(std::string_view label, std::string_view text, const Json& keys) {
  all_.update(keys);
  details_ += fmt::format("{:<19} {}\n", label, text);
}

void RunSummary::add_reasons(std::string_view label, const char* key, const std::vector<std::string>& reasons) {
  all_[key] = reasons;
  for (const auto& reason : reasons) details_ += fmt::format("{:<19} {}\n", label, reason);
}

void RunSummary::recorded(const std::string& path, std::string_view text) {
  recording_ = path;
  recorded_ = fmt::format("{}{}, {}", recorded_.empty() ? "" : "the last: ", path, text);
}

void RunSummary::judge_chains(std::string& outcome, int& code) {
  add_reasons("age budget", "chains_failed", failed_chains_);
  if (!chains_decide_ || failed_chains_.empty()) return;
  if (!virtual_) {
    if (timing_.worst.empty()) {
      timing_.worst = failed_chains_.front();
      timing_.what_to_do = "`--trace FILE` shows what each thread did";
    }
    timing_.reasons.insert(timing_.reasons.end(), failed_chains_.begin(), failed_chains_.end());
    return;
  }
  if (code != 0) return;
  code = 1;
  outcome += outcome.empty() ? "a chain missed its age budget" : ", but a chain missed its age budget";
  if (why_.empty()) why_ = failed_chains_.front();
}

void RunSummary::ended_early(std::string_view how, double at_s) {
  end_ = how;
  ended_early_ = fmt::format("{} at {:.1f} s", how, at_s);
  keep({{"ended_early", {{"how", how}, {"at_s", at_s}}}});
}

void RunSummary::lost(std::string_view what, double at_s, std::string_view why) {
  lost_ = what, lost_at_s_ = at_s, lost_why_ = why;
  keep({{"lost", {{"what", what}, {"at_s", at_s}, {"why", why}}}});
}

void RunSummary::judge_end(std::string& outcome, int& code) {
  if (!ended_early_.empty()) outcome += (outcome.empty() ? "" : ", ") + ended_early_;
  if (lost_.empty()) return;
  const char* const between = code == 0 ? ", but " : ": ";
  const std::string lost = fmt::format("{} at {:.1f} s", lost_, lost_at_s_);
  outcome += (outcome.empty() ? "" : between) + lost;
  code = 1;
  end_ = lost_;
  why_ = lost_why_;
  story_.add(lost_at_s_, Story::Weight::result, lost_);
  timing_.worst = lost;
  timing_.what_to_do.clear();
  timing_.reasons.insert(timing_.reasons.begin(), lost);
  judged_ = true;
}

std::string RunSummary::timing_line() const {
  const std::string time = virtual_time_.empty() ? "" : fmt::format("; virtual time, {}", virtual_time_);
  if (timing_.reasons.empty()) return "valid as a measurement" + time;
  const std::size_t more = timing_.reasons.size() - 1;
  std::string text = "not valid as a measurement: " + timing_.worst;
  if (!timing_.what_to_do.empty()) text += "; " + timing_.what_to_do;
  if (more > 0) text += fmt::format("; {} more reason{}: --verbose", more, more == 1 ? "" : "s");
  return text + time;
}

void RunSummary::print(const std::string& mission, int code) const {
  const auto line = [](const char* label, std::string_view text) { return fmt::format("{:<9} {}\n", label, text); };
  std::string out = line("mission", mission);
  if (form_.quiet) return put(out);
  out += line("timing", timing_line());
  const bool again = code != 0 && !again_.empty() && ended_early_.empty();
  const std::size_t events = again ? kMostEvents - 1 : kMostEvents;
  for (const std::string& event : story_.lines(form_.verbose ? Story::kMost : events)) out += event + "\n";
  if (!why_.empty()) out += line("why", why_);
  if (again) out += line("again", again_);
  if (!recorded_.empty()) out += line("recorded", recorded_);
  if (form_.verbose) return put(out + "\n" + details_);
  const std::string look =
      recording_.empty() ? "" : fmt::format("`sinew bag info {}` shows what it holds; ", recording_);
  put(out + line("next", look + "--verbose prints threads, modules, topics and hashes, too"));
}

int RunSummary::finish(std::string_view outcome, int code) {
  std::string mission(outcome);
  judge_chains(mission, code);
  judge_end(mission, code);
  const bool good = code == 0, valid = timing_.reasons.empty();
  const char* const counts = valid ? "valid run" : "invalid run";
  const std::string result = judged_ ? fmt::format("{}{}{}", mission, mission.empty() ? "" : ", ", counts) : mission;
  add_reasons("invalid", "invalid_because", timing_.reasons);
  if (code == 0 && ((!valid && (form_.strict || virtual_)) || trace_failed_)) code = 1;
  if (before_print_) before_print_({end_, mission, why_, code, timing_.worst});
  Json measures = Json::array();
  for (const WorldReport::Measure& m : measures_) measures.push_back(to_json(m));
  Json story = Json::array();
  for (const Story::Event& e : story_.events()) story.push_back({{"at_s", e.at_s}, {"text", e.text}});
  add("result", result,
      {{"mission", {{"outcome", mission}, {"good", good}, {"why", why_}, {"measures", measures}}},
       {"timing", {{"valid", valid}, {"worst", timing_.worst}, {"what_to_do", timing_.what_to_do}}},
       {"story", story},
       {"result", result},
       {"exit_code", code}});
  if (form_.json) {
    put(all_.dump() + "\n");
    return code;
  }
  std::string figures;
  for (const WorldReport::Measure& m : measures_) figures += (figures.empty() ? ": " : ", ") + in_words(m);
  print((mission.empty() ? "nothing to judge" : mission) + figures, code);
  return code;
}

}  // namespace sinew::app
