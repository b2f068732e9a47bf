#pragma once
#include <map>
#include <optional>
#include <queue>
#include <set>
#include <string>
#include <vector>

#include "record/reader.hpp"
#include "record/run/message_store.hpp"
#include "record/run/replay.hpp"
#include "record/run/step_log.hpp"
#include "rt/graph.hpp"

namespace sinew::record {

/// An entry of a thread's log: a step, a request, or (neither) a saved state.
struct LogItem {
  rt::Time due;  // when it was over
  std::uint32_t thread = 0;
  std::uint64_t order = 0;
  std::optional<LoggedStep> step{};
  std::optional<LoggedRequest> request{};
  friend bool operator>(const LogItem& a, const LogItem& b) {
    return std::tie(a.due.ns, a.thread, a.order) > std::tie(b.due.ns, b.thread, b.order);
  }
};

/// When a record begins, in the time of the file: at its first message or, if it begins midway, after the older
/// messages that its first steps hold.
std::uint64_t recorded_start(Reader& reader);

/// The beginning of a record, on the robot's clock, and its length; 0 where the file does not say.
struct RecordedTime {
  rt::Time start;
  rt::Duration length{};
  rt::Time after_start(double s) const { return start + rt::Duration{static_cast<std::int64_t>(s * 1e9)}; }
};
RecordedTime recorded_time(Reader& reader);

/// Goes through a recorded run in the order in which its steps can be executed again, with the messages that they held.
///     RecordedRun run(reader, graph);
///     if (!run.open(why)) ...;
///     run.need(module); ...; run.begin();
///     while (run.next(items)) ...
/// Thread:  owner.
/// Owner:   reader and graph outlive it.
class RecordedRun {
 public:
  RecordedRun(Reader& reader, const rt::Graph& graph);

  /// Errors:  bad_data with `why`: the file holds no run, or one of other modules.
  hal::Status open(std::string& why);
  /// Announces that messages on the ports of this module are needed. Before begin().
  void need(std::uint32_t module);
  void begin();

  /// All items that are due at the earliest instant not yet given; false: the end.
  bool next(std::vector<LogItem>& items);
  /// The messages visible by then, on the needed topics.
  const MessageStore& messages(std::uint32_t topic) const { return stores_[topic]; }
  /// Forgets, in stores by topic, messages that later steps cannot hold. Its own stores it cleans in next().
  void forget(std::span<MessageStore> stores) const;

  rt::Time robot_time(std::uint64_t log_time) const {
    return {static_cast<std::int64_t>(log_time - static_cast<std::uint64_t>(unix_ns_))};
  }
  std::vector<FileProblem>& problems() { return problems_; }  // of the file, so far

  /// Asks this source for pixels that the file does not have. Before begin().
  void draw_with(PictureSource* pictures) { pictures_ = pictures; }
  const DrawnPictures& drawn() const { return drawn_; }

 private:
  enum class What : std::uint8_t { steps, requests, states, message, image, image_head };
  void find_channels();
  bool same_type(const Channel& channel, const msg::TypeInfo& type);
  void read_until_due();
  void take(const Message& m, rt::Time t);
  void draw(std::uint32_t topic, const Message& m, rt::Time t);
  bool push(LogItem item);
  void give(std::vector<LogItem>& items);

  Reader& reader_;
  const rt::Graph& graph_;
  std::int64_t unix_ns_ = 0;
  std::optional<MessageReader> reading_;
  bool ended_ = false;
  rt::Time now_{INT64_MIN};           // everything before is read
  std::vector<bool> wanted_;          // by topic
  std::vector<std::size_t> keep_;     // by topic: what the deepest port may hold
  std::vector<MessageStore> stores_;  // by topic
  /// Drop-newest queues: the sequence that they take next.
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::optional<std::uint32_t>> waiting_;
  std::map<std::uint16_t, std::pair<What, std::uint32_t>> channels_;
  std::vector<std::string> names_;
  std::priority_queue<LogItem, std::vector<LogItem>, std::greater<>> items_;
  std::multiset<std::int64_t> earliest_;  // of the steps that wait
  std::vector<LoggedStep> batch_;
  std::uint64_t rounds_ = 0;
  PictureSource* pictures_ = nullptr;
  DrawnPictures drawn_;
  std::vector<FileProblem> problems_;
};

}  // namespace sinew::record
