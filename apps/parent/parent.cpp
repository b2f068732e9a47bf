#include "apps/parent/parent.hpp"

#include <fmt/format.h>

#include <array>
#include <atomic>
#include <cstdio>
#include <optional>

#include "apps/parent/last_seconds.hpp"
#include "apps/parent/run_folder.hpp"
#include "hal/linux/process.hpp"
#include "hal/linux/socket.hpp"
#include "hal/linux/watchdog.hpp"
#include "hal/platform.hpp"
#include "record/run/ring_memory.hpp"
#include "tap/segment_reader.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;

// Messages of the runtime on the line, one byte each; kTopics and kRing bring memory.
constexpr std::byte kTopics{'T'}, kRing{'R'}, kEnding{'E'};

constexpr int kPriority = 99;                   // as the guardian: it sleeps but for a few microseconds of each look
constexpr hal::Duration kLook = 5ms;            // between two looks at the runtime
constexpr hal::Duration kAskedEnd = 1800ms;     // from the parent's request to kEnding, or to the end of the process
constexpr hal::Duration kOrderlyEnd = 20s;      // from kEnding to the end of the process: a slow disk has the recording
constexpr hal::Duration kLateWarning = 200ms;   // between two checks for a warning that may still come
constexpr hal::Duration kStopRepeated = 500ms;  // the line may be broken by the same fault for a moment

class Parent {
 public:
  Parent(const ParentOptions& options, Supervised& supervised) : options_(options), supervised_(supervised) {}

  int run() {
    hal::end_at_second_signal(nullptr);  // here it ends more than this process
    if (!open_watchdog()) return 2;
    auto line = hal::stream_pair();
    if (!line) return refuse("no line to the runtime", line.error());
    auto child = hal::ChildProcess::fork([&] {
      line->first.reset();
      watchdog_.reset();  // only the parent feeds it; the device stays open in the parent
      ParentLine to_parent(std::move(line->second));
      return supervised_.body(to_parent);
    });
    if (!child) return refuse("no process for the runtime", child.error());
    supervised_.in_parent();
    open_lines();
    line->second.reset();
    line_ = std::move(line->first);
    runtime_ = std::move(*child);
    // Above every priority at which the runtime may run wild; without the privilege this thread watches all the same.
    auto thread = os_.start_thread({"parent", kPriority, {}, 256 * 1024}, [this] { watch(); });
    if (!thread) return refuse("no thread for the parent", thread.error());
    print_while_watched();
    (*thread)->join();
    if (fault_.empty()) return exit_code_;
    report();
    return 1;
  }

 private:
  int refuse(const char* what, const hal::Error& error) {
    runtime_.reset();  // ended
    if (watchdog_) static_cast<void>(watchdog_->release());
    std::fprintf(stderr, "sinew: parent: %s: %s (%s)\n", what, hal::to_string(error.code), error.where);
    return 2;
  }

  /// Opens lines after the runtime was started: its copy of this process has none of them, and they may have threads.
  void open_lines() {
    for (StopWay& way : supervised_.stops)
      if (!way.line) way.line = way.open();
    stopped_.resize(supervised_.stops.size());
  }

  bool open_watchdog() {
    if (options_.watchdog.empty()) return true;
    auto opened = hal::open_watchdog(options_.watchdog, options_.watchdog_timeout);
    if (!opened) {
      std::fprintf(stderr, "sinew: parent.watchdog: \"%s\": %s (%s)\n", options_.watchdog.c_str(),
                   hal::to_string(opened.error().code), opened.error().where);
      return false;
    }
    watchdog_ = std::move(*opened);
    return true;
  }

  // ---- the main thread: prints meanwhile

