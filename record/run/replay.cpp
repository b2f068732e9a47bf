#include "record/run/replay.hpp"

#include <algorithm>
#include <map>
#include <queue>
#include <set>

#include "msg/compare.hpp"
#include "msg/ros2msg.hpp"
#include "record/run/message_store.hpp"
#include "record/run/verdict.hpp"
#include "rt/step_again.hpp"

namespace sinew::record {
namespace {

using PortKind = rt::Declaration::PortKind;

const char* name_of(rt::Request::Kind kind) {
  using K = rt::Request::Kind;
  switch (kind) {
    case K::set_param:
      return "set_param";
    case K::enable:
      return "enable";
    case K::disable:
      return "disable";
    case K::set_period:
      return "set_period";
    case K::arm:
      return "arm";
    case K::disarm:
      return "disarm";
    case K::message:
      return "message";
  }
  return "?";
}

const char* name_of(rt::Status status) {
  return status == rt::Status::ok ? "ok" : status == rt::Status::stale ? "stale" : "fault";
}

std::string text(const rt::Effect& e) {
  return std::string(e.refused ? "refused before step " : "from step ") + std::to_string(e.step);
}

// What a thread's log has: a step, or a request. It may be executed when everything that was visible by `due` is known.
struct Item {
  rt::Time due;
  std::uint32_t thread;
  std::uint64_t order;
  std::optional<LoggedStep> step{};
  std::optional<LoggedRequest> request{};  // neither: a saved state
  friend bool operator>(const Item& a, const Item& b) {
    return std::tie(a.due.ns, a.thread, a.order) > std::tie(b.due.ns, b.thread, b.order);
  }
};

/// One module that is executed again.
class Subject {
 public:
  Subject(rt::Graph& graph, std::uint32_t module, std::vector<MessageStore>& stores)
      : about_(graph.modules()[module]),
        again_(graph, module),
        stores_(stores),
        inputs_(about_.topic.size()),
        held_(about_.topic.size()) {
    report.name = about_.spec.name;
  }
  bool runs() const { return report.stopped.empty() && !report.difference; }
  /// Begins behind this state; until then only parameters are followed.
  void begin_at(const LoggedState& state, std::uint64_t layout) {
    begin_ = state.order;
    begin_bytes_.assign(state.bytes.begin(), state.bytes.end());
    begin_layout_ = layout;
    report.from = state.completed;
  }
  bool begins() const { return begin_.has_value(); }
  bool waits(std::uint64_t order) const { return begin_ && order <= *begin_; }
  void stop(std::string why) {
    if (runs()) report.stopped = std::move(why);
  }

  void step(const LoggedStep& s) {
    if (!runs() || waits(s.order) || !begun() || !hold(s)) return;
    if (about_.external && !post(s)) return;
    rt::StepRecord record;
    record.module = s.module, record.thread = s.thread, record.number = s.number;
    record.release = s.release, record.now = s.now, record.completed = s.completed;
    record.dt = s.dt, record.exec = s.exec, record.timed_out = s.timed_out, record.device_state = s.device_state;
    record.status = s.status;
    const auto status = again_.step(record, inputs_);
    if (!status) return stop("step " + std::to_string(s.number) + ": " + status.error().where);
    ++report.steps;
    if (*status != s.status) return differs(s, "status", name_of(s.status), name_of(*status));
    for (std::uint32_t p = 0; p < about_.topic.size(); ++p)
      if (about_.declaration.ports[p].kind == PortKind::output && about_.topic[p] != rt::kNone) compare(s, p);
  }

  void request(const LoggedRequest& r) {
    if (!runs() || r.request.kind == rt::Request::Kind::message) return;  // those come with their step
    if (waits(r.order)) {
      if (r.request.kind == rt::Request::Kind::set_param && !again_.take(r.request, r.effect)) stop("set_param");
      return;
    }
    if (!begun()) return;
    const auto effect = again_.take(r.request, r.effect);
    if (!effect) return stop(std::string(name_of(r.request.kind)) + ": " + effect.error().where);
    if (*effect == r.effect) return;
    LoggedStep at;
    at.number = r.effect.step;
    at.now = r.now;
    differs(at, std::string("effect of ") + name_of(r.request.kind), text(r.effect), text(*effect));
  }

