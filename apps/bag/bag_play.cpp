// bag play: a robot whose modules publish the recorded messages again.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <optional>
#include <set>

#include "apps/bag/bag_options.hpp"
#include "apps/command/command.hpp"
#include "apps/command/json.hpp"
#include "apps/run/run_setup.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"
#include "hal/scaled_os.hpp"
#include "hal/silent_board.hpp"
#include "record/run/message_store.hpp"
#include "record/run/player.hpp"
#include "record/run/recorded_run.hpp"
#include "record/run/recorded_topics.hpp"
#include "record/run/truth.hpp"
#include "rt/exec/real_time_executor.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;

constexpr rt::Duration kAhead = 100ms;   // messages are handed over so long before they are due
constexpr rt::Duration kStarts = 200ms;  // until the first message, so that no reader misses it
constexpr rt::Duration kPeriod = 1ms;
constexpr std::string_view kThread = "play";

/// Where messages of a channel go.
struct Way {
  record::Player* player = nullptr;
  std::uint32_t topic = 0;  // of the player
  record::MessageStore* store = nullptr;
  bool is_head = false;
};

class Play {
 public:
  Play(const BagPlayOptions& options, record::Reader& reader) : options_(options), reader_(reader) {}

  int run(const record::Query& query) {
    find_topics();
    if (found_.empty()) return fail(options_.file + ": no topic of a run of Sinew in it");
    RunOptions run;
    run.robot = options_.file;
    run.name = options_.name;
    run.rate = options_.rate;
    make_graph();
    if (!take_name(prepared_, run)) return kNotBegun;
    hal::SilentBoard board;
    // The clock is the recorded robot's, as are the stamps in the messages.
    const hal::Time first = robot_time(std::max(query.from, record::recorded_start(reader_)));
    hal::ScaledOs os(hal::system_os(), options_.rate, hal::system_os().now(), first + -kStarts);
    rt::ConfigureOptions how;
    how.os = &os;
    if (!configure(prepared_, board, how)) return kNotBegun;
    find_ways();
    rt::RealTimeExecutor executor(*prepared_.graph, os, real_time_options(run));
    if (const auto started = executor.start(); !started) return fail(started.error().where);
    const auto socket = open_socket(prepared_, run, executor.runner(), nullptr, os, &hal::request_stop);
    const hal::Time begin = os.now();
    bool good = feed(query, rt::Duration{}, os);
    while (options_.loop && good && !hal::stop_requested()) good = feed(query, os.now() + kStarts - first, os);
    while (!hal::stop_requested() && !idle()) os.sleep_until(os.now() + kPeriod);
    if (!hal::stop_requested()) os.sleep_until(os.now() + 2 * kPeriod);  // so that readers see the last messages
    executor.stop();
    return tell(msg::seconds(os.now() - begin), good);
  }

 private:
  /// Those of a robot, and of them those that were asked for.
  void find_topics() {
    for (record::RecordedTopic& topic : record::recorded_topics(reader_).known) {
      const bool of_module = !rt::split_topic(topic.name).second.empty() || topic.name == record::kTruthTopic;
      const auto& asked = options_.what.topics;
      if (of_module && (asked.empty() || std::find(asked.begin(), asked.end(), topic.name) != asked.end()))
        found_.push_back(std::move(topic));
    }
  }

  void make_graph() {
    prepared_.robot.path = options_.file;
    rt::GraphSpec& spec = prepared_.robot.graph;
    const auto run = read_metadata(reader_, "sinew.run");
    const auto robot = run.find("robot");
    spec.robot = robot == run.end() ? "recording" : robot->second;
    if (const auto offset = run.find("unix_ns"); offset != run.end())
      std::from_chars(offset->second.data(), offset->second.data() + offset->second.size(), unix_ns_);
    spec.board = "none";
    rt::ThreadSpec thread;
    thread.name = kThread;
    thread.period = kPeriod;
    std::map<std::string, std::vector<record::Player::Topic>> by_module;
    for (const record::RecordedTopic& f : found_) {
      const auto [module, port] = rt::split_topic(f.name);
      by_module[std::string(module)].push_back({std::string(port), f.type, f.image_bytes});
      if (f.image_bytes > 0) spec.topics.push_back({.name = f.name, .image_bytes = f.image_bytes});
    }
    for (const auto& entry : by_module) {
      const std::string& name = entry.first;
      rt::ModuleSpec module;
      module.name = name;
      module.type = "record::Player of " + name;
      spec.modules.push_back(module);
      thread.order.push_back({name, 0});
      prepared_.types.add(module.type, [topics = entry.second, &player = players_[name]] {
        auto made = std::make_unique<record::Player>(topics);
        player = made.get();
        return made;
      });
    }
    spec.threads.push_back(thread);
    prepared_.graph = std::make_unique<rt::Graph>(spec, prepared_.types);
  }

