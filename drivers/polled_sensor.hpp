#pragma once
#include <algorithm>
#include <atomic>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hal/buses.hpp"
#include "hal/os.hpp"
#include "hal/self_report.hpp"
#include "hal/sensor_queue.hpp"

namespace sinew::drivers {

/// What is special about one kind of device: how it is set up, and how it is asked. Everything else (thread, ring,
/// coming back after errors, counters) is PolledSensor's.
/// Thread:  owner: the one that polls.   RT: no; calls take as long as the bus.
template <class M>
class PolledDevice {
 public:
  virtual ~PolledDevice() = default;
  /// Brings the device from any state into the one in which it measures. Errors: with words in `why`; nothing is kept.
  virtual hal::Status set_up(std::string& why) = 0;
  /// Appends what has come since the last call, oldest first. Errors: with words in `why`; a few in a row lead to
  /// set_up(); closed does at once.
  virtual hal::Status poll(hal::Time now, std::vector<M>& out, std::string& why) = 0;
  /// The line that wakes the poller; null: it is asked each period.
  virtual hal::Serial* line() { return nullptr; }
};

struct PollOptions {
  std::string name = "sensor";  // for texts and the thread
  std::string path = {};        // of its bus or line, for texts; empty: the texts name it already
  hal::Duration period = std::chrono::milliseconds(1);
  int fifo_priority = 0;
  std::vector<int> cpus;
  int errors_in_a_row = 3;  // then it is set up again
  hal::Duration retry_first = std::chrono::milliseconds(20), retry_most = std::chrono::seconds(1);
  // Without a sample for so long, trouble() reports it. A polled device (no line()) is set up again then: one that lost
  // its power for a moment answers, but has forgotten to measure.
  hal::Duration silent_after = std::chrono::seconds(1);
};

/// Counted since the start.
struct PollStats {
  std::uint64_t samples = 0, lost = 0;  // handed over; dropped because nobody read them
  std::uint64_t errors = 0;             // polls that failed
  std::uint64_t restarts = 0;           // set up again after it was gone
};

/// A sensor that a hal thread polls: a device as modules see it.
/// Thread:  polls on a thread of its own.   RT: read() yes.
/// Errors:  read(): closed while the device does not answer; it is set up again with growing pauses.
template <class M>
class PolledSensor final : public hal::SensorQueue<M>, public hal::SelfReport {
 public:
  /// Sets the device up and starts. Errors: what set_up() says, with words in `why`.
  static hal::Result<std::unique_ptr<PolledSensor>> start(hal::Os& os, std::unique_ptr<PolledDevice<M>> device,
                                                          PollOptions options, std::string& why) {
    std::unique_ptr<PolledSensor> sensor(new PolledSensor(os, std::move(device), std::move(options)));
    if (auto done = sensor->device_->set_up(why); !done) {
      why = sensor->named(why);
      return done.error();
    }
    hal::ThreadOptions thread;
    thread.name = sensor->options_.name;
    thread.fifo_priority = sensor->options_.fifo_priority;
    thread.cpus = sensor->options_.cpus;
    auto started = os.start_thread(thread, [s = sensor.get()] { s->run(); });
    if (!started) {
      why = sensor->options_.name + ": its thread cannot be started: " + hal::to_string(started.error().code);
      return started.error();
    }
    sensor->thread_ = std::move(*started);
    return sensor;
  }
  ~PolledSensor() override {
    stop_.store(1, std::memory_order_release);
    os_.wake(stop_);
    thread_.reset();
  }

  PollStats stats() const {
    return {.samples = this->delivered(),
            .lost = this->hal::template SensorQueue<M>::lost(),
            .errors = errors_.value(),
            .restarts = restarts_.value()};
  }
  /// What is wrong now, in words; empty: nothing.
  std::string trouble() const override { return trouble_.get(); }
  std::string shortfall() const override { return thread_ ? thread_->shortfall() : std::string(); }

 private:
  PolledSensor(hal::Os& os, std::unique_ptr<PolledDevice<M>> device, PollOptions options)
      : os_(os), device_(std::move(device)), options_(std::move(options)) {}

  bool stopped() const noexcept { return stop_.load(std::memory_order_acquire) != 0; }
  void sleep_until(hal::Time t) noexcept {
    while (!stopped() && os_.now() < t) os_.wait(stop_, 0, t);
  }
  /// With its name, and its path where the text has none.
  std::string named(const std::string& text) const {
    const bool has_path = options_.path.empty() || text.find(options_.path) != std::string::npos;
    return options_.name + ": " + (has_path ? "" : options_.path + ": ") + text;
  }
  void tell(const std::string& text) {
    told_ = true;
    trouble_.set(named(text));
  }
  void all_is_well() {
    if (told_) trouble_.set({});
    told_ = false;
  }

  void run() noexcept {
    std::vector<M> found;
    std::string why;
    int failures = 0;
    hal::Time next = os_.now(), heard = next, erred{}, polled = next;
    while (!stopped()) {
      next = wait(next);
      if (stopped()) return;
      found.clear();
      // A chip counts as silent only while it is asked: a pause of the caller is not its silence.
      if (!device_->line() && os_.now() - polled > options_.silent_after / 2) heard = os_.now();
      polled = os_.now();
      const hal::Status done = device_->poll(polled, found, why);
      for (const M& sample : found) this->put(sample);
      if (!found.empty()) heard = os_.now();
      if (done) {
        failures = 0;
        const bool silent = os_.now() - heard >= options_.silent_after;
        // A recent error (e.g. garbage) says more than that nothing came.
        const bool said = erred.ns != 0 && os_.now() - erred < 2 * options_.silent_after && erred > heard;
        if (silent && !said)
          tell(device_->line() ? "is open, but nothing comes in (power, wires, bit rate?)"
                               : "answers, but sends nothing (its clock or power?)");
        if (!silent && !found.empty()) all_is_well();
        if (!silent || device_->line()) continue;  // a receiver may have nothing to say; a chip always measures
      } else {
        errors_.add();
        tell(why);
        erred = os_.now();
        if (!device_->line()) heard = erred;
        if (done.error().code != hal::Errc::closed && ++failures < options_.errors_in_a_row) continue;
      }
      this->set_gone(true);
      if (!come_back()) return;
      this->set_gone(false);
      restarts_.add();
      failures = 0;
      next = heard = os_.now();
    }
  }
  /// Waits until the next poll is due; answers the time that it was due.
  hal::Time wait(hal::Time last) noexcept {
    if (hal::Serial* line = device_->line()) {
      // A short sleep, as stopping does not wake it. The read that follows reports errors again.
      if (!line->wait_readable(os_.now() + std::chrono::milliseconds(20)))
        sleep_until(os_.now() + options_.retry_first);
      return last;
    }
    const hal::Time next = std::max(last + options_.period, os_.now());  // a late poll shifts the next ones, no burst
    sleep_until(next);
    return next;
  }
  /// False: to be stopped.
  bool come_back() noexcept {
    for (hal::Duration pause = options_.retry_first;; pause = std::min(2 * pause, options_.retry_most)) {
      sleep_until(os_.now() + pause);
      if (stopped()) return false;
      std::string why;
      if (device_->set_up(why)) return true;
      errors_.add();
      tell(why);
    }
  }

  hal::Os& os_;
  std::unique_ptr<PolledDevice<M>> device_;
  const PollOptions options_;
  hal::TroubleText trouble_;
  bool told_ = false;
  hal::Tally errors_, restarts_;
  hal::WakeWord stop_{0};
  std::unique_ptr<hal::Thread> thread_;
};

}  // namespace sinew::drivers
