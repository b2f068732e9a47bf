#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "hal/os.hpp"
#include "record/run/step_log.hpp"
#include "record/run/verdict.hpp"
#include "record/split_writer.hpp"

namespace sinew::record {

struct RecorderOptions {
  SplitOptions files{.writer = {.chunk_bytes = 256 * 1024}};
  std::vector<std::string> topics{};                       // none: all
  std::map<std::string, double> rate_hz{};                 // at most so many messages of a topic
  double pixel_bytes_per_s = 5e6;                          // images beyond it are recorded without their pixels
  rt::Duration log_room = std::chrono::milliseconds(500);  // of steps that wait to be read
  rt::Duration state_every = std::chrono::seconds(5);      // of each module, to begin a replay at; 0: never
  rt::Duration poll = std::chrono::milliseconds(10);
};

/// What the file says of the run besides what happened in it.
struct RunDescription {
  Texts run{};                            // robot, board, seed, build, ... as metadata "sinew.run"
  std::vector<Attachment> attachments{};  // the robot file
  std::int64_t unix_ns = 0;               // added to the robot's clock for the times of the file
};

/// Records a run: every step with what it latched and published, every request, every message, into MCAP files whose
/// form docs/recording.md describes. In real time it follows the executor's threads from a thread of its own and
/// nobody waits for it: what it misses is counted. In virtual time the executor waits for it.
/// Thread:  owner; observer(): as RunObserver says.
/// Owner:   graph and os must outlive it. The graph is configured with ConfigureOptions::recorded.
class RunRecorder {
 public:
  enum class Pace : std::uint8_t { follows, waited_for };
  /// Errors:  those of the files and of Writer.
  static hal::Result<std::unique_ptr<RunRecorder>> open(rt::Graph& graph, Pace pace, SplitWriter::OpenPart open_part,
                                                        RunDescription description, const RecorderOptions& options);
  ~RunRecorder();  // finish() when nobody did; the executor has ended by then, too

  /// For RunnerOptions::observer.
  rt::RunObserver& observer();
  /// Pace::follows: begins to read. Errors: those of starting a thread.
  hal::Status start(hal::Os& os);
  /// After the executor has ended: reads what is left, writes the verdict, completes the file.
  hal::Status finish();

  // After finish():
  std::vector<ModuleVerdict> verdict() const;
  /// Of messages by topic and of steps by thread, where there were any.
  std::map<std::string, Losses> lost_messages() const;
  std::map<std::string, Losses> lost_steps() const;
  unsigned files() const;
  /// The first error of a file, which went on being tried; ok when there was none.
  const hal::Status& trouble() const;

 private:
  class Body;
  explicit RunRecorder(std::unique_ptr<Body> body);
  std::unique_ptr<Body> body_;
};

}  // namespace sinew::record