  // A terminal may block for any time: the thread that watches does not wait for this one.
  void print_while_watched() {
    std::vector<bool> printed(supervised_.stops.size());
    bool feed_told = false;
    for (;;) {
      const std::uint32_t seen = said_.load();
      if (watched_.load()) return;
      bool all_known = true;
      for (std::size_t i = 0; i < printed.size() && begun_.load(); ++i) {
        const StopWarning& warning = *supervised_.stops[i].warning;
        if (printed[i]) continue;
        printed[i] = warning.known.load(std::memory_order_acquire);
        all_known = all_known && printed[i];
        if (printed[i] && !warning.text.empty()) std::fprintf(stderr, "warning: %s\n", warning.text.c_str());
      }
      if (feed_failed_.load() && !feed_told) {
        feed_told = true;
        std::fprintf(stderr, "warning: the watchdog cannot be fed: %s\n", feed_error_);
      }
      os_.wait(said_, seen, all_known ? hal::kNever : os_.now() + kLateWarning);
    }
  }

  // ---- the thread that watches: prints nothing and waits only for devices

  /// Something that print_while_watched() looks at has changed.
  void tell() {
    said_.fetch_add(1);
    os_.wake(said_);
  }

  void watch() {
    last_change_ = os_.now();
    for (hal::Time next = os_.now(); !done_; next = next + kLook) {
      os_.sleep_until(next);
      look(os_.now());
    }
    if (!fault_.empty() && !in_hurry_) {  // saved here, before printing, since a terminal may block
      saved_topics_ = saved_topics();
      saved_ring_ = saved_ring();
    }
    watched_.store(true);
    tell();
  }

  void look(hal::Time now) {
    listen(now);
    for (const StopWay& way : supervised_.stops)
      if (way.line) way.line->poll();
    supervised_.look();
    if (hal::stop_requested() && !asked_to_end_) {
      asked_to_end_ = true;
      if (!ending_) end_by_ = now + kAskedEnd;
      runtime_->terminate();
    }
    if (const auto code = runtime_->poll()) {
      exit_code_ = *code;
      if (*code > 128 || (topics_ && !ending_)) return act(now, "the runtime died: " + hal::describe_exit(*code));
      if (watchdog_) static_cast<void>(watchdog_->release());
      done_ = true;
      return;
    }
    if (hal::stop_signals() > 1) {
      in_hurry_ = true;
      return act(now, "ended at once by a second signal; the end of the recording may be missing");
    }
    if (now > end_by_) return act(now, "the runtime does not end");
    if (!ending_ && topics_) {
      if (const std::uint32_t beat = pulse(); beat != beat_) {
        beat_ = beat;
        last_change_ = now;
      } else if (now - last_change_ > options_.hang) {
        return act(now, fmt::format("the runtime hangs: no commit of the guardian for {} ms",
                                    (now - last_change_).count() / 1'000'000));
      }
    }
    feed(now);
  }

  void listen(hal::Time now) {
    std::array<std::byte, 1> word{};
    const auto n = line_->read_now(word);
    if (!n || *n == 0) return;  // nothing new, or the runtime has closed its end: poll() shows that
    if (word[0] == kEnding) {
      ending_ = true;
      end_by_ = now + kOrderlyEnd;
    } else if (word[0] == kRing) {
      auto memory = line_->take_memory(hal::Stream::MemoryAccess::mapped);
      if (!memory) return;
      ring_ = std::move(*memory);
      line_->expect_memory();  // the topics'
      static_cast<void>(line_->write(word));
    } else if (word[0] == kTopics) {
      auto memory = line_->take_memory(hal::Stream::MemoryAccess::mapped);
      if (!memory) return;  // supervise() then gets no answer and fails there
      memory_ = std::move(*memory);
      auto reader = tap::SegmentReader::open({memory_->data(), memory_->size()});
      if (!reader) return;
      topics_ = std::move(*reader);
      for (std::uint32_t t = 0; t < topics_->topics().size(); ++t)
        if (topics_->topics()[t].name.starts_with("guardian.")) guardian_ = t;
      beat_ = pulse();
      last_change_ = now + 1s;  // the executor's threads are still to come up
      begun_.store(true);
      tell();
      static_cast<void>(line_->write(word));
    }
  }

  // The guardian publishes in every cycle, at least twice a lease.
  std::uint32_t pulse() const {
    const auto message = topics_->newest(guardian_);
    return message ? message->sequence : 0;
  }

