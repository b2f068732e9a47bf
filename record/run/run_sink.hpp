#pragma once
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "record/run/run_messages.hpp"
#include "record/run/verdict.hpp"
#include "record/split_writer.hpp"
#include "rt/graph.hpp"

namespace sinew::record {

/// A file's description of the run, besides the events.
struct RunDescription {
  Texts run{};                            // robot, board, seed, build, ... as metadata "sinew.run"
  std::vector<Attachment> attachments{};  // the robot file
  std::int64_t unix_ns = 0;               // added to the robot's clock for the times of the file
  std::vector<Metadata> more{};           // of the same kind as "sinew.run": the world, the options, the faults
};

/// What is known of a run only when it, or its recording, has ended.
struct RunEnd {
  Texts result{};                         // metadata kResultName
  std::vector<Attachment> attachments{};  // the simulator's report
};
/// Metadata at the end of a recording: how the run went. A file without it has no end, or its run goes on elsewhere.
inline constexpr std::string_view kResultName = "sinew.result";

/// The place in a run where a recording begins, and the logs and parameters there.
struct Beginning {
  bool midway = false;                   // false: the recording begins before the first step
  rt::Time at{};                         // midway: of the newest step before it
  std::vector<std::uint64_t> entries{};  // per thread: order of the first entry that is to come
  Texts params{};
};

struct SinkOptions {
  SplitOptions files{.writer = {.chunk_bytes = 256 * 1024}};
  std::vector<std::string> topics{};  // none: all
  /// Only the steps of these threads; none: all. Of topics of other threads only messages that such a step held.
  std::vector<std::string> threads{};
  std::map<std::string, double> rate_hz{};             // at most so many messages of a topic per second
  double pixel_bytes_per_s = 5e6;                      // images beyond it are recorded without their pixels
  bool pixels_saved = true;                            // of a second, at the beginning
  std::uint64_t pixel_room_bytes = ~std::uint64_t{0};  // of a file; pixels beyond it are left out
};

/// A message in its slot, in the forms that a file stores.
struct SinkMessage {
  const rt::SlotHeader* slot = nullptr;
  std::span<const std::byte> cdr{};  // empty for images
  ImageHead head{};                  // of images
};

/// One recording of a run: writes what the run reports to files, and counts what does not fit. docs/recording.md
/// describes the format.
/// Thread:  owner, an ordinary one.
/// Owner:   graph and description outlive it.
class RunSink {
 public:
  /// Errors:  those of the files and of Writer.
  static hal::Result<std::unique_ptr<RunSink>> open(const rt::Graph& graph, const RunDescription& description,
                                                    SplitWriter::OpenPart open_part, const SinkOptions& options,
                                                    Beginning beginning);

  /// True if a message of this topic and time belongs in here; then put() or lose() it. Ask once for each message.
  bool takes(std::uint32_t topic, rt::Time at);
  bool takes_all(std::uint32_t topic) const {
    const TopicKept& kept = topics_[topic].kept;
    return kept.wanted && kept.rate_hz <= 0 && !kept.held_only;
  }
  void put(std::uint32_t topic, const SinkMessage& message, rt::Time at);
  void lose(std::uint32_t topic, rt::Time at) { topics_[topic].kept.lost.add(1, at); }
  /// A message published before the beginning that may be latched after it. Oldest first.
  void put_older(std::uint32_t topic, const SinkMessage& message);
  /// Writes a message, not an image, that an earlier file has and that steps in this file may hold. A failure is no
  /// loss.
  void put_again(std::uint32_t topic, const SinkMessage& message) { static_cast<void>(write(topics_[topic], message)); }
  /// Messages published up to this sequence are not in the file.
  void lacks_until(std::uint32_t topic, std::uint32_t sequence) { topics_[topic].first = sequence + 1; }

  /// Steps, requests and states of this thread belong in here; of others the sink must not be told.
  bool takes_thread(std::uint32_t thread) const { return threads_[thread]; }
  /// True if a step of this file held this message of a thread that does not belong in here, and the file does not
  /// have it. Ask once for each message; then put() or lose() it.
  bool takes_held(std::uint32_t topic, std::uint32_t sequence);
  void step(const LoggedStep& step);  // before its messages; its bytes come with a batch
  void steps(std::uint32_t thread, const StepBatch& batch);
  void request(const LoggedRequest& request, std::span<const std::byte> bytes);
  /// A parameter is from now on what `text` says: of files that begin later.
  void set_param(const std::string& name, const std::string& text) { beginning_.params[name] = text; }
  void state(const LoggedState& state, std::span<const std::byte> bytes);
  void lost(std::uint32_t thread, std::uint64_t entries, rt::Time at);
  void tick(rt::Time now);
  /// Writes the verdict and `end`, and completes the last file. Errors: those of Writer.
  hal::Status finish(const RunEnd& end = {});

