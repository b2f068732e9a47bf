#include "record/run/recorded_run.hpp"

#include <algorithm>
#include <cstdlib>

#include "math/hash.hpp"
#include "msg/ros2msg.hpp"
#include "record/ros2_schema.hpp"
#include "record/run/run_messages.hpp"
#include "record/run/verdict.hpp"

namespace sinew::record {
namespace {

using PortKind = rt::Declaration::PortKind;

std::int64_t unix_ns_of(const Texts& run) {
  const auto said = run.find("unix_ns");
  return said == run.end() ? 0 : std::atoll(said->second.c_str());
}

}  // namespace

std::uint64_t recorded_start(Reader& reader) {
  std::uint64_t start = ~std::uint64_t{0};
  for (const ChunkIndex& chunk : reader.chunks()) start = std::min(start, chunk.start_time);
  if (const auto& all = reader.statistics()) start = all->start_time;
  const Texts begin = read_metadata(reader, kBeginName);
  if (const auto at = begin.find("at_ns"); at != begin.end()) {
    const auto unix_ns = static_cast<std::uint64_t>(unix_ns_of(read_metadata(reader, "sinew.run")));
    start = std::max(start, static_cast<std::uint64_t>(std::atoll(at->second.c_str())) + unix_ns);
  }
  return start == ~std::uint64_t{0} ? 0 : start;
}

RecordedTime recorded_time(Reader& reader) {
  const auto& all = reader.statistics();
  if (!all) return {};
  const auto unix_ns = static_cast<std::uint64_t>(unix_ns_of(read_metadata(reader, "sinew.run")));
  const std::uint64_t start = std::min(recorded_start(reader), all->end_time);
  return {{static_cast<std::int64_t>(start - unix_ns)}, rt::Duration{static_cast<std::int64_t>(all->end_time - start)}};
}

RecordedRun::RecordedRun(Reader& reader, const rt::Graph& graph)
    : reader_(reader), graph_(graph), wanted_(graph.topics().size()), keep_(graph.topics().size(), 1) {
  for (const rt::GraphTopic& t : graph.topics()) stores_.emplace_back(*t.type);
}

hal::Status RecordedRun::open(std::string& why) {
  const auto fail = [&why](std::string words) -> hal::Status {
    why = std::move(words);
    return hal::Error{hal::Errc::bad_data, "replay"};
  };
  const Texts run = read_metadata(reader_, "sinew.run"), modules = read_metadata(reader_, "sinew.modules");
  if (!run.contains("unix_ns") || modules.empty()) return fail("the file holds no run of Sinew");
  unix_ns_ = unix_ns_of(run);
  std::size_t m = 0;
  for (const auto& [index, name] : modules) {
    const std::string ours = m < graph_.modules().size() ? graph_.modules()[m].spec.name : "none";
    if (ours != name) return fail("module " + index + " of the run is " + name + ", of the robot " + ours);
    ++m;
  }
  if (m != graph_.modules().size()) return fail("the robot has more modules than the run");
  return {};
}

void RecordedRun::need(std::uint32_t module) {
  const rt::GraphModule& m = graph_.modules()[module];
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

void RecordedRun::begin() {
  find_channels();
  reading_.emplace(reader_.messages({.topics = names_}));
}

void RecordedRun::find_channels() {
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

/// Bytes of another version of a type may fit this version and mean something else, so versions are compared; but for
/// their remarks, which people improve.
bool RecordedRun::same_type(const Channel& channel, const msg::TypeInfo& type) {
  const auto schema = reader_.schemas().find(channel.schema);
  const std::string ours = type.has_bulk() ? std::string(image_schema().text) : msg::ros2msg_schema(type);
  if (schema != reader_.schemas().end() && same_definition(schema->second.data, ours)) return true;
  problems_.push_back({ProblemKind::bad_record, 0,
                       "topic " + channel.topic + ": recorded with another version of " + std::string(type.name) +
                           "; its messages are not used"});
  return false;
}

bool RecordedRun::next(std::vector<LogItem>& items) {
  items.clear();
  if (++rounds_ % 64 == 0) forget(stores_);
  read_until_due();
  if (items_.empty()) return false;
  give(items);
  return true;
}

/// An item may go out when everything that was visible by its time is known.
void RecordedRun::read_until_due() {
  Message m;
  while (!ended_ && (items_.empty() || items_.top().due >= now_)) {
    const Next next = reading_->next(m);
    if (next == Next::end) {
      ended_ = true;
    } else if (next == Next::problem) {
      problems_.push_back(reading_->problem());
    } else {
      const rt::Time t = robot_time(m.stamps.log_time);
      now_ = std::max(now_, t);
      take(m, t);
    }
  }
}

void RecordedRun::give(std::vector<LogItem>& items) {
  const rt::Time due = items_.top().due;
  for (; !items_.empty() && items_.top().due == due; items_.pop())
    items.push_back(std::move(const_cast<LogItem&>(items_.top())));  // the pop follows at once
  for (const LogItem& item : items) {
    if (!item.step) continue;
    earliest_.erase(earliest_.find(item.step->now.ns));
    for (const auto& in : item.step->inputs)
      if (auto waits = waiting_.find({item.step->module, in.port}); waits != waiting_.end() && !in.sequences.empty())
        waits->second = in.sequences.back() + 1;
  }
}

void RecordedRun::take(const Message& m, rt::Time t) {
  const auto known = channels_.find(m.channel->id);
  if (known == channels_.end()) return;  // another channel of that name
  const auto [what, topic] = known->second;
  bool good = true;
  if (what == What::steps) {
    good = decode(m.data, batch_);
    for (LoggedStep& s : batch_) good = push({s.completed, s.thread, s.order, std::move(s), {}}) && good;
  } else if (what == What::requests) {
    LoggedRequest r;
    good = decode(m.data, r);
    if (good) good = push({r.now, r.request.thread, r.order, {}, r});
  } else if (what == What::states) {  // the log gives its place
    LoggedState state;
    std::uint64_t layout = 0;
    good = decode(m.data, state, layout) && state.thread < graph_.threads().size();
    if (good) items_.push({state.completed, state.thread, state.order, {}, {}});
  } else if (what == What::message) {
    good = stores_[topic].add(m.stamps.sequence, t, m.data);
  } else if (what == What::image) {
    good = stores_[topic].add_pixels(m.stamps.sequence, t, m.data);
  } else {
    good = stores_[topic].add_head(m.stamps.sequence, t, m.data);
    if (good && pictures_) draw(topic, m, t);
  }
  if (!good) problems_.push_back({ProblemKind::bad_record, 0, "message of " + m.channel->topic});
}

void RecordedRun::draw(std::uint32_t topic, const Message& m, rt::Time t) {
  ImageHead head;
  if (!decode(m.data, head) || head.has_pixels) return;
  const std::span<const std::byte> pixels = pictures_->pixels(topic, head);
  const bool same = !pixels.empty() && math::hash64(pixels.data(), pixels.size()) == head.pixel_hash;
  ++(same ? drawn_.same : pixels.empty() ? drawn_.missing : drawn_.differing);
  if (same) return stores_[topic].set_pixels(m.stamps.sequence, t, pixels);
  if (!drawn_.first_wrong.empty()) return;
  drawn_.first_wrong = graph_.topics()[topic].name + ", image " + std::to_string(head.frame_number) + " at " +
                       seconds_text(t) + (pixels.empty() ? ": cannot be drawn" : ": other pixels than were seen");
}

bool RecordedRun::push(LogItem item) {
  const std::uint32_t module = item.request ? item.request->request.module : item.step->module;
  if (item.thread >= graph_.threads().size() || module >= graph_.modules().size()) return false;
  if (item.step) earliest_.insert(item.step->now.ns);
  items_.push(std::move(item));
  return true;
}

void RecordedRun::forget(std::span<MessageStore> stores) const {
  const rt::Time horizon{earliest_.empty() ? now_.ns : std::min(*earliest_.begin(), now_.ns)};
  for (std::uint32_t topic = 0; topic < stores.size(); ++topic) {
    std::optional<std::uint32_t> from;
    bool none_yet = false;
    for (const auto& [port, next] : waiting_) {
      if (graph_.modules()[port.first].topic[port.second] != topic) continue;
      none_yet |= !next;
      if (next && (!from || static_cast<std::int32_t>(*next - *from) < 0)) from = next;
    }
    if (!none_yet) stores[topic].forget(horizon, keep_[topic] + 1, from);
  }
}

}  // namespace sinew::record