  ReplayedModule report;

 private:
  /// False when the state that it should begin with does not fit.
  bool begun() {
    if (!begin_) return true;
    const bool fits = begin_layout_ == again_.state_layout() && again_.restore_state(begin_bytes_);
    begin_.reset();
    if (!fits) stop("its state was saved by another version of the module or another kind of machine");
    return fits;
  }

  bool hold(const LoggedStep& s) {
    for (auto& input : inputs_) input = {};
    for (const LoggedStep::Input& in : s.inputs) {
      if (in.port >= about_.topic.size() || about_.topic[in.port] == rt::kNone)
        return stop("the record has an input that this module does not have"), false;
      std::vector<const rt::SlotHeader*>& held = held_[in.port];
      held.clear();
      for (const std::uint32_t sequence : in.sequences) {
        const MessageStore::Entry* entry = stores_[about_.topic[in.port]].find(sequence);
        if (!entry || !entry->whole) return missing(s, in.port, sequence, entry != nullptr), false;
        held.push_back(entry->header());
      }
      inputs_[in.port] = {held, in.updated, in.dropped};
    }
    for (const LoggedStep::Output& out : s.outputs)
      if (out.port >= about_.topic.size() || about_.topic[out.port] == rt::kNone)
        return stop("the record has an output that this module does not have"), false;
    return true;
  }

  void missing(const LoggedStep& s, std::uint32_t port, std::uint32_t sequence, bool has_head) {
    stop("at " + seconds_text(s.now) + ": input " + about_.declaration.ports[port].name + ": " +
         (has_head ? "the pixels of message " : "message ") + std::to_string(sequence) +
         (has_head ? " are not in the file" : " is not in the file"));
  }

  /// What came from outside is in the file as what was published.
  bool post(const LoggedStep& s) {
    for (const LoggedStep::Output& out : s.outputs)
      for (std::uint32_t i = 0; i < out.count; ++i) {
        const MessageStore::Entry* entry = stores_[about_.topic[out.port]].find(out.first + i);
        if (!entry) return stop("a message from outside is not in the file"), false;
        rt::Request request;
        request.kind = rt::Request::Kind::message;
        request.index = out.port;
        const std::span message(static_cast<const std::byte*>(entry->message()),
                                stores_[about_.topic[out.port]].type().size);
        if (auto taken = again_.take(request, {s.number, false}, message); !taken)
          return stop(std::string("message: ") + taken.error().where), false;
      }
    return true;
  }

  void compare(const LoggedStep& s, std::uint32_t port) {
    if (!runs()) return;
    const auto published = again_.published(port);
    const auto recorded =
        std::find_if(s.outputs.begin(), s.outputs.end(), [&](const auto& o) { return o.port == port; });
    const std::uint32_t count = recorded == s.outputs.end() ? 0 : recorded->count;
    const std::string& name = about_.declaration.ports[port].name;
    if (published.size() != count)
      return differs(s, "messages on " + name, std::to_string(count), std::to_string(published.size()));
    const MessageStore& store = stores_[about_.topic[port]];
    for (std::uint32_t i = 0; i < count; ++i) {
      const MessageStore::Entry* entry = store.find(recorded->first + i);
      if (!entry || !entry->whole) {
        ++report.not_compared;
        continue;
      }
      ++report.messages;
      if (msg::equal(store.type(), entry->message(), published[i]->message())) continue;
      const auto d = msg::first_difference(store.type(), entry->message(), published[i]->message());
      return differs(s, name + "." + d->path, d->a, d->b);
    }
  }

  void differs(const LoggedStep& s, std::string what, std::string recorded, std::string again) {
    report.difference =
        ReplayDifference{report.name, s.number, s.now, std::move(what), std::move(recorded), std::move(again)};
  }