  void feed(hal::Time now) {
    if (!watchdog_ || now < next_feed_) return;
    next_feed_ = now + watchdog_->timeout() / 4;
    if (auto fed = watchdog_->feed(); !fed && !feed_failed_.load()) {
      feed_error_ = fed.error().where;
      feed_failed_.store(true);
      tell();
    }
  }

  // In the order of urgency; the watchdog is simply not fed any more. A line that latches works while the runtime
  // lives.
  void act(hal::Time now, std::string fault) {
    fault_ = std::move(fault);
    // A device that a thread of the runtime could start again is stopped after the runtime is killed. The plant comes
    // last: it may be what hangs.
    const bool mixed = any_that_does_not_latch();
    if (mixed) {
      runtime_->kill_now();
      stop_what_does_not_latch(now);
    }
    for (std::size_t i = 0; i < stopped_.size(); ++i)
      if (latches(i)) stop(i, now);
    if (!mixed) runtime_->kill_now();
    if (!runtime_->poll()) {  // it may have sent meanwhile
      runtime_->wait(2s);
      stop_what_does_not_latch(now);
    }
    for (const hal::Time until = os_.now() + kStopRepeated; os_.now() < until;) {
      bool all = true;
      for (std::size_t i = 0; i < stopped_.size(); ++i) all = stop_again(i, now) && all;
      if (all) break;
    }
    done_ = true;
  }

  bool latches(std::size_t i) const { return supervised_.stops[i].line && supervised_.stops[i].line->is_latching(); }

  bool any_that_does_not_latch() const {
    for (std::size_t i = 0; i < stopped_.size(); ++i)
      if (supervised_.stops[i].line && !latches(i)) return true;
    return false;
  }

  void stop_what_does_not_latch(hal::Time since) {
    for (std::size_t i = 0; i < stopped_.size(); ++i)
      if (!latches(i)) stop(i, since);
  }

  /// True: the stop was sent, now or before.
  bool stop_again(std::size_t i, hal::Time since) {
    if (stopped_[i].status) return true;
    os_.sleep_until(os_.now() + 10ms);
    if (auto line = supervised_.stops[i].open()) supervised_.stops[i].line = std::move(line);
    if (!supervised_.stops[i].line) return false;
    stop(i, since);
    return stopped_[i].status.has_value();
  }

  void stop(std::size_t i, hal::Time since) {
    stopped_[i].needless = supervised_.stops[i].needless();
    if (!stopped_[i].needless.empty()) stopped_[i].status = {};
    if (!stopped_[i].needless.empty() || !supervised_.stops[i].line) return;
    stopped_[i].status = supervised_.stops[i].line->stop();
    stopped_[i].after = os_.now() - since;
  }

  // ---- afterwards

  void report() {
    std::fprintf(stderr, "sinew: %s\n", fault_.c_str());
    if (stopped_.empty()) std::fprintf(stderr, "sinew: stop of the actuators: no stop line\n");
    for (std::size_t i = 0; i < stopped_.size(); ++i) report_stop(i);
    if (watchdog_) std::fprintf(stderr, "sinew: the watchdog is not fed any more\n");
    for (const std::string& line : {saved_topics_, saved_ring_})
      if (!line.empty()) std::fprintf(stderr, "sinew: %s\n", line.c_str());
  }

  void report_stop(std::size_t i) {
    const StopWay& way = supervised_.stops[i];
    std::string stop = stopped_[i].needless.empty() ? "no stop line" : stopped_[i].needless;
    if (way.line && stopped_[i].needless.empty()) {
      stop = stopped_[i].status
                 ? fmt::format("sent {:.1f} ms later", static_cast<double>(stopped_[i].after.count()) * 1e-6)
                 : fmt::format("failed: {}", stopped_[i].status.error().where);
      if (const std::string report = way.line->last_report(); !report.empty()) stop += "; " + report;
    }
    const std::string of = stopped_.size() > 1 ? " (" + way.name + ")" : "";
    std::fprintf(stderr, "sinew: stop of the actuators%s: %s\n", of.c_str(), stop.c_str());
  }

