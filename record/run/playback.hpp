#pragma once
#include <atomic>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "hal/os.hpp"
#include "record/reader.hpp"
#include "record/run/message_store.hpp"
#include "record/run/recorded_topics.hpp"
#include "rt/commit.hpp"
#include "rt/exec/stats.hpp"
#include "rt/segment.hpp"

namespace sinew::record {

struct PlaybackOptions {
  std::uint64_t from = 0, until = ~std::uint64_t{0};  // log time of the file, both included
  double speed = 1;                                   // recorded seconds per second
  bool loop = false, paused = false;
  std::map<std::string, std::uint32_t> history{};  // messages that a topic keeps; others keep those of 0.5 s
  /// Further topics of the file, whose messages go to `other` when they are due, on the playback's thread.
  std::vector<std::string> other_topics{};
  std::function<void(const Message&)> other{};
};

/// A recorded file as topics in memory: each message is published when it is due, by the time of the file, which can be
/// paused, moved and sped up. What reads the memory of a running robot reads this memory the same way: sequences only
/// rise, also when the time goes back. In memory are the file's index, the chunks that the present instant needs, and
/// the topics.
/// Thread:  owner for open(), start() and the end; status() and the requests: any.
/// Owner:   reader and os outlive it; from start() on nobody else uses the reader.
class Playback {
 public:
  static constexpr double kSlowest = 0.01, kFastest = 100;

  /// Errors:  bad_data: no time to play, or one of more than 100 years, or too many topics; out_of_memory: its topics
  ///          need more than 1 GiB; what making shared memory says.
  static hal::Result<std::unique_ptr<Playback>> open(Reader& reader, std::vector<RecordedTopic> topics,
                                                     PlaybackOptions options, hal::Os& os);
  ~Playback();  // ends its thread
  Playback(const Playback&) = delete;
  Playback& operator=(const Playback&) = delete;
  /// Errors:  what starting a thread says.
  hal::Status start();

  const std::vector<RecordedTopic>& topics() const { return topics_; }
  const rt::Segment& segment() const { return *segment_; }
  const hal::SharedMemory& memory() const { return *memory_; }
  rt::TopicId topic_id(std::size_t topic) const { return places_[topic].id; }
  const rt::TopicStats& stats(std::size_t topic) const { return stats_[topic]; }

  enum class State : std::uint8_t { playing, paused, ended };
  struct Status {
    State state = State::paused;
    rt::Time now, begin, end;  // by the robot's clock
    double speed = 1;
    bool loop = false;
    std::uint64_t messages = 0;         // published
    std::uint64_t unfit = 0;            // are not what their topic's type says
    std::uint64_t without_pixels = 0;   // images
    std::uint64_t rounds = 0;           // ended and begun again
    std::vector<FileProblem> problems;  // of the file, each once; of many the first ones
  };
  Status status() const;
  /// The number of the newest request that has been carried out, and with it all earlier ones.
  std::uint64_t done() const;

  // ---- Requests, carried out in their order. Each answers its number. A step that goes on ends where another request
  // than a step comes.
  /// After the end: from the beginning.
  std::uint64_t play();
  std::uint64_t pause();
  /// Publishes at once the newest message of each topic up to then. What played goes on there; what had ended is
  /// paused. Clamped to begin and end.
  std::uint64_t seek(rt::Time to);
  /// Pauses, and publishes so many messages, of all topics.
  std::uint64_t step(std::uint64_t messages);
  /// Pauses, and publishes all messages up to the next one of this topic.
  std::uint64_t step_to(std::size_t topic);
  /// Clamped to kSlowest and kFastest.
  std::uint64_t set_speed(double speed);

 private:
  struct Place {  // of a topic
    rt::TopicId id = 0;
    rt::WriterId writer = 0;
    std::uint32_t output = 0;
  };
  struct Way {  // of a channel
    std::size_t topic = 0;
    enum class What : std::uint8_t { message, pixels, head, other } what = What::message;
  };
  struct Command {
    enum class Kind : std::uint8_t { play, pause, seek, step, step_to, speed } kind = Kind::play;
    std::int64_t offset = 0;
    std::uint64_t count = 0;  // of messages, or the topic
    double speed = 1;
    static bool is_step(const Command& c) { return c.kind == Kind::step || c.kind == Kind::step_to; }
  };
  struct Goal {  // of stepping; without initial values, which clang does not find in an optional of this class
    std::uint64_t messages;
    std::optional<std::size_t> topic;
  };
  struct Found;
  Playback(Reader& reader, std::vector<RecordedTopic> topics, PlaybackOptions options, hal::Os& os);
  hal::Status prepare();
  hal::Status find_time();
  hal::Status make_segment();

  // On the playback's thread.
  void run();
  bool ends() const { return end_.load(std::memory_order_relaxed); }
  void take_commands();
  void carry_out(const Command& command);
  void halt();
  void begin_again();
  hal::Time play_on();
  hal::Time at_end();
  void step_on();
  void go_to(std::int64_t offset, bool included);
  void show_newest(std::uint64_t until);
  void search(const Query& window, std::vector<Found>& found);
  bool fetch();
  std::optional<std::size_t> take(const Message& message);
  std::optional<std::size_t> take(const Way& way, const Stamps& stamps, std::span<const std::byte> data);
  bool publish(std::size_t topic, std::span<const std::byte> cdr, std::uint64_t log_time);
  bool publish_image(std::size_t topic, const MessageStore::Entry& entry, std::uint64_t log_time);
  void commit(std::size_t topic, std::uint64_t log_time);
  void note(const FileProblem& problem);
  std::int64_t position(hal::Time now) const;
  hal::Time due(std::int64_t offset) const;
  void anchor(std::int64_t offset, State state);

  std::int64_t offset_of(std::uint64_t log_time) const { return static_cast<std::int64_t>(log_time - begin_); }
  rt::Time robot_time(std::uint64_t log_time) const {
    return {static_cast<std::int64_t>(log_time - static_cast<std::uint64_t>(unix_ns_))};
  }
  std::uint64_t ask(const Command& command);

  Reader& reader_;
  const std::vector<RecordedTopic> topics_;
  const PlaybackOptions options_;
  hal::Os& os_;
  std::uint64_t begin_ = 0;   // log time; offsets count from here
  std::int64_t length_ = 0;   // offset of the end
  std::int64_t unix_ns_ = 0;  // of the recording
  std::map<std::string, Way, std::less<>> ways_;
  std::unique_ptr<hal::SharedMemory> memory_;
  std::unique_ptr<rt::Segment> segment_;
  std::vector<Place> places_;
  std::vector<std::unique_ptr<rt::Commit>> commits_;  // by writer
  std::vector<rt::TopicStats> stats_;
  std::vector<MessageStore> stores_;  // by topic; used by those of images

  // The playback's thread only.
  std::optional<MessageReader> messages_;
  Message next_;            // fetched, not yet due
  bool has_next_ = false;   // false: to be fetched
  bool exhausted_ = false;  // nothing is left to fetch
  std::optional<Goal> goal_;
  hal::Time round_begun_;
  std::uint64_t taken_ = 0;  // the number of the newest request that is carried out

  mutable std::mutex mutex_;  // guards what follows
  std::deque<Command> commands_;
  std::uint64_t asked_ = 0, done_ = 0;
  Status shown_;
  std::int64_t anchor_offset_ = 0;
  hal::Time anchor_at_;

  hal::WakeWord changed_{0};
  std::atomic<bool> end_{false};
  std::unique_ptr<hal::Thread> thread_;
};

}  // namespace sinew::record