  const rt::GraphModule& about_;
  rt::StepAgain again_;
  std::vector<MessageStore>& stores_;
  std::optional<std::uint64_t> begin_;  // order of the state, until it is restored
  std::vector<std::byte> begin_bytes_;
  std::uint64_t begin_layout_ = 0;
  std::vector<rt::StepAgain::Input> inputs_;
  std::vector<std::vector<const rt::SlotHeader*>> held_;
};

class Replay {
 public:
  Replay(Reader& reader, rt::Graph& graph, const ReplayOptions& options)
      : reader_(reader),
        graph_(graph),
        options_(options),
        next_order_(graph.threads().size()),
        subjects_(graph.modules().size()),
        keep_(graph.topics().size(), 1),
        wanted_(graph.topics().size()) {
    for (const rt::GraphTopic& t : graph.topics()) stores_.emplace_back(*t.type);
  }

  hal::Result<ReplayReport> run(std::string& why) {
    if (auto ready = prepare(why); !ready) return ready.error();
    MessageReader messages = reader_.messages({.topics = names_});
    Message m;
    for (Next next; (next = messages.next(m)) != Next::end;) {
      if (next == Next::problem) {
        report_.problems.push_back(messages.problem());
        continue;
      }
      const rt::Time t = robot_time(m.stamps.log_time);
      if (t > now_) execute_until(now_ = t);
      take(m, t);
    }
    execute_until(rt::Time{INT64_MAX});
    if (const auto& all = reader_.statistics())
      report_.length = rt::Duration{static_cast<std::int64_t>(all->end_time - all->start_time)};
    for (auto& s : subjects_)
      if (s) report_.modules.push_back(std::move(s->report));
    return std::move(report_);
  }

 private:
  hal::Status fail(std::string& why, std::string words) {
    why = std::move(words);
    return hal::Error{hal::Errc::bad_data, "replay"};
  }

  hal::Status prepare(std::string& why) {
    const Texts run = read_metadata(reader_, "sinew.run"), modules = read_metadata(reader_, "sinew.modules");
    if (!run.contains("unix_ns") || modules.empty()) return fail(why, "the file holds no run of Sinew");
    unix_ns_ = std::atoll(run.at("unix_ns").c_str());
    std::size_t m = 0;
    for (const auto& [index, name] : modules) {
      if (m >= graph_.modules().size() || graph_.modules()[m].spec.name != name)
        return fail(why, "module " + index + " of the run is " + name + ", of the robot " +
                             (m < graph_.modules().size() ? graph_.modules()[m].spec.name : "none"));
      ++m;
    }
    if (m != graph_.modules().size()) return fail(why, "the robot has more modules than the run");
    for (const std::string& name : options_.modules)
      if (graph_.find_module(name) == rt::kNone) {
        std::string all;
        for (const auto& module : graph_.modules()) all += (all.empty() ? "" : ", ") + module.spec.name;
        return fail(why, "no module " + name + "; there are: " + all);
      }
    for (std::uint32_t i = 0; i < graph_.modules().size(); ++i) choose(i);
    find_channels();
    begin_midway();
    if (options_.from_s && reader_.statistics())
      find_states(robot_time(reader_.statistics()->start_time) +
                  rt::Duration{static_cast<std::int64_t>(*options_.from_s * 1e9)});
    return {};
  }

  /// A file that begins in the middle of its run: each module at the state that the file names or, where it was cut
  /// off, at its first one.
  void begin_midway() {
    const Texts begin = read_metadata(reader_, kBeginName), from = read_metadata(reader_, kFromName);
    midway_ = !begin.empty();
    if (!midway_) return;
    for (const auto& [key, order] : begin)
      if (const auto thread = static_cast<std::size_t>(std::atoll(key.c_str()));
          key != "at_ns" && thread < next_order_.size())
        next_order_[thread] = static_cast<std::uint64_t>(std::atoll(order.c_str()));
    each_state([&](Subject& subject, const LoggedState& state, std::uint64_t layout) {
      const auto named = from.find(subject.report.name);
      if (!subject.begins() &&
          (named == from.end() || state.completed.ns >= static_cast<std::int64_t>(std::atoll(named->second.c_str()))))
        subject.begin_at(state, layout);
    });
  }

