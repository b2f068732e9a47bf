#pragma once
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/os.hpp"
#include "record/run/flight_ring.hpp"
#include "record/run/run_sink.hpp"
#include "record/run/step_log.hpp"
#include "record/run/verdict.hpp"

namespace sinew::record {

struct RecorderOptions {
  // Of files, as SinkOptions:
  SplitOptions files{.writer = {.chunk_bytes = 256 * 1024}};
  std::vector<std::string> topics{};
  std::vector<std::string> threads{};
  std::map<std::string, double> rate_hz{};
  double pixel_bytes_per_s = 5e6;
  /// Pace::follows: how much may wait in memory while the disk stalls. The memory is taken only while data waits.
  std::uint64_t buffer_bytes = 32'000'000;
  /// Starts the threads that write to the disk and make later files there; null: the recorder does it, and waits.
  hal::Os* disk_os = nullptr;
  // Of all:
  rt::Duration log_room = std::chrono::milliseconds(500);  // holds the steps that wait to be read
  rt::Duration state_every = std::chrono::seconds(5);      // of each module, for a replay to begin at; 0: never
  rt::Duration poll = std::chrono::milliseconds(10);       // younger entries are read the next time
  RingOptions ring{};
};

/// How far a recorder is.
struct RecorderProgress {
  rt::Time now;  // of the newest step that it has read
  struct File {  // that is being written
    rt::Time began;
    unsigned files = 0;
    std::uint64_t lost_messages = 0, lost_steps = 0;
  };
  std::optional<File> file{};
  struct Ring {
    rt::Duration held{};
    std::size_t bytes_used = 0;
    hal::Status trouble{};
  };
  std::optional<Ring> ring{};
};

/// Follows a run: reads every step with its latched and published messages, every request and every message, and hands
/// them to the recordings: a file, which may begin and end in the middle of the run, and the flight ring. In real time
/// it follows the executor's threads from its own thread, and no thread waits for it; it counts what it misses. In
/// virtual time the executor waits for it.
/// Thread:  owner; observer(): as RunObserver says; later(), progress(), ring(): any. Calls marked "the reader's" are
///          made inside of later(), or while the run stands still.
/// Owner:   graph and os must outlive it. The graph is configured with ConfigureOptions::recorded.
class RunRecorder {
 public:
  enum class Pace : std::uint8_t { follows, waited_for };
  /// `open_part`: of a file from the beginning on; empty: none.
  /// Errors:  those of the files and of Writer; bad_argument of the ring.
  static hal::Result<std::unique_ptr<RunRecorder>> open(rt::Graph& graph, Pace pace, SplitWriter::OpenPart open_part,
                                                        RunDescription description, const RecorderOptions& options);
  ~RunRecorder();  // finish() if it was not called; the executor has ended by then, too

  /// For RunnerOptions::observer.
  rt::RunObserver& observer();
  /// Pace::follows: begins to read. Errors: those of starting a thread.
  hal::Status start(hal::Os& os);
  /// The reader calls `what` between two messages. False: the run is over, and the call will not happen.
  bool later(std::function<void()> what);
  /// As it was 10 ms ago at most, or when the reader began to wait for the disk. Never waits itself.
  RecorderProgress progress() const;
  /// After the executor has ended: reads what is left, completes the file with `end`.
  hal::Status finish(const RunEnd& end = {});

  // ---- the reader's
  /// Errors:  busy when there is one; those of the files.
  hal::Status begin_file(SplitWriter::OpenPart open_part);
  /// Completes it; file() can still be asked. Errors: not_found when there is none; those of Writer.
  hal::Status end_file(const RunEnd& end = {});
  bool has_file() const;
  rt::Time now() const;  // of the newest step
  /// Writes the ring to a file. Answers the number of its report; nothing while another dump is written or without a
  /// ring.
  std::optional<std::size_t> snapshot(const std::string& reason);

  /// The file that is being written, or else the last one; null: there was none.
  const RunSink* file() const;
  /// Null: no ring was asked for.
  const FlightRing* ring() const;

  // Of file(), after finish():
  std::vector<ModuleVerdict> verdict() const { return file()->verdict(); }
  std::map<std::string, Losses> lost_messages() const { return file()->lost_messages(); }
  std::map<std::string, Losses> lost_steps() const { return file()->lost_steps(); }
  unsigned files() const { return file()->files(); }
  const hal::Status& trouble() const { return file()->trouble(); }

 private:
  class Body;
  explicit RunRecorder(std::unique_ptr<Body> body);
  std::unique_ptr<Body> body_;
};

}  // namespace sinew::record