  /// True while the file, or the present one of several, begins midway and lacks a state of the module from which its
  /// steps can be executed again.
  bool needs_state(std::uint32_t module) const {
    if (!threads_[graph_.modules()[module].thread]) return false;
    return (beginning_.midway && !from_[module]) || state_part_[module] < writer_->part();
  }

  /// Time of the newest step before the recording or, from the beginning on, of the first one.
  rt::Time began() const { return beginning_.at; }
  std::vector<ModuleVerdict> verdict() const;
  /// Losses of messages by topic and of steps by thread, where there were any.
  std::map<std::string, Losses> lost_messages() const;
  std::map<std::string, Losses> lost_steps() const;
  unsigned files() const { return writer_->part() + 1; }
  /// Of the last file.
  std::uint64_t bytes_at_most() { return writer_->writer().bytes_at_most(); }
  /// The first error of a file (writing continued); ok when there was none.
  const hal::Status& trouble() const { return trouble_; }

 private:
  // Bytes that may be used up at a rate, with savings of at most a second.
  class Budget {
   public:
    Budget(double per_s, bool saved) : per_s_(per_s), left_(saved ? per_s : 0) {}
    bool take(std::size_t bytes, rt::Time now);

   private:
    double per_s_, left_;
    rt::Time last_;
  };
  struct Topic {
    TopicKept kept;
    bool is_image = false;
    std::uint16_t channel = 0, head_channel = 0;
    std::optional<std::uint32_t> newest;  // named by a step
    std::optional<std::uint32_t> first;   // midway: from here on messages are in the file, or counted
    std::optional<std::uint32_t> older;   // the last one of put_older()
    rt::Time next;                        // rate_hz: earliest time of the next message
    std::deque<std::uint32_t> held{};     // TopicKept::held_only: the newest messages that the file has
    unsigned held_part = 0;               // of a split recording, the file that has them
  };

  RunSink(const rt::Graph& graph, const RunDescription& description, const SinkOptions& options, Beginning beginning);
  hal::Status open(SplitWriter::OpenPart open_part, const SplitOptions& options);
  hal::Status begin_file(Writer& writer, unsigned part);
  hal::Status add_channels();
  Texts graph_texts() const;
  Stamps stamps(std::uint32_t sequence, rt::Time log, rt::Time publish) const;
  bool note(const hal::Status& written);
  bool write(Topic& topic, const SinkMessage& message);
  hal::Status write_image(Topic& topic, const SinkMessage& message);
  bool has_inputs(const LoggedStep& step) const;

  const rt::Graph& graph_;
  const RunDescription& description_;
  const std::uint64_t pixel_room_bytes_;
  Beginning beginning_;
  Budget budget_;
  std::vector<Topic> topics_;
  std::vector<Losses> lost_entries_;           // per thread
  std::vector<std::uint64_t> entries_;         // per thread: what its log held, lost ones included
  std::vector<std::optional<rt::Time>> from_;  // per module, midway: the state where a replay can begin
  std::vector<unsigned> state_part_;           // per module: of several files the one that has its newest state
  std::vector<bool> stepped_;                  // per module
  std::vector<bool> threads_;                  // per thread: takes_thread()
  std::vector<std::uint64_t> written_;         // per thread: order of the entry that is written next
  rt::Time newest_;                            // of the steps
  std::optional<SplitWriter> writer_;
  std::uint16_t steps_channel_ = 0, requests_channel_ = 0, states_channel_ = 0;
  Buffer scratch_;
  hal::Status trouble_;
};

/// Room that a file needs so that Writer does not refuse a message of so many bytes.
std::uint64_t room_for(std::uint64_t bytes);

/// How names of modules and threads are numbered in metadata: "007", in the order of the map.
std::string number_key(std::size_t i);

}  // namespace sinew::record