  /// Where the topics were saved, or why not; empty: there are none.
  std::string saved_topics() {
    if (!memory_) return {};
    std::string why;
    const std::string folder =
        save_last_seconds(options_.save_to, supervised_.robot, fault_, {memory_->data(), memory_->size()}, why);
    if (folder.empty()) return "the last seconds could not be saved: " + why;
    return "the last seconds are in " + folder;
  }

  /// The runtime is dead, so nothing writes the ring any more.
  std::string saved_ring() {
    if (!ring_) return {};
    const auto ring = record::RingMemory::open({ring_->data(), ring_->size()});
    std::string why = "it was not begun", folder = ring ? ring->folder() : std::string();
    if (ring && folder.empty()) folder = make_run_folder(supervised_.runs, supervised_.robot, why);
    if (folder.empty()) return "the flight ring could not be saved: " + why;
    const record::DumpFile file = next_ring_file(folder);
    record::Dumped dumped;
    if (const auto saved = record::dump_ring(ring->parts(), file, fault_, 0, dumped); !saved)
      return "the flight ring could not be saved: " + file.path + ": " + error_text(saved.error());
    return "the flight ring is in " + file.path;
  }

  const ParentOptions& options_;
  Supervised& supervised_;
  hal::Os& os_ = hal::system_os();
  std::unique_ptr<hal::Watchdog> watchdog_;
  std::unique_ptr<hal::Stream> line_;
  std::unique_ptr<hal::ChildProcess> runtime_;
  std::unique_ptr<hal::SharedMemory> memory_, ring_;
  std::optional<tap::SegmentReader> topics_;
  std::uint32_t guardian_ = 0;  // topic of the guardian
  std::uint32_t beat_ = 0;
  hal::Time last_change_{}, next_feed_{}, end_by_ = hal::kNever;
  bool asked_to_end_ = false, ending_ = false, in_hurry_ = false, done_ = false;
  // From the thread that watches to the one that prints.
  std::atomic<bool> watched_{false}, begun_{false}, feed_failed_{false};
  const char* feed_error_ = "";  // before feed_failed_
  hal::WakeWord said_{0};
  int exit_code_ = 0;
  std::string fault_, saved_topics_, saved_ring_;  // of the thread that watches, until it has ended
  struct Stopped {
    hal::Status status = hal::Error{hal::Errc::not_found, "no stop line"};
    hal::Duration after{};
    std::string needless{};
  };
  std::vector<Stopped> stopped_;  // as Supervised::stops
};

}  // namespace

hal::Status ParentLine::supervise(const hal::SharedMemory& topics) { return hand_over(kTopics, topics); }

hal::Status ParentLine::keep_ring(const hal::SharedMemory& ring) { return hand_over(kRing, ring); }

hal::Status ParentLine::hand_over(std::byte what, const hal::SharedMemory& memory) {
  const std::array<std::byte, 1> word{what};
  std::array<std::byte, 1> answer{};
  stream_->set_patience(100ms);
  if (auto sent = stream_->write_with_memory(word, memory); !sent) return sent;
  for (int turns = 20; turns > 0 && !hal::stop_requested(); --turns) {
    const auto n = stream_->read(answer);
    if (n) return {};
    if (n.error().code != hal::Errc::timeout) return n.error();
  }
  return hal::Error{hal::Errc::timeout, hal::stop_requested() ? "interrupted" : "no answer for 2 s"};
}

bool ParentLine::is_gone() noexcept {
  std::array<std::byte, 1> word{};
  const auto n = stream_->read_now(word);
  return !n && n.error().code == hal::Errc::closed;
}

void ParentLine::ending() {
  const std::array<std::byte, 1> word{kEnding};
  static_cast<void>(stream_->write(word));  // a parent that is gone needs no message
}

int run_with_parent(const ParentOptions& options, Supervised supervised) { return Parent(options, supervised).run(); }

}  // namespace sinew::app
