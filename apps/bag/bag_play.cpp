// bag play: a recorded file stands up as a robot.
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

#include "apps/bag/bag_options.hpp"
#include "apps/bag/recorded_about.hpp"
#include "apps/bag/recorded_answers.hpp"
#include "apps/command/command.hpp"
#include "apps/command/json.hpp"
#include "hal/linux/keyboard.hpp"
#include "hal/linux/process.hpp"
#include "hal/linux/run_dir.hpp"
#include "hal/platform.hpp"
#include "record/run/playback.hpp"
#include "record/run/run_messages.hpp"
#include "record/run/step_counts.hpp"
#include "tap/names.hpp"
#include "tap/server.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;
using record::Playback;

constexpr hal::Duration kLook = 100ms;    // at keys, the file's problems, Ctrl-C
constexpr hal::Duration kStarts = 200ms;  // until the first message, so that no reader misses it
constexpr double kFaster = 1.1;           // as ROS 2: an arrow up or down

/// The name on this machine: one that was asked for is taken, or it is an error. The recorded robot's may be that of a
/// robot that runs beside it; then it is NAME-PID. Null after printing why.
std::unique_ptr<tap::Name> take_name_for(const std::string& asked, const std::string& recorded) {
  std::string why;
  auto name = tap::Name::take(!asked.empty() ? asked : recorded.empty() ? "recording" : recorded, why);
  if (!name && asked.empty() && name.error().code == hal::Errc::busy)
    name = tap::Name::take(fmt::format("{}-{}", recorded, hal::process_id()), why);
  if (name) return std::move(*name);
  fail(why);
  return nullptr;
}

class Play {
 public:
  Play(const BagPlayOptions& options, record::Reader& reader) : options_(options), reader_(reader) {}

  int run(const record::Query& query) {
    say_problems(options_.file, reader_.problems());
    told_ = reader_.problems().size();
    RecordedAbout about = recorded_about(reader_, options_.file, *options_.types);
    if (!open_playback(query, about)) return kNotBegun;
    const auto name = take_name_for(options_.name, about.robot);
    if (!name) return kNotBegun;
    const std::string robot = name->robot();
    const auto keys = hal::Keyboard::open();
    RecordedAnswers::Recording recording{robot, std::filesystem::absolute(options_.file).lexically_normal().string(),
                                         std::move(not_shown_)};
    auto answers = std::make_unique<RecordedAnswers>(*playback_, *counts_, std::move(about), std::move(recording));
    const auto server = tap::Server::open(*name, std::move(answers), hal::system_os());
    if (!server) return fail(name->path() + ": " + server.error().where);
    if (const auto started = playback_->start(); !started) return fail(started.error().where);
    say_what_it_is(robot, keys != nullptr);
    const hal::Time begun = hal::system_os().now();
    if (!options_.paused) {
      hal::system_os().sleep_until(begun + kStarts);
      playback_->play();
    }
    follow(keys.get());
    return tell(robot, msg::seconds(hal::system_os().now() - begun));
  }

 private:
  bool open_playback(const record::Query& query, const RecordedAbout& about) {
    record::RecordedTopics topics = record::recorded_topics(reader_);
    const auto& asked = options_.what.topics;
    const auto not_asked = [&](const auto& topic) {
      return !asked.empty() && std::find(asked.begin(), asked.end(), topic.name) == asked.end();
    };
    std::erase_if(topics.known, not_asked);
    std::erase_if(topics.unknown, not_asked);
    for (const auto& topic : topics.unknown)
      std::fprintf(stderr, "%s: %s is not shown: %s\n", options_.file.c_str(), topic.name.c_str(), topic.why.c_str());
    if (topics.known.empty()) {
      fail(options_.file + ": no topic in it that this program can show");
      return false;
    }
    not_shown_ = std::move(topics.unknown);
    counts_.emplace(about.threads.size(), about.modules.size());
    record::PlaybackOptions how{query.from, query.until, options_.rate, options_.loop, true};
    if (about.graph) set_what_the_robot_file_says(*about.graph, about, how);
    how.other_topics = {std::string(record::kStepsTopic)};
    how.other = [this](const record::Message& m) {
      if (record::decode(m.data, steps_)) counts_->add(steps_);
    };
    auto opened = Playback::open(reader_, std::move(topics.known), std::move(how), hal::system_os());
    if (!opened) {
      fail(options_.file + ": " + opened.error().where);
      return false;
    }
    playback_ = std::move(*opened);
    return true;
  }

