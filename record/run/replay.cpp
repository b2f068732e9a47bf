#include "record/run/replay.hpp"

#include <algorithm>
#include <memory>

#include "record/run/recorded_run.hpp"
#include "record/run/replay_chain.hpp"
#include "record/run/replay_subject.hpp"
#include "record/run/run_messages.hpp"
#include "record/run/verdict.hpp"

namespace sinew::record {
namespace {

class Replay {
 public:
  Replay(Reader& reader, rt::Graph& graph, const ReplayOptions& options)
      : reader_(reader),
        graph_(graph),
        options_(options),
        time_(recorded_time(reader)),
        run_(reader, graph),
        chain_(graph),
        next_order_(graph.threads().size()),
        subjects_(graph.modules().size()) {}

  hal::Result<ReplayReport> execute(std::string& why) {
    if (auto ready = prepare(why); !ready) return ready.error();
    const rt::Time until = options_.until_s ? time_.after_start(*options_.until_s) : rt::Time{INT64_MAX};
    std::vector<LogItem> items;
    for (std::uint64_t round = 1; run_.next(items) && items.front().due <= until; ++round) {
      for (const LogItem& item : items) execute(item);
      if (!chain_.empty() && round % 64 == 0) chain_.forget(run_);
    }
    ReplayReport report;
    report.start = time_.start;
    report.length = time_.length;
    report.problems = std::move(run_.problems());
    for (auto& s : subjects_)
      if (s) report.modules.push_back(std::move(s->report));
    return report;
  }

 private:
  hal::Status prepare(std::string& why) {
    if (auto opened = run_.open(why); !opened) return opened;
    for (const std::string& name : options_.modules)
      if (graph_.find_module(name) == rt::kNone) {
        std::string all;
        for (const auto& module : graph_.modules()) all += (all.empty() ? "" : ", ") + module.spec.name;
        why = "no module " + name + "; there are: " + all;
        return hal::Error{hal::Errc::bad_data, "replay"};
      }
    for (std::uint32_t i = 0; i < graph_.modules().size(); ++i) choose(i);
    begin_midway();
    if (options_.from_s && reader_.statistics()) find_states(time_.after_start(*options_.from_s));
    run_.begin();
    return {};
  }

  void choose(std::uint32_t module) {
    const auto& some = options_.modules;
    const std::string& name = graph_.modules()[module].spec.name;
    if (!some.empty() && std::find(some.begin(), some.end(), name) == some.end()) return;
    subjects_[module] = std::make_unique<ReplaySubject>(graph_, module, run_, chain_, options_);
    run_.need(module);
    if (options_.chain) chain_.add_writer(module);
  }

  /// For a file that begins in the middle of its run: starts each module at the state that the file names or, in a file
  /// that was cut off, at the module's first state.
  void begin_midway() {
    const Texts begin = read_metadata(reader_, kBeginName), from = read_metadata(reader_, kFromName);
    midway_ = !begin.empty();
    if (!midway_) return;
    for (const auto& [key, order] : begin)
      if (const auto thread = static_cast<std::size_t>(std::atoll(key.c_str()));
          key != "at_ns" && thread < next_order_.size())
        next_order_[thread] = static_cast<std::uint64_t>(std::atoll(order.c_str()));
    each_state([&](ReplaySubject& subject, const LoggedState& state, std::uint64_t layout) {
      const auto named = from.find(subject.report.name);
      if (!subject.begins() &&
          (named == from.end() || state.completed.ns >= static_cast<std::int64_t>(std::atoll(named->second.c_str()))))
        subject.begin_at(state, layout);
    });
  }

  void find_states(rt::Time until) {
    each_state([&](ReplaySubject& subject, const LoggedState& state, std::uint64_t layout) {
      if (state.completed <= until) subject.begin_at(state, layout);
    });
  }

  template <class F>
  void each_state(F&& f) {
    MessageReader messages = reader_.messages({.topics = {std::string(kStatesTopic)}, .order = Order::file});
    Message m;
    for (Next next; (next = messages.next(m)) != Next::end;) {
      LoggedState state;
      std::uint64_t layout = 0;
      if (next == Next::message && decode(m.data, state, layout) && state.module < subjects_.size() &&
          subjects_[state.module])
        f(*subjects_[state.module], state, layout);
    }
  }

  void execute(const LogItem& item) {
    log_goes_on(item);
    if (item.step && subjects_[item.step->module]) step(*item.step);
    if (!item.request || item.request->request.kind == rt::Request::Kind::set_period) return;  // in the release times
    if (auto& subject = subjects_[item.request->request.module]) subject->request(*item.request);
  }

  void step(const LoggedStep& s) {
    ReplaySubject& subject = *subjects_[s.module];
    if (midway_ && !subject.report.from)
      subject.stop("the file begins in the middle of the run, and has no saved state of it");
    subject.step(s);
  }

  void log_goes_on(const LogItem& item) {
    std::uint64_t& next = next_order_[item.thread];
    if (item.order != next)
      for (const std::uint32_t m : graph_.threads()[item.thread].modules)
        if (subjects_[m] && !subjects_[m]->waits(item.order))
          subjects_[m]->stop("the log of its thread has a gap: entry " + std::to_string(next) + " is not in the file");
    next = item.order + 1;
  }

  Reader& reader_;
  rt::Graph& graph_;
  const ReplayOptions& options_;
  const RecordedTime time_;
  RecordedRun run_;
  ReplayChain chain_;
  bool midway_ = false;                                   // the file begins in the middle of its run
  std::vector<std::uint64_t> next_order_;                 // by thread
  std::vector<std::unique_ptr<ReplaySubject>> subjects_;  // by module; null: not asked for
};

}  // namespace

const ReplayDifference* ReplayReport::first_difference() const {
  const ReplayDifference* first = nullptr;
  for (const ReplayedModule& m : modules)
    if (m.difference && (!first || m.difference->now < first->now)) first = &*m.difference;
  return first;
}

bool ReplayReport::complete() const {
  return std::all_of(modules.begin(), modules.end(), [](const auto& m) { return m.stopped.empty(); });
}

hal::Result<ReplayReport> replay(Reader& reader, rt::Graph& graph, const ReplayOptions& options, std::string& why) {
  return Replay(reader, graph, options).execute(why);
}

}  // namespace sinew::record
