#include "record/run/playback.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "msg/cdr.hpp"
#include "msg/image.hpp"
#include "record/backward_windows.hpp"
#include "record/run/recorded_run.hpp"
#include "record/run/ros2_convert.hpp"
#include "record/run/run_messages.hpp"

namespace sinew::record {
namespace {

using namespace std::chrono_literals;

constexpr std::int64_t kLongest_ns = std::int64_t{100} * 366 * 86'400 * 1'000'000'000;
constexpr std::int64_t kFarthest_ns = INT64_MAX / 2;  // of the robot's clock
constexpr std::size_t kMostTopics = 1024;
constexpr std::uint64_t kMostBytes = 1ull << 30, kMostBytesOfTopic = 64ull << 20;
constexpr std::uint32_t kLeastKept = 5, kMostKept = 100'000;
constexpr double kKept_s = 0.5;
constexpr int kAtOnce = 256;            // messages between two looks at the requests
constexpr hal::Duration kRest = 500us;  // at least, between two groups of messages
constexpr hal::Duration kLate = 100ms;  // later than that, the rest of the file is played later
constexpr hal::Duration kRound = 10ms;  // at least, of a loop
constexpr std::size_t kKeptImages = 2;  // parts of images that wait for their other part
constexpr std::size_t kMostProblems = 100;

std::string_view module_of(std::string_view topic) { return topic.substr(0, topic.rfind('.')); }

std::uint32_t history_of(const RecordedTopic& topic, const PlaybackOptions& options) {
  const auto said = options.history.find(topic.name);
  if (said != options.history.end() && said->second > 0) return std::min(said->second, kMostKept);
  const double kept = std::ceil(kKept_s * topic.rate_hz) + 1;
  return kept < kMostKept ? std::max(kLeastKept, static_cast<std::uint32_t>(kept)) : kMostKept;
}

/// Times from a file may be any numbers: the difference wraps instead of overflowing.
rt::Duration wrapped_difference(rt::Time a, rt::Time b) {
  return rt::Duration{static_cast<std::int64_t>(static_cast<std::uint64_t>(a.ns) - static_cast<std::uint64_t>(b.ns))};
}

}  // namespace

/// The newest message of a topic up to an instant, in the bytes of the file.
struct Playback::Found {
  bool is_found = false;
  Stamps stamps;
  std::vector<std::byte> data, head;
  // Of an image, the last one of each part.
  Stamps pixels_stamps, head_stamps;
  std::vector<std::byte> last_pixels, last_head;
};

Playback::Playback(Reader& reader, std::vector<RecordedTopic> topics, PlaybackOptions options, hal::Os& os)
    : reader_(reader),
      topics_(std::move(topics)),
      options_(std::move(options)),
      os_(os),
      places_(topics_.size()),
      stats_(topics_.size()) {}

hal::Result<std::unique_ptr<Playback>> Playback::open(Reader& reader, std::vector<RecordedTopic> topics,
                                                      PlaybackOptions options, hal::Os& os) {
  std::unique_ptr<Playback> playback(new Playback(reader, std::move(topics), std::move(options), os));
  if (auto found = playback->find_time(); !found) return found.error();
  if (auto made = playback->make_segment(); !made) return made.error();
  return playback;
}

hal::Status Playback::find_time() {
  unix_ns_ = unix_ns_of(reader_);
  const auto& all = reader_.statistics();
  if (!all || all->messages == 0) return hal::Error{hal::Errc::bad_data, "the file has no messages"};
  begin_ = std::max(options_.from, recorded_start(reader_));
  const std::uint64_t end = std::min(options_.until, all->end_time);
  if (end < begin_) return hal::Error{hal::Errc::bad_data, "the file ends before it begins"};
  if (end - begin_ > static_cast<std::uint64_t>(kLongest_ns))
    return hal::Error{hal::Errc::bad_data, "its messages are more than 100 years apart"};
  length_ = offset_of(end);
  shown_.speed = std::clamp(options_.speed, kSlowest, kFastest);
  shown_.loop = options_.loop && length_ > 0;
  shown_.state = options_.paused ? State::paused : State::playing;
  shown_.begin = robot_time(begin_), shown_.end = robot_time(end);
  if (std::min(shown_.begin.ns, shown_.end.ns) < -kFarthest_ns ||
      std::max(shown_.begin.ns, shown_.end.ns) > kFarthest_ns)
    return hal::Error{hal::Errc::bad_data, "its times are no times of a clock"};
  shown_.problems = reader_.problems();
  if (shown_.problems.size() > kMostProblems) shown_.problems.resize(kMostProblems);
  return {};
}

hal::Status Playback::make_segment() {
  if (topics_.size() > kMostTopics) return hal::Error{hal::Errc::bad_data, "the file has more than 1024 topics"};
  rt::SegmentPlan plan;
  std::map<std::string_view, std::pair<rt::WriterId, std::uint32_t>> writers;  // by module; outputs so far
  for (std::size_t t = 0; t < topics_.size(); ++t) {
    const RecordedTopic& topic = topics_[t];
    const std::string_view module = module_of(topic.name);
    auto writer = writers.find(module);
    if (writer == writers.end() || writer->second.second == rt::kMaxOutputs)
      writer = writers.insert_or_assign(module, std::pair(plan.add_writer(std::string(module)), 0U)).first;
    const std::uint64_t slot = sizeof(rt::SlotHeader) + topic.type->size + topic.image_bytes;
    const auto most = static_cast<std::uint32_t>(std::max<std::uint64_t>(kMostBytesOfTopic / slot, 1));
    rt::TopicPlan about{.name = topic.name, .type = topic.type, .bulk_bytes = topic.image_bytes};
    about.history = std::min(history_of(topic, options_), most);
    places_[t] = {plan.add_topic(writer->second.first, about), writer->second.first, writer->second.second++};
    ways_[topic.name] = {t, topic.type->has_bulk() ? Way::What::pixels : Way::What::message};
    if (topic.type->has_bulk()) ways_[topic.name + std::string(kHeadSuffix)] = {t, Way::What::head};
    stores_.emplace_back(*topic.type);
  }
  for (const std::string& other : options_.other_topics) ways_[other] = {0, Way::What::other};
  if (plan.bytes() > kMostBytes) return hal::Error{hal::Errc::out_of_memory, "its topics need more than 1 GiB"};
  auto memory = os_.shared_memory("sinew playback", plan.bytes());
  if (!memory) return memory.error();
  memory_ = std::move(*memory);
  segment_ = std::make_unique<rt::Segment>(plan, *memory_);
  for (rt::WriterId w = 0; w < segment_->header().writer_count; ++w)
    commits_.push_back(std::make_unique<rt::Commit>(*segment_, w));
  return {};
}

hal::Status Playback::start() {
  Query query{.from = begin_, .until = begin_ + static_cast<std::uint64_t>(length_)};
  for (const auto& way : ways_) query.topics.push_back(way.first);
  messages_.emplace(reader_.messages(query));
  auto thread = os_.start_thread({.name = "playback", .cpus = {}}, [this] { run(); });
  if (!thread) return thread.error();
  thread_ = std::move(*thread);
  return {};
}

Playback::~Playback() {
  end_.store(true, std::memory_order_relaxed);
  changed_.fetch_add(1, std::memory_order_release);
  os_.wake(changed_);
  thread_.reset();
}

// ---- requests

Playback::Status Playback::status() const {
  const hal::Time now = os_.now();
  const std::lock_guard lock(mutex_);
  Status status = shown_;
  status.now = {static_cast<std::int64_t>(static_cast<std::uint64_t>(shown_.begin.ns) +
                                          static_cast<std::uint64_t>(position(now)))};
  return status;
}

std::uint64_t Playback::done() const {
  const std::lock_guard lock(mutex_);
  return done_;
}

std::uint64_t Playback::ask(const Command& command) {
  std::uint64_t number = 0;
  {
    const std::lock_guard lock(mutex_);
    commands_.push_back(command);
    number = ++asked_;
  }
  changed_.fetch_add(1, std::memory_order_release);
  os_.wake(changed_);
  return number;
}

std::uint64_t Playback::play() { return ask({.kind = Command::Kind::play}); }
std::uint64_t Playback::pause() { return ask({.kind = Command::Kind::pause}); }
std::uint64_t Playback::seek(rt::Time to) {
  const rt::Time begin = robot_time(begin_), end = robot_time(begin_ + static_cast<std::uint64_t>(length_));
  const std::int64_t offset = to <= begin ? 0 : to >= end ? length_ : (to - begin).count();
  return ask({.kind = Command::Kind::seek, .offset = offset});
}
std::uint64_t Playback::step(std::uint64_t messages) { return ask({.kind = Command::Kind::step, .count = messages}); }
std::uint64_t Playback::step_to(std::size_t topic) { return ask({.kind = Command::Kind::step_to, .count = topic}); }
std::uint64_t Playback::set_speed(double speed) {
  return ask({.kind = Command::Kind::speed, .speed = std::clamp(speed, kSlowest, kFastest)});
}

// ---- on the playback's thread

void Playback::run() {
  go_to(0, false);
  round_begun_ = os_.now();
  anchor(0, shown_.state);
  while (!ends()) {
    const std::uint32_t before = changed_.load(std::memory_order_acquire);
    take_commands();
    hal::Time wake = hal::kNever;
    if (goal_) {
      step_on();
      continue;  // the next request may wait for this one
    }
    if (shown_.state == State::playing) wake = play_on();
    if (!ends()) os_.wait(changed_, before, wake);
  }
}

void Playback::take_commands() {
  while (!ends()) {
    Command command;
    {
      const std::lock_guard lock(mutex_);
      // A step ends before the next one begins, unless something else is asked for behind it.
      if (commands_.empty() || (goal_ && std::all_of(commands_.begin(), commands_.end(), &Command::is_step))) return;
      command = commands_.front();
      commands_.pop_front();
      done_ = taken_++;  // a step that is under way ends here
    }
    goal_.reset();
    carry_out(command);
    const std::lock_guard lock(mutex_);
    if (!goal_) done_ = taken_;
  }
}

void Playback::carry_out(const Command& command) {
  using Kind = Command::Kind;
  switch (command.kind) {
    case Kind::play:
      if (shown_.state == State::ended) return begin_again();
      if (shown_.state == State::paused) anchor(anchor_offset_, State::playing);
      return;
    case Kind::pause:
      return halt();
    case Kind::seek: {
      const State state = shown_.state == State::playing ? State::playing : State::paused;
      go_to(command.offset, true);
      return anchor(command.offset, state);
    }
    case Kind::step:
    case Kind::step_to:
      halt();
      if (shown_.state == State::ended) return;
      goal_ = Goal{0, std::nullopt};
      if (command.kind == Kind::step)
        goal_->messages = std::max<std::uint64_t>(command.count, 1);
      else
        goal_->topic = static_cast<std::size_t>(command.count);
      return;
    case Kind::speed: {
      anchor(position(os_.now()), shown_.state);
      const std::lock_guard lock(mutex_);
      shown_.speed = command.speed;
    }
  }
}

/// What was due is published; the next message is later than the present instant.
void Playback::halt() {
  if (shown_.state != State::playing) return;
  std::int64_t at = position(os_.now());
  if (fetch()) at = std::max(anchor_offset_, std::min(at, offset_of(next_.stamps.log_time) - 1));
  anchor(at, State::paused);
}

void Playback::begin_again() {
  go_to(0, false);
  round_begun_ = os_.now();
  anchor(0, State::playing);
}

/// Answers when there is more to do.
hal::Time Playback::play_on() {
  for (int i = 0; i < kAtOnce; ++i) {
    if (!fetch()) return at_end();
    const std::int64_t offset = offset_of(next_.stamps.log_time);
    const hal::Time now = os_.now(), then = due(offset);
    if (then > now) return std::max(then, now + kRest);
    if (now - then > kLate) anchor(offset, State::playing);  // the disk or the machine is too slow: nothing is left out
    take(next_);
    has_next_ = false;
  }
  return os_.now();
}

hal::Time Playback::at_end() {
  hal::Time then = due(length_);
  if (shown_.loop) then = std::max(then, round_begun_ + kRound);
  const hal::Time now = os_.now();
  if (now < then) return then;
  if (!shown_.loop) {
    anchor(length_, State::ended);
    return hal::kNever;
  }
  begin_again();
  const std::lock_guard lock(mutex_);
  ++shown_.rounds;
  return now;
}

void Playback::step_on() {
  for (int i = 0; i < kAtOnce && goal_; ++i) {
    const bool fetched = fetch();
    if (!fetched) {
      anchor(length_, State::ended);
      goal_.reset();
    } else {
      const std::int64_t offset = offset_of(next_.stamps.log_time);
      const auto topic = take(next_);
      has_next_ = false;
      anchor(offset, State::paused);
      if (topic && (goal_->topic ? *topic == *goal_->topic : --goal_->messages == 0)) goal_.reset();
    }
  }
  if (goal_) return;
  const std::lock_guard lock(mutex_);
  done_ = taken_;
}

/// From now on messages behind `offset` are fetched; at `offset` itself, too, unless it is `included` in what is shown
/// at once.
void Playback::go_to(std::int64_t offset, bool included) {
  const std::uint64_t at = begin_ + static_cast<std::uint64_t>(offset);
  if (included || at > 0) show_newest(included ? at : at - 1);
  for (MessageStore& store : stores_) store.forget(rt::Time{INT64_MAX}, 0, std::nullopt);
  has_next_ = false;
  exhausted_ = offset == length_ && included;
  if (!exhausted_) messages_->seek(included ? at + 1 : at);
}

/// Publishes the newest message of each topic up to then, in the order of time.
void Playback::show_newest(std::uint64_t until) {
  std::vector<Found> found(topics_.size());
  BackwardWindows windows(reader_, until);
  while (!ends()) {
    std::vector<std::string> missing, heads;
    for (std::size_t t = 0; t < topics_.size(); ++t) {
      if (found[t].is_found) continue;
      missing.push_back(topics_[t].name);
      if (topics_[t].type->has_bulk()) heads.push_back(topics_[t].name + std::string(kHeadSuffix));
    }
    auto window = windows.next(missing);
    if (!window) break;
    window->topics.insert(window->topics.end(), heads.begin(), heads.end());
    search(*window, found);
  }
  std::vector<std::size_t> order;
  for (std::size_t t = 0; t < found.size(); ++t)
    if (found[t].is_found) order.push_back(t);
  std::stable_sort(order.begin(), order.end(),
                   [&](auto a, auto b) { return found[a].stamps.log_time < found[b].stamps.log_time; });
  for (const std::size_t t : order) {
    const Found& f = found[t];
    const bool image = topics_[t].type->has_bulk();
    if (image) take({t, Way::What::head}, f.stamps, f.head);
    take({t, image ? Way::What::pixels : Way::What::message}, f.stamps, f.data);
  }
}

void Playback::search(const Query& window, std::vector<Found>& found) {
  MessageReader messages = reader_.messages(window);
  Message m;
  for (Next next; !ends() && (next = messages.next(m)) != Next::end;) {
    if (next == Next::problem) {
      note(messages.problem());
      continue;
    }
    const auto way = ways_.find(m.channel->topic);
    if (way == ways_.end() || way->second.what == Way::What::other) continue;
    Found& f = found[way->second.topic];
    const auto keep = [&m](Stamps& stamps, std::vector<std::byte>& data) {
      stamps = m.stamps;
      data.assign(m.data.begin(), m.data.end());
    };
    if (way->second.what == Way::What::message) {
      f.is_found = true;
      keep(f.stamps, f.data);
      continue;
    }
    if (way->second.what == Way::What::head)
      keep(f.head_stamps, f.last_head);
    else
      keep(f.pixels_stamps, f.last_pixels);
    if (f.last_head.empty() || f.last_pixels.empty() || f.head_stamps.sequence != f.pixels_stamps.sequence) continue;
    f.is_found = true;
    f.stamps = m.stamps;
    f.head.swap(f.last_head);
    f.data.swap(f.last_pixels);
    f.last_head.clear(), f.last_pixels.clear();
  }
}

/// False: there is no further message.
bool Playback::fetch() {
  while (!has_next_ && !exhausted_ && !ends()) {
    const Next got = messages_->next(next_);
    if (got == Next::problem)
      note(messages_->problem());
    else if (got == Next::message)
      has_next_ = true;
    else
      exhausted_ = true;
  }
  return has_next_;
}

/// The topic that got a message.
std::optional<std::size_t> Playback::take(const Message& m) {
  const auto way = ways_.find(m.channel->topic);
  if (way == ways_.end()) return std::nullopt;
  if (way->second.what != Way::What::other) return take(way->second, m.stamps, m.data);
  if (options_.other) options_.other(m);
  return std::nullopt;
}

std::optional<std::size_t> Playback::take(const Way& way, const Stamps& stamps, std::span<const std::byte> data) {
  bool fits = false, published = false, without_pixels = false;
  if (way.what == Way::What::message) {
    fits = published = publish(way.topic, data, stamps.log_time);
  } else {
    MessageStore& store = stores_[way.topic];
    const rt::Time at = robot_time(stamps.log_time);
    fits = way.what == Way::What::head ? store.add_head(stamps.sequence, at, data)
                                       : store.add_pixels(stamps.sequence, at, data);
    const MessageStore::Entry* entry = fits ? store.find(stamps.sequence) : nullptr;
    if (entry && entry->whole) fits = published = publish_image(way.topic, *entry, stamps.log_time);
    without_pixels = entry && way.what == Way::What::head && !entry->head->has_pixels;
    store.forget(rt::Time{INT64_MAX}, kKeptImages, std::nullopt);
  }
  const std::lock_guard lock(mutex_);
  shown_.messages += published ? 1 : 0;
  shown_.unfit += fits ? 0 : 1;
  shown_.without_pixels += without_pixels ? 1 : 0;
  return published ? std::optional(way.topic) : std::nullopt;
}

bool Playback::publish(std::size_t topic, std::span<const std::byte> cdr, std::uint64_t log_time) {
  rt::Commit& writer = *commits_[places_[topic].writer];
  void* const message = writer.try_loan(places_[topic].output);
  if (!msg::cdr_decode(*topics_[topic].type, {reinterpret_cast<const std::uint8_t*>(cdr.data()), cdr.size()},
                       message)) {
    writer.cancel(places_[topic].output);
    return false;
  }
  commit(topic, log_time);
  return true;
}

bool Playback::publish_image(std::size_t topic, const MessageStore::Entry& entry, std::uint64_t log_time) {
  rt::Commit& writer = *commits_[places_[topic].writer];
  const auto& recorded = *static_cast<const msg::Image*>(entry.message());
  const std::uint32_t used = recorded.bulk_used();
  auto& image = *static_cast<msg::Image*>(writer.try_loan(places_[topic].output));
  const std::uint32_t capacity = image.capacity_bytes;
  if (used <= capacity) {
    std::memcpy(static_cast<void*>(&image), &recorded, topics_[topic].type->size + used);
    image.capacity_bytes = capacity;  // the slot's own
  }
  if (used > capacity || image.bulk_used() != used) {
    writer.cancel(places_[topic].output);
    return false;
  }
  commit(topic, log_time);
  return true;
}

void Playback::commit(std::size_t topic, std::uint64_t log_time) {
  const Place& place = places_[topic];
  rt::Commit& writer = *commits_[place.writer];
  rt::CommitInfo info;
  info.now = robot_time(log_time);
  writer.commit(info);
  const rt::SlotHeader& slot = *writer.committed(place.output).back();
  rt::TopicStats& stats = stats_[topic];
  stats.messages.add();
  stats.last_stamp_ns.set(slot.stamp.ns);
  stats.last_published_ns.set(slot.published.ns);
  stats.age.add(wrapped_difference(slot.published, slot.stamp));
}

void Playback::note(const FileProblem& problem) {
  const std::lock_guard lock(mutex_);
  const bool known = std::any_of(shown_.problems.begin(), shown_.problems.end(), [&](const FileProblem& p) {
    return p.offset == problem.offset && p.kind == problem.kind;
  });
  if (!known && shown_.problems.size() < kMostProblems) shown_.problems.push_back(problem);
}

/// At most the end.
std::int64_t Playback::position(hal::Time now) const {
  if (shown_.state != State::playing) return anchor_offset_;
  const double gone_ns = static_cast<double>(std::max<std::int64_t>((now - anchor_at_).count(), 0)) * shown_.speed;
  const std::int64_t left = length_ - anchor_offset_;
  return gone_ns >= static_cast<double>(left) ? length_ : anchor_offset_ + static_cast<std::int64_t>(gone_ns);
}

hal::Time Playback::due(std::int64_t offset) const {
  constexpr double kFar_ns = 1e18;  // 31 years
  const double until_ns = static_cast<double>(offset - anchor_offset_) / shown_.speed;
  return anchor_at_ + hal::Duration{static_cast<std::int64_t>(std::min(until_ns, kFar_ns))};
}

void Playback::anchor(std::int64_t offset, State state) {
  const hal::Time now = os_.now();
  const std::lock_guard lock(mutex_);
  anchor_offset_ = offset;
  anchor_at_ = now;
  shown_.state = state;
}

}  // namespace sinew::record
