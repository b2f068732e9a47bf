#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "monitor/foxglove/robot.hpp"
#include "monitor/robot_link.hpp"
#include "monitor/robot_pictures.hpp"
#include "monitor/robot_topics.hpp"

namespace sinew::monitor {

/// One robot for all who look at it: its topics, read in place and encoded once however many subscribe, its pictures
/// when a viewer can take one, and reports that are asked of its socket. Nothing is read, encoded or asked that nobody
/// subscribed to. Thread:  any, except where it says otherwise.
class RobotFeed final : public foxglove::Robot, public std::enable_shared_from_this<RobotFeed> {
 public:
  /// What connecting gives. It waits for the robot.
  struct Parts {
    std::unique_ptr<RobotTopics> topics{};                 // null: this run has no shared memory
    std::vector<std::optional<std::uint32_t>> topic_of{};  // by channel; nothing: a report
    foxglove::RobotFacts facts{};
  };
  /// `hello`: the robot's reply. Errors: nothing, with `why`.
  static std::optional<Parts> connect(const std::string& robot, const std::string& hello, std::string& why);

  /// The link may end before the feed.
  RobotFeed(Parts parts, std::weak_ptr<RobotLink> link);
  ~RobotFeed() override;

  const foxglove::RobotFacts& facts() const override { return parts_.facts; }
  std::shared_ptr<void> subscribe(std::size_t channel, std::shared_ptr<foxglove::Inbox> inbox) override;
  std::shared_ptr<foxglove::PictureTap> look(std::size_t channel, std::shared_ptr<foxglove::Inbox> inbox) override;
  void ask(std::string request, std::string arguments, Done done) override;
  void recent_status(Done done) override;
  std::uint64_t time_ns() const override;
  /// Null: this run has no shared memory. Keeps the feed, too.
  std::shared_ptr<RobotPictures> pictures();
  /// The robot has ended or let go of this connection: open another feed.
  bool is_gone() const { return parts_.topics && parts_.topics->is_gone(); }
  /// Asks for reports that are due. Call ten times a second, by one thread.
  void tick();

  struct Counters {
    std::uint64_t encoded = 0, torn = 0;  // messages; overwritten while they were read
  };
  Counters counters() const;

 private:
  using Inboxes = std::vector<std::shared_ptr<foxglove::Inbox>>;
  struct Subscriber {
    std::size_t channel;
    std::shared_ptr<foxglove::Inbox> inbox;
  };
  struct Handle;
  struct Topic {
    tap::Cursor cursor{};
    bool any = false;
    std::uint32_t last = 0;  // sequence that was sent last
    Inboxes inboxes{};
  };
  struct Report {
    const char *request, *arguments;
    unsigned every;  // ticks
    bool asked = false;
  };

  void remove(std::list<Subscriber>::iterator subscriber);
  void read();
  bool take_changes();
  bool read(std::uint32_t topic, Topic& state);
  bool put(const tap::Message& message, const Inboxes& to);
  Bytes encode(const tap::Message& message);
  Bytes encode_image(const tap::Message& message) const;
  foxglove::Item item_of(const Picture& picture, std::uint32_t topic);
  Inboxes inboxes_of(std::size_t channel) const;  // mutex_ is held
  void ask_for(std::size_t channel);
  void received(std::size_t channel, const std::string& reply);
  std::uint64_t message_time(std::int64_t robot_ns) const {
    return static_cast<std::uint64_t>(robot_ns + parts_.facts.unix_ns);
  }

  Parts parts_;
  const std::weak_ptr<RobotLink> link_;
  mutable std::mutex mutex_;  // of the members up to the next remark
  bool stop_ = false;
  std::uint32_t changes_ = 0;  // counts those of the next one
  std::list<Subscriber> subscribers_;
  std::map<std::size_t, Report> reports_;  // by channel
  unsigned ticks_ = 0;
  std::int64_t time_ns_ = 0;  // the robot's
  Counters counters_;
  // The reading thread's.
  std::optional<RobotTopics::Waiter> waiter_;
  std::uint32_t seen_changes_ = 0;
  std::map<std::uint32_t, Topic> topics_;
  std::vector<std::max_align_t> scratch_;

  std::thread reader_;
  std::optional<RobotPictures> pictures_;  // last: its viewers are told the robot's time
};

}  // namespace sinew::monitor
