#include "record/run/run_review.hpp"

#include <algorithm>
#include <charconv>
#include <set>
#include <unordered_map>

#include "math/hash.hpp"
#include "record/run/run_messages.hpp"

namespace sinew::record {
namespace {

template <class T>
T number_of(std::string_view text) {
  T value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

/// Sequences that mostly come in order; they may go on at 0 behind the largest.
class NumberSet {
 public:
  void add(std::uint32_t n) {
    if (!runs_.empty() && n == runs_.back().end && runs_.back().end < kEnd)
      ++runs_.back().end;
    else
      runs_.push_back({n, std::uint64_t{n} + 1, 0});
  }
  /// After the last add(), before what follows.
  void sort() {
    std::sort(runs_.begin(), runs_.end(), [](const Run& a, const Run& b) { return a.first < b.first; });
    std::size_t last = 0;
    for (std::size_t i = 1; i < runs_.size(); ++i)
      if (runs_[i].first <= runs_[last].end)
        runs_[last].end = std::max(runs_[last].end, runs_[i].end);
      else
        runs_[++last] = runs_[i];
    if (!runs_.empty()) runs_.resize(last + 1);
    std::uint64_t before = 0;
    for (Run& r : runs_) r.before = before, before += r.end - r.first;
  }
  /// Answers how many of the `count` numbers from `first` on are in the set.
  std::uint32_t there(std::uint32_t first, std::uint32_t count) const {
    const std::uint64_t end = std::uint64_t{first} + count;
    std::uint64_t n = below(std::min(end, kEnd)) - below(first);
    if (end > kEnd) n += below(end - kEnd);
    return static_cast<std::uint32_t>(n);
  }
  /// The first of those numbers that is in the set; one of them must be.
  std::uint32_t first_there(std::uint32_t first, std::uint32_t count) const {
    std::uint32_t none = 0, some = count;  // the first `none` hold no member, the first `some` do
    while (some - none > 1) {
      const std::uint32_t half = none + (some - none) / 2;
      (there(first, half) == 0 ? none : some) = half;
    }
    return first + none;
  }

 private:
  static constexpr std::uint64_t kEnd = std::uint64_t{1} << 32;
  struct Run {
    std::uint64_t first, end;
    std::uint64_t before;  // numbers in the earlier runs
  };
  std::uint64_t below(std::uint64_t n) const {
    const auto behind =
        std::upper_bound(runs_.begin(), runs_.end(), n, [](std::uint64_t v, const Run& r) { return v < r.first; });
    if (behind == runs_.begin()) return 0;
    const Run& r = *(behind - 1);
    return r.before + std::min(n, r.end) - r.first;
  }
  std::vector<Run> runs_;
};

/// The reason without its time, which the recorder knows only roughly.
std::string_view without_time(std::string_view reason) {
  for (const std::string_view at : {" at ", " from "}) {
    const auto found = reason.rfind(at);
    if (found != std::string_view::npos && reason.find(" s", found) != std::string_view::npos)
      return reason.substr(0, found);
  }
  return reason;
}

std::set<std::string_view> reasons_in(std::string_view text) {
  std::set<std::string_view> all;
  while (!text.empty()) {
    const auto end = std::min(text.find("; "), text.size());
    all.insert(without_time(text.substr(0, end)));
    text.remove_prefix(std::min(end + 2, text.size()));
  }
  return all;
}

class Review {
 public:
  explicit Review(Reader& reader) : reader_(reader) {}

  RunReview run() {
    result_.run = read_metadata(reader_, "sinew.run");
    result_.said_verdict = read_metadata(reader_, "sinew.verdict");
    result_.said_losses = read_metadata(reader_, "sinew.losses");
    result_.ended = !result_.said_verdict.empty();
    unix_ns_ = number_of<std::int64_t>(result_.run["unix_ns"]);
    begin_ = read_metadata(reader_, kBeginName);
    edited_ = !read_metadata(reader_, kEditedName).empty();
    if (reader_.statistics()) end_ = robot_time(reader_.statistics()->end_time);
    result_.is_part = edited_ || number_of<unsigned>(result_.run["part"]) > 0;
    if (!find_graph()) return std::move(result_);
    result_.is_run = true;
    find_channels();
    read_messages();
    judge_heads();
    read_steps();
    judge_ends();
    give_verdict();
    compare();
    return std::move(result_);
  }

 private:
  struct Topic {
    TopicKept kept;
    bool is_image = false;
    NumberSet messages;                                              // of images: heads
    bool begun = false;                                              // a message named by a step was there
    std::optional<std::pair<std::uint64_t, std::uint32_t>> first{};  // log time and sequence of the earliest
    std::optional<std::uint32_t> newest{};                           // named by a step
    msg::Time next;                                                  // as the recorder's
    std::unordered_map<std::uint32_t, std::uint64_t> pixel_hash;
    struct Head {
      std::uint32_t sequence;
      bool has_pixels;
      std::uint64_t hash;
      msg::Time at;
    };
    std::vector<Head> heads;
  };
  struct Module {
    std::string name;
    std::uint32_t thread = 0;
    bool source = false;
    std::map<std::uint32_t, std::size_t> topics;  // by port
    std::vector<std::size_t> inputs;              // topics; with the driver's raw topic, which its steps publish, too
    bool stepped = false;
    std::optional<msg::Time> from{};  // midway: the saved state where a replay can begin
  };
  struct Thread {
    std::string name;
    bool recorded = true;    // its steps belong in the file
    std::uint64_t next = 0;  // order
    bool begun = false;
    msg::Time newest;  // completion
    Losses lost;
  };

  msg::Time robot_time(std::uint64_t in_file) const {
    return {static_cast<std::int64_t>(in_file - static_cast<std::uint64_t>(unix_ns_))};
  }

  std::size_t topic(const std::string& name) {
    const auto [at, is_new] = topic_by_name_.emplace(name, topics_.size());
    if (is_new) topics_.emplace_back().kept.name = name;
    return at->second;
  }

  bool find_graph() {
    for (const auto& [key, name] : read_metadata(reader_, "sinew.threads")) threads_.emplace_back().name = name;
    if (const auto some = result_.run.find(std::string(kThreadsKey)); some != result_.run.end())
      for (Thread& t : threads_) t.recorded = (" " + some->second + " ").find(" " + t.name + " ") != std::string::npos;
    for (const auto& [key, name] : read_metadata(reader_, "sinew.modules")) modules_.emplace_back().name = name;
    const Texts graph = read_metadata(reader_, "sinew.graph");
    for (const auto& [key, value] : graph) {
      const std::size_t dot = std::min(key.find('.'), key.size());
      const auto index = number_of<std::size_t>(std::string_view(key).substr(0, dot));
      if (index >= modules_.size()) return false;
      Module& m = modules_[index];
      const std::string name = value.substr(std::min(value.rfind(' ') + 1, value.size()));
      if (dot == key.size()) {
        m.source = value.starts_with("source");
        m.thread = number_of<std::uint32_t>(name);
        if (m.thread >= threads_.size()) return false;
      } else {
        const bool out = value.starts_with("out ");
        const std::size_t t = topic(value.substr(std::min<std::size_t>(out ? 4 : 3, value.size())));
        m.topics[number_of<std::uint32_t>(std::string_view(key).substr(dot + 1))] = t;
        if (!out) m.inputs.push_back(t);
      }
    }
    for (const auto& [key, order] : begin_)
      if (const auto index = number_of<std::size_t>(key); key != "at_ns" && index < threads_.size())
        threads_[index].next = number_of<std::uint64_t>(order);
    return !graph.empty() && !threads_.empty();
  }

  void find_channels() {
    for (Topic& t : topics_) t.kept.wanted = false;
    for (const auto& [id, channel] : reader_.channels()) {
      const auto known = topic_by_name_.find(channel.topic);
      if (known == topic_by_name_.end()) continue;
      Topic& t = topics_[known->second];
      t.kept.wanted = true;
      if (const auto rate = channel.metadata.find("rate_hz"); rate != channel.metadata.end())
        t.kept.rate_hz = number_of<double>(rate->second);
      const auto schema = reader_.schemas().find(channel.schema);
      t.is_image = schema != reader_.schemas().end() && schema->second.name == image_schema().name;
    }
  }

  template <class F>
  void each(std::vector<std::string> topics, F&& f) {
    if (topics.empty()) return;
    auto messages = reader_.messages({.topics = std::move(topics), .order = Order::file});
    Message m;
    for (Next next; (next = messages.next(m)) != Next::end;)
      if (next == Next::message) f(m);
  }

  void read_messages() {
    std::vector<std::string> names;
    for (const Topic& t : topics_) {
      names.push_back(t.kept.name);
      if (t.is_image) names.push_back(t.kept.name + std::string(kHeadSuffix));
    }
    each(std::move(names), [this](const Message& m) {
      const std::string& name = m.channel->topic;
      if (const auto known = topic_by_name_.find(name); known != topic_by_name_.end())
        return message(topics_[known->second], m);
      head(topics_[topic_by_name_.at(name.substr(0, name.size() - kHeadSuffix.size()))], m);
    });
    for (Topic& t : topics_) t.messages.sort();
  }

  void message(Topic& t, const Message& m) {
    if (!t.is_image) return is_there(t, m.stamps);
    if (const auto pixels = image_pixels(m.data))
      t.pixel_hash[m.stamps.sequence] = math::hash64(pixels->data(), pixels->size());
  }

  static void is_there(Topic& t, const Stamps& stamps) {
    t.messages.add(stamps.sequence);
    if (!t.first || stamps.log_time < t.first->first) t.first = std::pair(stamps.log_time, stamps.sequence);
  }

  void head(Topic& t, const Message& m) {
    ImageHead head;
    if (!decode(m.data, head)) return;
    is_there(t, m.stamps);
    t.heads.push_back({m.stamps.sequence, head.has_pixels, head.pixel_hash, robot_time(m.stamps.log_time)});
  }

  void judge_heads() {
    for (Topic& t : topics_) {
      Losses other;
      for (const Topic::Head& h : t.heads) {
        const auto pixels = t.pixel_hash.find(h.sequence);
        if (!h.has_pixels)
          t.kept.without_pixels.add(1, h.at);
        else if (pixels == t.pixel_hash.end())
          t.kept.lost.add(1, h.at);
        else if (pixels->second != h.hash)
          other.add(1, h.at);
      }
      if (other.count != 0) result_.other_pixels.emplace(t.kept.name, other);
    }
  }

  void read_steps() {
    std::vector<LoggedStep> batch;
    LoggedRequest request;
    each({std::string(kStepsTopic), std::string(kRequestsTopic), std::string(kStatesTopic)}, [&](const Message& m) {
      LoggedState state;
      std::uint64_t layout = 0;
      if (m.channel->topic == kStatesTopic) {
        if (!decode(m.data, state, layout)) return;
        entry(state.thread, state.order);
        if (state.module < modules_.size() && !modules_[state.module].from)
          modules_[state.module].from = state.completed;
        return;
      }
      if (m.channel->topic == kRequestsTopic) {
        if (decode(m.data, request)) entry(request.request.thread, request.order);
        return;
      }
      if (!decode(m.data, batch)) return;
      for (const LoggedStep& s : batch) step(s);
    });
  }

  void entry(std::uint32_t thread, std::uint64_t order) {
    if (thread >= threads_.size()) return;
    Thread& t = threads_[thread];
    if (!t.begun && result_.is_part && begin_.empty()) t.next = order;
    if (!t.begun && order < t.next) return;  // a request of before: what it has set still holds
    t.begun = true;
    if (order > t.next) t.lost.add(order - t.next, t.newest);
    t.next = std::max(t.next, order + 1);
  }

  void step(const LoggedStep& s) {
    entry(s.thread, s.order);
    if (s.thread >= threads_.size() || s.module >= modules_.size()) return;
    threads_[s.thread].newest = std::max(threads_[s.thread].newest, s.completed);
    Module& module = modules_[s.module];
    module.stepped = true;
    if (module.from && !has_inputs(module, s)) module.from.reset();
    for (const LoggedStep::Output& out : s.outputs)
      if (const auto at = module.topics.find(out.port); at != module.topics.end())
        output(topics_[at->second], out.first, out.count, s.completed);
  }

  /// True if all that it latched was published after the beginning of the file.
  bool has_inputs(const Module& module, const LoggedStep& s) const {
    for (const LoggedStep::Input& in : s.inputs) {
      const auto known = module.topics.find(in.port);
      if (known == module.topics.end() || in.sequences.empty()) continue;
      const Topic& t = topics_[known->second];
      if (t.kept.wanted && (!t.first || static_cast<std::int32_t>(in.sequences.front() - t.first->second) < 0))
        return false;
    }
    return true;
  }

  void output(Topic& t, std::uint32_t first, std::uint32_t count, msg::Time at) {
    skipped(t, first, at);
    t.newest = first + count - 1;
    published(t, first, count, at);
  }

  /// Checks the messages up to `end` whose steps are lost: the messages need not be lost, too.
  void skipped(Topic& t, std::uint32_t end, msg::Time at) {
    constexpr std::uint32_t kMost = 1 << 24;  // more is no gap
    if (!t.newest || t.kept.rate_hz > 0 || end - *t.newest > kMost) return;
    published(t, *t.newest + 1, end - *t.newest - 1, at);
  }

  void published(Topic& t, std::uint32_t first, std::uint32_t count, msg::Time at) {
    if (!t.kept.wanted || (edited_ && at > end_))
      return;  // a batch of steps reaches beyond the end of the cut-out part
    if (t.kept.rate_hz > 0) {
      if (result_.is_part) return;  // not known which ones were due
      for (; count > 0 && due(t.next, t.kept.rate_hz, at); ++first, --count) all_there(t, first, 1, at);
      return;
    }
    const bool any = t.messages.there(first, count) > 0;
    if (!t.begun && result_.is_part) {
      if (!any) return;
      const std::uint32_t begin = t.messages.first_there(first, count);
      count -= begin - first;
      first = begin;
    }
    t.begun |= any;
    all_there(t, first, count, at);
  }

  static void all_there(Topic& t, std::uint32_t first, std::uint32_t count, msg::Time at) {
    if (const std::uint32_t lost = count - t.messages.there(first, count); lost > 0) t.kept.lost.add(lost, at);
  }

  /// Only the totals show losses at the end.
  void judge_ends() {
    const Texts entries = read_metadata(reader_, "sinew.entries");
    for (const auto& [key, total] : entries) {
      const auto index = number_of<std::size_t>(key);
      const auto n = number_of<std::uint64_t>(total);
      if (index >= threads_.size() || edited_) continue;
      Thread& t = threads_[index];
      if (n > t.next) t.lost.add(n - t.next, t.newest);
    }
    for (const auto& [name, newest] : read_metadata(reader_, "sinew.newest"))
      if (const auto known = topic_by_name_.find(name); known != topic_by_name_.end() && !edited_)
        skipped(topics_[known->second], number_of<std::uint32_t>(newest) + 1, end_);
    for (const Thread& t : threads_)
      if (t.lost.count != 0) result_.lost_steps.emplace(t.name, t.lost);
    for (const Topic& t : topics_)
      if (t.kept.lost.count != 0) result_.lost_messages.emplace(t.kept.name, t.kept.lost);
  }

  void give_verdict() {
    for (const Module& m : modules_) {
      std::vector<const TopicKept*> inputs;
      for (const std::size_t t : m.inputs) inputs.push_back(&topics_[t].kept);
      ModuleVerdict v{m.name, reasons(m.source, threads_[m.thread].lost, inputs), {}};
      if (!threads_[m.thread].recorded) v.reasons.assign(1, not_recorded(threads_[m.thread].name));
      const bool later_file = result_.is_part && !edited_;  // its verdict is that of all
      if (later_file)
        v.from = v.reasons.empty() ? m.from : std::nullopt;
      else if (!begin_.empty() && m.stepped)
        begins_at(v, m.from);
      result_.verdict.push_back(std::move(v));
    }
  }

  void compare() {
    if (result_.ended && !edited_) {
      for (const ModuleVerdict& v : result_.verdict) compare(v, result_.said_verdict[v.module]);
      std::map<std::string, std::uint64_t> found;
      for (const auto& [topic, lost] : result_.lost_messages) found[topic] = lost.count;
      for (const auto& [thread, lost] : result_.lost_steps) found["thread " + thread] = lost.count;
      for (const auto& [what, said] : result_.said_losses) found.emplace(what, 0);
      for (const auto& [what, count] : found) compare(what, count);
    }
    for (const auto& [topic, other] : result_.other_pixels)
      result_.differences.push_back(topic + ": " + to_text(other, "images") + " have other pixels than were seen");
  }

  void compare(const ModuleVerdict& found, const std::string& said) {
    const std::string text = to_text(found);
    const auto here = reasons_in(text), there = reasons_in(said);
    // A later file of a split recording reports the losses of all files.
    const bool same = result_.is_part && !found.reasons.empty()
                          ? std::includes(there.begin(), there.end(), here.begin(), here.end())
                          : result_.is_part || here == there;
    if (!same)
      result_.differences.push_back("module " + found.module + ": the file says \"" + said + "\", its contents \"" +
                                    text + "\"");
  }

  void compare(const std::string& what, std::uint64_t missing) {
    const auto said = result_.said_losses.find(what);
    const auto told = said == result_.said_losses.end() ? 0 : number_of<std::uint64_t>(said->second);
    if (missing > told || (missing < told && !result_.is_part))
      result_.differences.push_back(what + ": " + std::to_string(missing) + " are missing, the file says " +
                                    std::to_string(told));
  }

  Reader& reader_;
  RunReview result_;
  Texts begin_;  // of a file that begins midway
  bool edited_ = false;
  msg::Time end_;  // of the newest message
  std::int64_t unix_ns_ = 0;
  std::vector<Topic> topics_;
  std::map<std::string, std::size_t> topic_by_name_;
  std::vector<Module> modules_;
  std::vector<Thread> threads_;
};

}  // namespace

RunReview review(Reader& reader) { return Review(reader).run(); }

}  // namespace sinew::record