  void set_what_the_robot_file_says(const rt::Graph& graph, const RecordedAbout& about, record::PlaybackOptions& how) {
    for (const rt::TopicSpec& topic : graph.spec().topics) how.history[topic.name] = topic.history;
    for (std::size_t t = 0; t < about.threads.size(); ++t)
      if (const std::uint32_t known = graph.find_thread(about.threads[t]); known != rt::kNone)
        counts_->thread(t).period_ns.set(graph.threads()[known].spec.period.count());
  }

  void say_what_it_is(const std::string& robot, bool has_keys) const {
    if (options_.json) return;
    std::printf("%s\n", fmt::format("{}: {:.1f} s of {}, {} topics{}", robot, length_s(), options_.file,
                                    playback_->topics().size(),
                                    has_keys ? "; space: pause or play, right: next message, up and down: speed, "
                                               "Ctrl-C: end"
                                             : "")
                            .c_str());
    std::fflush(stdout);
  }

  /// Until Ctrl-C, and without --stay until the end of the file. `keys` may be null.
  void follow(hal::Keyboard* keys) {
    const bool shown = keys && hal::output_is_terminal() && !options_.json;
    bool had_ended = false;
    while (!hal::stop_requested()) {
      if (!keys)
        hal::system_os().sleep_until(hal::system_os().now() + kLook);
      else if (const auto key = keys->next(kLook))
        press(*key);
      tell_problems();
      if (shown) hal::print_now("\r" + where() + "\033[K");
      // A look later, so that readers see the last messages.
      const bool has_ended = playback_->status().state == Playback::State::ended;
      if (has_ended && had_ended && !options_.stay) break;
      had_ended = has_ended;
    }
    if (shown) hal::print_now("\r\033[K");
  }

  void press(hal::Key key) {
    const Playback::Status status = playback_->status();
    const bool plays = status.state == Playback::State::playing;
    if (key == hal::Key::space) static_cast<void>(plays ? playback_->pause() : playback_->play());
    if (key == hal::Key::right) playback_->step(1);
    if (key == hal::Key::up) playback_->set_speed(status.speed * kFaster);
    if (key == hal::Key::down) playback_->set_speed(status.speed / kFaster);
  }

  double length_s() const {
    const Playback::Status status = playback_->status();
    return msg::seconds(status.end - status.begin);
  }

  std::string where() const {
    const Playback::Status status = playback_->status();
    const char* const state = status.state == Playback::State::playing  ? "plays"
                              : status.state == Playback::State::paused ? "paused at"
                                                                        : "ended at";
    return fmt::format("{} {:.2f} of {:.2f} s, speed {:.3g}", state, msg::seconds(status.now - status.begin),
                       msg::seconds(status.end - status.begin), status.speed);
  }

  /// Those that were found since the last call.
  void tell_problems() {
    const std::vector<record::FileProblem> all = playback_->status().problems;
    for (; told_ < all.size(); ++told_)
      std::fprintf(stderr, "%s: %s\n", options_.file.c_str(), to_string(all[told_]).c_str());
  }

  int tell(const std::string& robot, double took_s) {
    tell_problems();
    const Playback::Status status = playback_->status();
    if (options_.json)
      std::printf("%s", to_line({{"file", options_.file},
                                 {"robot", robot},
                                 {"topics", playback_->topics().size()},
                                 {"messages", status.messages},
                                 {"without_pixels", status.without_pixels},
                                 {"not_played", status.unfit},
                                 {"seconds", took_s}})
                            .c_str());
    else
      std::printf(
          "%s\n",
          fmt::format("{}: {} messages of {} topics in {:.2f} s{}{}", options_.file, status.messages,
                      playback_->topics().size(), took_s,
                      status.without_pixels > 0 ? fmt::format("; {} images have no pixels", status.without_pixels) : "",
                      status.unfit > 0 ? fmt::format("; {} messages do not fit their topic", status.unfit) : "")
              .c_str());
    return status.problems.empty() && status.unfit == 0 ? kDone : kFailed;
  }

  const BagPlayOptions& options_;
  record::Reader& reader_;
  std::vector<record::RecordedTopics::Unknown> not_shown_;
  std::vector<record::LoggedStep> steps_;  // the playback thread's own: keeps its memory
  std::optional<record::StepCounts> counts_;
  std::unique_ptr<Playback> playback_;
  std::size_t told_ = 0;  // problems
};

}  // namespace

int bag_play(const BagPlayOptions& options) {
  static_cast<void>(hal::stop_requested());  // from here on Ctrl-C ends it in order
  Progress progress("play", false);          // what reads the file is the playback's thread, as long as it plays
  const auto reader = open_recording(options.file, progress);
  const auto query = reader ? query_of(*reader, options.what) : std::nullopt;
  if (!query) return kNotBegun;
  return Play(options, *reader).run(*query);
}

}  // namespace sinew::app
