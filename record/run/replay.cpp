#include "record/run/replay.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <memory>

#include "hal/did_you_mean.hpp"
#include "record/run/recorded_run.hpp"
#include "record/run/replay_chain.hpp"
#include "record/run/replay_subject.hpp"
#include "record/run/run_messages.hpp"
#include "record/run/run_review.hpp"
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
        midway_(graph.threads().size()),
        next_order_(graph.threads().size()),
        subjects_(graph.modules().size()) {}

  hal::Result<ReplayReport> execute(std::string& why) {
    if (auto ready = prepare(why); !ready) return ready.error();
    rt::Time until = options_.until_s ? time_.after_start(*options_.until_s) : rt::Time{INT64_MAX};
    // The last steps of what was cut out reach beyond the messages: they are written several together.
    if (!read_metadata(reader_, kEditedName).empty()) until = std::min(until, time_.start + time_.length);
    std::vector<LogItem> items;
    for (std::uint64_t round = 1; run_.next(items) && items.front().due <= until; ++round) {
      for (const LogItem& item : items) execute(item);
      if (!chain_.empty() && round % 64 == 0) chain_.forget(run_);
    }
    ReplayReport report;
    report.start = time_.start;
    report.length = time_.length;
    report.midway = std::find(midway_.begin(), midway_.end(), true) != midway_.end();
    report.problems = std::move(run_.problems());
    report.pictures = run_.drawn();
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
        std::vector<std::string> names;
        for (const auto& module : graph_.modules())
          all += (all.empty() ? "" : ", ") + module.spec.name, names.push_back(module.spec.name);
        why = "no module " + name + "; there are: " + all + hal::did_you_mean(name, names);
        return hal::Error{hal::Errc::bad_data, "replay"};
      }
    for (std::uint32_t i = 0; i < graph_.modules().size(); ++i) choose(i);
    begin_midway();
    if (options_.from_s && reader_.statistics()) find_states(time_.after_start(*options_.from_s));
    run_.draw_with(options_.pictures);
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
    if (!find_beginning()) return;
    const Texts from = is_later_file() ? Texts{} : read_metadata(reader_, kFromName);  // those name states before it
    const auto first = from.empty() ? first_to_begin_at() : std::vector<std::uint64_t>(subjects_.size());
    const auto begin = [&](bool with_inputs) {
      each_state([&](ReplaySubject& subject, const LoggedState& state, std::uint64_t layout) {
        if (subject.begins() || !midway_[state.thread]) return;
        const auto named = from.find(subject.report.name);
        const std::int64_t at = named == from.end() ? 0 : std::atoll(named->second.c_str());
        if (state.completed.ns >= at && (!with_inputs || state.order >= first[state.module]))
          subject.begin_at(state, layout);
      });
    };
    begin(true);
    begin(false);  // the others, which then say what they lack
  }

  /// Of a split recording.
  bool is_later_file() {
    const Texts run = read_metadata(reader_, "sinew.run");
    const auto part = run.find("part");
    return part != run.end() && part->second != "0";
  }

  /// Which threads begin midway, and with which entry. False: none.
  bool find_beginning() {
    const Texts begin = read_metadata(reader_, kBeginName);
    if (begin.empty()) return find_beginning_of_part();
    midway_.assign(midway_.size(), true);
    for (const auto& [key, order] : begin)
      if (const auto thread = static_cast<std::size_t>(std::atoll(key.c_str()));
          key != "at_ns" && thread < next_order_.size())
        next_order_[thread] = static_cast<std::uint64_t>(std::atoll(order.c_str()));
    return true;
  }

  /// Of a part of a recording that does not name its beginning.
  bool find_beginning_of_part() {
    if (!is_later_file() && read_metadata(reader_, kEditedName).empty()) return false;
    std::vector<bool> seen(next_order_.size());
    each_step([&](const LoggedStep& s) {
      if (s.thread < seen.size() && (!seen[s.thread] || s.order < next_order_[s.thread]))
        seen[s.thread] = true, next_order_[s.thread] = s.order;
    });
    for (std::size_t t = 0; t < seen.size(); ++t) midway_[t] = next_order_[t] != 0;
    return std::find(midway_.begin(), midway_.end(), true) != midway_.end();
  }

  /// By module: the order from which on all that its steps latched is in the file.
  std::vector<std::uint64_t> first_to_begin_at() {
    std::map<std::string, std::uint32_t, std::less<>> topics;  // by channel
    std::vector<std::string> names;
    for (std::uint32_t t = 0; t < graph_.topics().size(); ++t) {
      const rt::GraphTopic& topic = graph_.topics()[t];
      names.push_back(topic.type->has_bulk() ? topic.name + std::string(kHeadSuffix) : topic.name);
      topics.emplace(names.back(), t);
    }
    std::vector<std::optional<std::uint32_t>> first(graph_.topics().size());
    each_message({.topics = std::move(names)}, [&](const Message& m) {
      auto& sequence = first[topics.at(m.channel->topic)];
      if (!sequence) sequence = m.stamps.sequence;  // they come in the order of time
    });
    std::vector<std::uint64_t> begin(subjects_.size());
    each_step([&](const LoggedStep& s) {
      if (s.module >= begin.size()) return;
      const std::vector<std::uint32_t>& topic = graph_.modules()[s.module].topic;
      for (const LoggedStep::Input& in : s.inputs) {
        if (in.sequences.empty() || in.port >= topic.size() || topic[in.port] == rt::kNone) continue;
        const auto& there = first[topic[in.port]];
        if (!there || static_cast<std::int32_t>(in.sequences.front() - *there) < 0)
          begin[s.module] = std::max(begin[s.module], s.order);
      }
    });
    return begin;
  }

  void find_states(rt::Time until) {
    each_state([&](ReplaySubject& subject, const LoggedState& state, std::uint64_t layout) {
      if (state.completed <= until) subject.begin_at(state, layout);
    });
  }

  template <class F>
  void each_state(F&& f) {
    each_message({.topics = {std::string(kStatesTopic)}, .order = Order::file}, [&](const Message& m) {
      LoggedState state;
      std::uint64_t layout = 0;
      if (decode(m.data, state, layout) && state.module < subjects_.size() && state.thread < midway_.size() &&
          subjects_[state.module])
        f(*subjects_[state.module], state, layout);
    });
  }

  template <class F>
  void each_step(F&& f) {
    std::vector<LoggedStep> batch;
    each_message({.topics = {std::string(kStepsTopic)}, .order = Order::file}, [&](const Message& m) {
      if (!decode(m.data, batch)) return;
      for (const LoggedStep& s : batch) f(s);
    });
  }

  template <class F>
  void each_message(const Query& query, F&& f) {
    MessageReader messages = reader_.messages(query);
    Message m;
    for (Next next; (next = messages.next(m)) != Next::end;)
      if (next == Next::message) f(m);
  }

  void execute(const LogItem& item) {
    log_goes_on(item);
    if (item.step && subjects_[item.step->module]) step(*item.step);
    if (!item.request || item.request->request.kind == rt::Request::Kind::set_period) return;  // in the release times
    if (auto& subject = subjects_[item.request->request.module]) subject->request(*item.request);
  }

  void step(const LoggedStep& s) {
    ReplaySubject& subject = *subjects_[s.module];
    if (midway_[s.thread] && !subject.report.from)
      subject.stop("the file begins in the middle of the run, and has no saved state of it");
    subject.step(s);
  }

  void log_goes_on(const LogItem& item) {
    std::uint64_t& next = next_order_[item.thread];
    if (item.order != next)
      for (const std::uint32_t m : graph_.threads()[item.thread].modules)
        if (subjects_[m] && !subjects_[m]->waits(item.order) && (!midway_[item.thread] || subjects_[m]->report.from))
          subjects_[m]->stop("the log of its thread has a gap: entry " + std::to_string(next) + " is not in the file");
    next = item.order + 1;
  }

  Reader& reader_;
  rt::Graph& graph_;
  const ReplayOptions& options_;
  const RecordedTime time_;
  RecordedRun run_;
  ReplayChain chain_;
  std::vector<bool> midway_;                              // by thread: the file begins there
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
