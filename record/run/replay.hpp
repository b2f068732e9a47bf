#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "record/reader.hpp"
#include "rt/graph.hpp"

namespace sinew::record {

/// A recorded message and the message that came out in its place now.
struct ReplayedMessage {
  std::uint32_t topic = 0;  // of the graph
  rt::Time now;             // of the step
  const rt::SlotHeader &recorded, &again;
};

class ReplayWatcher {
 public:
  virtual ~ReplayWatcher() = default;
  /// References are good until it returns.
  virtual void compared(const ReplayedMessage& message) = 0;
};

struct ImageHead;

/// Draws the pixels of images that a file has without them.
class PictureSource {
 public:
  virtual ~PictureSource() = default;
  /// Those of this image of this topic; empty: they cannot be had. Images of a topic come in the order of their
  /// numbers. Valid until the next call.
  virtual std::span<const std::byte> pixels(std::uint32_t topic, const ImageHead& head) = 0;
};

struct ReplayOptions {
  std::vector<std::string> modules{};  // none: all
  /// Each module begins after its last saved state before so many seconds of the record, or at its beginning if there
  /// is none. Nothing: at the beginning of the run or, in a file that begins in the middle of its run, at the first
  /// state after which the file has all that the module latched.
  std::optional<double> from_s{};
  std::optional<double> until_s{};  // of the record: steps that end later are not executed
  /// True: the replayed modules latch each other's new messages, under the recorded sequences. False, and for all other
  /// inputs: they latch recorded messages. See ReplayChain for steps that publish less or more.
  bool chain = false;
  std::vector<std::string> keep{};    // "attitude.kp": recorded settings of these parameters are not taken
  PictureSource* pictures = nullptr;  // of images whose pixels the file does not have; null: steps go without them
  ReplayWatcher* watcher = nullptr;   // sees every pair; with it, as with chain, modules go on after a difference
};

/// The first place where a module's steps differ from the record.
struct ReplayDifference {
  std::string module;
  std::uint32_t step = 0;  // Step::number
  rt::Time now;            // of the step
  std::string what;        // "out.v_world_mps.x", "status", "messages on out", "effect of set_param"
  std::string recorded, again;
};

struct ReplayedModule {
  std::string name;
  std::uint64_t steps = 0, messages = 0;         // executed and compared
  std::optional<rt::Time> from{};                // of the saved state where it began
  std::uint64_t not_compared = 0;                // messages that are not in the file
  std::uint64_t differing = 0;                   // of the compared ones
  std::uint64_t missing = 0, extra = 0;          // messages only in the record; messages only in the replay
  std::uint64_t settings_ignored = 0;            // ReplayOptions::keep
  std::optional<ReplayDifference> difference{};  // the first
  std::string stopped{};                         // why its steps end early in the file, or cannot begin
};

/// Images whose pixels came from a PictureSource. What differs from the recorded hash no step gets.
struct DrawnPictures {
  std::uint64_t same = 0, differing = 0, missing = 0;
  std::string first_wrong{};  // "camera.raw, image 17 at 1.700000 s: ..."; empty: all are the same
};

struct ReplayReport {
  std::vector<ReplayedModule> modules{};
  DrawnPictures pictures{};
  std::vector<FileProblem> problems{};  // of the file
  bool midway = false;                  // the file begins in the middle of its run: modules begin at saved states
  rt::Time start;                       // of the record
  rt::Duration length{};                // of the record
  const ReplayDifference* first_difference() const;
  bool complete() const;  // nothing stopped early
};

/// Executes the recorded steps of modules again, in the recorded order, each with its latched messages, and compares
/// the outputs byte for byte.
/// Thread:  owner.
/// Owner:   `graph` is that of the run: same modules in the same order with the parameters of its start, configured on
///          a hal::SilentBoard with the seed of the run; nothing else runs it.
/// Errors:  bad_data with `why` when the file holds no run, or one of other modules.
hal::Result<ReplayReport> replay(Reader& reader, rt::Graph& graph, const ReplayOptions& options, std::string& why);

}  // namespace sinew::record
