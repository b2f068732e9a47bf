#pragma once
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/linux/process.hpp"
#include "hal/os.hpp"
#include "hal/stream.hpp"

namespace sinew::app {

struct PlantRequest {
  std::string endpoint;        // "auto": start sinew-sim; else where a plant listens
  std::string world = "quad";  // of one that is started
  std::uint64_t seed = 1;
  std::uint32_t camera_width = 320, camera_height = 240;
  bool lockstep = true;
  std::vector<std::string> extra;  // arguments for sinew-sim
};

/// How a plant of our own has ended.
struct PlantExit {
  int code = 0;       // as ChildProcess::poll() has it
  std::string words;  // its last ones; empty: it said nothing
};
/// "died (signal 9)", "ended (exit code 1)".
std::string to_string(const PlantExit& exit);

/// A plant to talk to: one of its own (started here, killed at the latest with this object), or one that listens
/// already. A plant of our own dies with the process that started it, and leaves no file; where that process is killed
/// before the plant has been connected to, the next one to start a plant removes what was left.
/// Thread:  owner, but for is_stopped().
class PlantProcess {
 public:
  /// Ends soon after hal::stop_requested().
  /// Errors:  in `why`: sinew-sim is not built, ended at once (with its own words), nobody listens, interrupted.
  static std::unique_ptr<PlantProcess> open(const PlantRequest& request, std::string& why);
  ~PlantProcess();

  std::unique_ptr<hal::Stream> take_stream() { return std::move(stream_); }
  /// Where it listens: for further connections.
  const std::string& endpoint() const { return endpoint_; }
  /// It was started here.
  bool own() const { return own_; }
  /// Of the plant that was started here; 0: the plant is foreign, and its processor time is not known.
  int pid() const { return child_ ? child_->pid() : 0; }
  /// No more connections will be made to a plant of our own: its socket's file goes.
  void hide();

  /// In the process that started it, now and then: looks how it is, for all processes that share this object.
  void look();
  /// A plant of our own is stopped (SIGSTOP), as of the last look(). Thread: any, also of a copy of this process.
  bool is_stopped() const { return own_ && state() == kStopped; }
  /// How a plant of our own has ended; waits for that, at most `patience`. Nothing: it has not, or is foreign. In a
  /// copy of the process that started it: as of the last look() there.
  std::optional<PlantExit> ended(hal::Duration patience);
  /// After a failure: `why`; for a plant of our own that has ended, also how it ended and its last words.
  std::string with_its_end(std::string why);
  /// Waits for a plant of our own to end by itself; kills it when it does not within `patience`, or is stopped. Says
  /// in words that it did; empty: it had ended.
  std::string wait_for_end(hal::Duration patience);
  /// JSON, which a plant of our own writes at its end; empty: it has not ended by itself, or is not this process's.
  std::string last_report();
  void kill_now();
  /// In a runtime beside its parent: the parent ends the plant.
  void leave_to_parent();
  /// In the parent: the connection belongs to the runtime.
  void leave_to_runtime() { stream_.reset(); }

 private:
  static constexpr int kRuns = -1, kStopped = -2;  // else the exit code
  PlantProcess() = default;
  bool start(const PlantRequest& request, std::string& why);
  int state() const;
  std::string last_words();

  std::unique_ptr<hal::ChildProcess> child_;
  std::unique_ptr<hal::SharedMemory> state_;  // one int, which a copy of this process sees
  std::unique_ptr<hal::Stream> stream_;
  std::ifstream log_;
  std::string endpoint_, socket_path_;
  bool own_ = false;
  int own_state_ = kRuns;  // where there is no memory for `state_`
};

}  // namespace sinew::app