  void find_states(rt::Time until) {
    each_state([&](Subject& subject, const LoggedState& state, std::uint64_t layout) {
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

  void choose(std::uint32_t module) {
    const rt::GraphModule& m = graph_.modules()[module];
    const auto& some = options_.modules;
    if (!some.empty() && std::find(some.begin(), some.end(), m.spec.name) == some.end()) return;
    subjects_[module] = std::make_unique<Subject>(graph_, module, stores_);
    for (std::size_t p = 0; p < m.topic.size(); ++p) {
      if (m.topic[p] == rt::kNone) continue;
      wanted_[m.topic[p]] = true;
      const auto& port = m.declaration.ports[p];
      if (port.kind == PortKind::output) continue;
      keep_[m.topic[p]] = std::max<std::size_t>(keep_[m.topic[p]], port.depth);
      if (port.kind == PortKind::queue && port.overflow == rt::Overflow::drop_newest)
        waiting_.emplace(std::pair(module, static_cast<std::uint32_t>(p)), std::nullopt);
    }
  }

  enum class What : std::uint8_t { steps, requests, states, message, image, image_head };
  void find_channels() {
    for (const auto& entry : reader_.channels()) {
      const Channel& channel = entry.second;
      const auto add = [&](What what, std::uint32_t topic) {
        channels_.emplace(channel.id, std::pair(what, topic));
        names_.push_back(channel.topic);
      };
      if (channel.topic == kStepsTopic) add(What::steps, 0);
      if (channel.topic == kRequestsTopic) add(What::requests, 0);
      if (channel.topic == kStatesTopic) add(What::states, 0);
      for (std::uint32_t t = 0; t < graph_.topics().size(); ++t) {
        const rt::GraphTopic& topic = graph_.topics()[t];
        if (!wanted_[t]) continue;
        if (channel.topic == topic.name && same_type(channel, *topic.type))
          add(topic.type->has_bulk() ? What::image : What::message, t);
        if (topic.type->has_bulk() && channel.topic == topic.name + std::string(kHeadSuffix)) add(What::image_head, t);
      }
    }
  }

  /// The bytes of another version of a type may well fit this one, and mean something else.
  bool same_type(const Channel& channel, const msg::TypeInfo& type) {
    const auto schema = reader_.schemas().find(channel.schema);
    const std::string ours = type.has_bulk() ? std::string(image_schema().text) : msg::ros2msg_schema(type);
    if (schema != reader_.schemas().end() && schema->second.data == ours) return true;
    report_.problems.push_back({ProblemKind::bad_record, 0,
                                "topic " + channel.topic + ": recorded with another version of " +
                                    std::string(type.name) + "; its messages are not used"});
    return false;
  }

  rt::Time robot_time(std::uint64_t log_time) const { return {static_cast<std::int64_t>(log_time) - unix_ns_}; }

  void take(const Message& m, rt::Time t) {
    const auto [what, topic] = channels_.at(m.channel->id);
    bool good = true;
    if (what == What::steps) {
      good = decode(m.data, batch_);
      for (LoggedStep& s : batch_) good = push(Item{s.completed, s.thread, s.order, std::move(s), {}}) && good;
    } else if (what == What::requests) {
      LoggedRequest r;
      good = decode(m.data, r);
      if (good) good = push(Item{r.now, r.request.thread, r.order, {}, r});
    } else if (what == What::states) {  // it has its place in the log
      LoggedState state;
      std::uint64_t layout = 0;
      good = decode(m.data, state, layout) && state.thread < next_order_.size();
      if (good) items_.push(Item{state.completed, state.thread, state.order, {}, {}});
    } else if (what == What::message) {
      good = stores_[topic].add(m.stamps.sequence, t, m.data);
    } else if (what == What::image) {
      good = stores_[topic].add_pixels(m.stamps.sequence, t, m.data);
    } else {
      good = stores_[topic].add_head(m.stamps.sequence, t, m.data);
    }
    if (!good) report_.problems.push_back({ProblemKind::bad_record, 0, "message of " + m.channel->topic});
  }

  bool push(Item item) {
    const bool known = item.thread < next_order_.size() &&
                       (item.request ? item.request->request.module : item.step->module) < subjects_.size();
    if (!known) return false;
    if (item.step) earliest_.insert(item.step->now.ns);
    items_.push(std::move(item));
    return true;
  }

  /// What was visible before `t` is known.
  void execute_until(rt::Time t) {
    bool any = false;
    while (!items_.empty() && items_.top().due < t) {
      Item item = std::move(const_cast<Item&>(items_.top()));  // it is gone with the next line
      items_.pop();
      any = true;
      log_goes_on(item);
      if (item.request)
        request(*item.request);
      else if (item.step)
        step(*item.step);
    }
    if (any) forget(t);
  }

  void log_goes_on(const Item& item) {
    std::uint64_t& next = next_order_[item.thread];
    if (item.order != next)
      for (const std::uint32_t m : graph_.threads()[item.thread].modules)
        if (subjects_[m] && !subjects_[m]->waits(item.order))
          subjects_[m]->stop("the log of its thread has a gap: entry " + std::to_string(next) + " is not in the file");
    next = item.order + 1;
  }

  void step(const LoggedStep& s) {
    earliest_.erase(earliest_.find(s.now.ns));
    if (!subjects_[s.module]) return;
    if (midway_ && !subjects_[s.module]->report.from)
      subjects_[s.module]->stop("the file begins in the middle of the run, and has no saved state of it");
    subjects_[s.module]->step(s);
    for (const auto& in : s.inputs)
      if (auto waits = waiting_.find({s.module, in.port}); waits != waiting_.end() && !in.sequences.empty())
        waits->second = in.sequences.back() + 1;
  }

  void request(const LoggedRequest& r) {
    if (r.request.kind == rt::Request::Kind::set_period) return;  // of the thread: in the release times
    if (subjects_[r.request.module]) subjects_[r.request.module]->request(r);
  }

  void forget(rt::Time t) {
    if (++rounds_ % 64 != 0) return;
    const rt::Time horizon{earliest_.empty() ? std::min(t.ns, now_.ns) : std::min(*earliest_.begin(), now_.ns)};
    for (std::uint32_t topic = 0; topic < stores_.size(); ++topic) {
      std::optional<std::uint32_t> from;
      bool none_yet = false;
      for (const auto& [port, next] : waiting_) {
        if (graph_.modules()[port.first].topic[port.second] != topic) continue;
        none_yet |= !next;
        if (next && (!from || static_cast<std::int32_t>(*next - *from) < 0)) from = next;
      }
      if (!none_yet) stores_[topic].forget(horizon, keep_[topic] + 1, from);
    }
  }

  Reader& reader_;
  rt::Graph& graph_;
  const ReplayOptions& options_;
  std::int64_t unix_ns_ = 0;
  bool midway_ = false;
  std::uint64_t rounds_ = 0;
  rt::Time now_{INT64_MIN};
  std::vector<MessageStore> stores_;  // by topic
  std::vector<std::uint64_t> next_order_;
  std::vector<std::unique_ptr<Subject>> subjects_;  // by module; null: not asked for
  std::vector<std::size_t> keep_;                   // by topic: what the deepest port may hold
  std::vector<bool> wanted_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::optional<std::uint32_t>>
      waiting_;  // drop-newest: next to take
  std::map<std::uint16_t, std::pair<What, std::uint32_t>> channels_;
  std::vector<std::string> names_;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> items_;
  std::multiset<std::int64_t> earliest_;  // of the steps that wait
  std::vector<LoggedStep> batch_;
  ReplayReport report_;
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
  return Replay(reader, graph, options).run(why);
}

}  // namespace sinew::record
