#pragma once
#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "apps/robot_file/record_options.hpp"
#include "apps/run/run_metadata.hpp"
#include "apps/run/run_summary.hpp"
#include "record/run/run_recorder.hpp"
#include "tap/record_control.hpp"

namespace sinew::app {

struct Prepared;
struct RunOptions;

/// The files of one run on disk: recordings FOLDER/ROBOT-TIME/run.mcap, one from the beginning on if the robot file
/// says so, others from `sinew record start` to `stop`, and beside them the dumps of the flight ring.
/// Thread:  owner; of record control: the server's.
class Recording final : public tap::RecordControl {
 public:
  /// Null when no recorder is wanted, or, after a warning, when it cannot be opened: the robot flies without it. A file
  /// that cannot be begun is only a warning. The graph must be configured with ConfigureOptions::recorded, as wanted()
  /// says. In real time the recorder reads along from now on. `os`: with the robot's clock.
  static std::unique_ptr<Recording> open(const Prepared& prepared, const RunOptions& options, rt::Graph& graph,
                                         hal::Os& os);
  /// Whether the run shall have a recorder at all.
  static bool wanted(const Prepared& prepared, const RunOptions& options);
  /// Where the folders of recordings are made.
  static std::string folder_of(const Prepared& prepared, const RunOptions& options);
  ~Recording() override;  // removes the files of a run that took no step

  rt::RunObserver& observer() { return recorder_->observer(); }
  /// For a parent, which dumps the ring after this process died; null: there is no ring.
  const hal::SharedMemory* ring_memory() const { return ring_memory_.get(); }
  /// After the executor has ended: completes the file, with the result and the plant's report (empty: none), and tells
  /// the summary.
  void finish(RunSummary& summary, const RunResult& result, const std::string& report);

  std::uint64_t ask(Command command) override;
  std::optional<Answer> answer(std::uint64_t number) override;

 private:
  struct File {  // a completed file
    std::string path;
    unsigned parts = 0;
    std::vector<record::ModuleVerdict> verdict{};
    std::map<std::string, record::Losses> messages{}, steps{};
    hal::Status trouble{};
  };
  Recording(std::string under, std::string robot) : under_(std::move(under)), robot_(std::move(robot)) {}
  std::string begin_file();  // why not; empty: begun
  File end_file();
  record::RunEnd end_with(const RunResult& result, const std::string& report = {}) const;
  record::DumpFile next_dump();
  void serve(Command command, std::uint64_t number);
  Answer start();
  Answer stop();
  Json status() const;
  Json dumps() const;
  void tell_ring(RunSummary& summary) const;
  static Json to_json(const File& file);

  const std::string under_, robot_;
  bool dated_ = false;  // attachments have the time of the day: not in virtual time
  std::unique_ptr<hal::SharedMemory> ring_memory_;
  bool finished_ = false;
  std::string path_;                 // of the file that is being written, or was; the recorder's
  std::vector<File> files_;          // completed
  mutable std::mutex folder_mutex_;  // different threads write dumps and files, and ask for them
  std::string folder_;
  std::string recording_;  // path of the file that is being written; empty: none
  std::mutex answers_mutex_;
  std::map<std::uint64_t, Answer> answers_;
  std::map<std::uint64_t, std::size_t> dumping_;   // by request: the report of the ring that answers it
  std::uint64_t asked_ = 0;                        // the server's
  std::unique_ptr<record::RunRecorder> recorder_;  // the last: its threads use the others
};

/// For RunnerOptions and DiscreteOptions: null without a recording.
inline rt::RunObserver* observer_of(const std::unique_ptr<Recording>& recording) {
  return recording ? &recording->observer() : nullptr;
}

}  // namespace sinew::app