  void find_ways() {
    for (const record::RecordedTopic& f : found_) {
      const auto [module, port] = rt::split_topic(f.name);
      record::Player& player = *players_.at(std::string(module));
      stores_.push_back(std::make_unique<record::MessageStore>(*f.type));
      Way way{&player, 0, stores_.back().get()};
      while (player.topics()[way.topic].port != port) ++way.topic;
      ways_[f.name] = way;
      way.is_head = true;
      if (f.type->has_bulk()) ways_[f.name + std::string(record::kHeadSuffix)] = way;
    }
  }

  /// Publishes the whole file once, `later` than it was recorded. False: part of it could not be read.
  bool feed(record::Query query, rt::Duration later, hal::Os& os) {
    query.topics.clear();
    for (const auto& way : ways_) query.topics.push_back(way.first);
    for (const auto& store : stores_) store->forget(rt::Time{INT64_MAX}, 0, std::nullopt);
    return each_message(reader_, query, [&](const record::Message& m) {
      const hal::Time due = robot_time(m.stamps.log_time) + later;
      for (hal::Time now = os.now(); due - now > kAhead && !hal::stop_requested(); now = os.now())
        os.sleep_until(std::min(due - kAhead, now + 10 * kAhead));
      say(m, due, os);
      return true;
    });
  }

  void say(const record::Message& m, hal::Time due, hal::Os& os) {
    const Way& way = ways_.at(m.channel->topic);
    const bool images = way.store->type().has_bulk();
    bool fits = false;
    if (!images)
      fits = way.store->add(m.stamps.sequence, due, m.data);
    else if (way.is_head)
      fits = way.store->add_head(m.stamps.sequence, due, m.data);
    else
      fits = way.store->add_pixels(m.stamps.sequence, due, m.data);
    const auto* entry = fits ? way.store->find(m.stamps.sequence) : nullptr;
    const std::pair half(way.store, m.stamps.sequence);
    if (entry && !entry->whole) {
      halves_.insert(half);  // until its other half comes
      return;
    }
    halves_.erase(half);
    auto handed = record::Player::Handed::too_large;
    while (entry && (handed = way.player->hand(way.topic, due, entry->message())) == record::Player::Handed::no_room &&
           !hal::stop_requested())
      os.sleep_until(os.now() + kPeriod);
    ++(handed == record::Player::Handed::yes ? said_ : unfit_);
    way.store->forget(rt::Time{INT64_MAX}, 2, std::nullopt);
  }

  hal::Time robot_time(std::uint64_t log_time) const {
    return hal::Time{static_cast<std::int64_t>(log_time - static_cast<std::uint64_t>(unix_ns_))};
  }

  bool idle() const {
    return std::all_of(players_.begin(), players_.end(), [](const auto& p) { return p.second->idle(); });
  }

  int tell(double took_s, bool good) const {
    if (options_.json)
      std::printf("%s", to_line({{"file", options_.file},
                                 {"robot", prepared_.graph->spec().robot},
                                 {"topics", found_.size()},
                                 {"messages", said_},
                                 {"without_pixels", halves_.size()},
                                 {"not_played", unfit_},
                                 {"seconds", took_s}})
                            .c_str());
    else
      std::printf("%s\n",
                  fmt::format("{}: {} messages of {} topics in {:.2f} s{}{}", options_.file, said_, found_.size(),
                              took_s, halves_.empty() ? "" : fmt::format("; {} images have no pixels", halves_.size()),
                              unfit_ > 0 ? fmt::format("; {} messages do not fit their topic", unfit_) : "")
                      .c_str());
    return good && unfit_ == 0 ? kDone : kFailed;
  }

  const BagPlayOptions& options_;
  record::Reader& reader_;
  Prepared prepared_;
  std::int64_t unix_ns_ = 0;
  std::vector<record::RecordedTopic> found_;
  std::map<std::string, record::Player*> players_;
  std::vector<std::unique_ptr<record::MessageStore>> stores_;
  std::map<std::string, Way> ways_;                                   // by channel
  std::set<std::pair<record::MessageStore*, std::uint32_t>> halves_;  // images with only one part so far
  std::uint64_t said_ = 0, unfit_ = 0;
};

}  // namespace

int bag_play(const BagPlayOptions& options) {
  if (options.as_robot) return play_as_robot(options);
  Progress progress("play");
  const auto reader = open_recording(options.file, progress);
  const auto query = reader ? query_of(*reader, options.what) : std::nullopt;
  if (!query) return kNotBegun;
  return Play(options, *reader).run(*query);
}

}  // namespace sinew::app
