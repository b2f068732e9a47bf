#pragma once
#include <atomic>
#include <condition_variable>
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

#include "images/encode.hpp"
#include "monitor/foxglove/robot.hpp"
#include "monitor/robot_link.hpp"
#include "tap/client.hpp"

namespace sinew::monitor {

/// One robot for all sessions of the Foxglove protocol: its topics, read in place and encoded once however many
/// subscribe, its pictures as JPEG when a viewer can take one, and reports that are asked of its socket. Nothing is
/// read, encoded or asked that nobody subscribed to. Thread:  any, except where it says otherwise.
class RobotFeed final : public foxglove::Robot, public std::enable_shared_from_this<RobotFeed> {
 public:
  /// What connecting gives. It waits for the robot.
  struct Parts {
    std::unique_ptr<tap::Client> client{};
    const tap::SegmentReader* reader = nullptr;          // null: this run has no shared memory
    std::vector<std::optional<std::uint32_t>> topics{};  // by channel; nothing: a report
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
  /// The robot has let go of this connection: open another feed.
  bool is_broken() const { return broken_.load(std::memory_order_relaxed); }
  /// Asks for reports that are due. Call ten times a second, by one thread.
  void tick();

  struct Counters {
    std::uint64_t encoded = 0, torn = 0, pictures = 0;  // messages; overwritten while they were read; JPEGs
  };
  Counters counters() const;

 private:
  using Inboxes = std::vector<std::shared_ptr<foxglove::Inbox>>;
  struct Subscriber {
    std::size_t channel;
    std::shared_ptr<foxglove::Inbox> inbox;
  };
  /// A viewer of pictures. mutex_, but for the first two.
  struct Viewer {
    std::uint32_t topic;
    std::shared_ptr<foxglove::Inbox> inbox;
    bool wanted = false;
    foxglove::PictureSize size{};
    std::optional<std::uint32_t> last{};  // sequence of the last picture
  };
  struct Handle;
  struct Tap;
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
  void remove(const std::shared_ptr<Viewer>& viewer);
  void read();
  bool subscribe_bells();
  void take_changes();
  bool read(std::uint32_t topic, Topic& state);
  bool put(const tap::Message& message, const Inboxes& to);
  Bytes encode(const tap::Message& message);
  Bytes encode_image(const tap::Message& message) const;
  void show();
  std::optional<foxglove::Item> show(const Viewer& viewer, std::uint32_t& sequence);
  std::optional<foxglove::Item> encode_picture(const tap::Message& message, const foxglove::PictureSize& size);
  Inboxes inboxes_of(std::size_t channel) const;  // mutex_ is held
  void ask_for(std::size_t channel);
  void received(std::size_t channel, const std::string& reply);
  std::uint64_t message_time(std::int64_t robot_ns) const {
    return static_cast<std::uint64_t>(robot_ns + parts_.facts.unix_ns);
  }

  Parts parts_;
  const std::weak_ptr<RobotLink> link_;
  std::atomic<bool> broken_{false};
  mutable std::mutex mutex_;  // of the members up to the next remark
  std::condition_variable changed_;
  bool stop_ = false;
  std::uint32_t changes_ = 0;  // counts those of the next two
  std::list<Subscriber> subscribers_;
  std::vector<std::shared_ptr<Viewer>> viewers_;
  std::map<std::size_t, Report> reports_;  // by channel
  unsigned ticks_ = 0;
  std::int64_t time_ns_ = 0;  // the robot's
  Counters counters_;
  // The reading thread's.
  std::uint32_t seen_changes_ = 0;
  std::vector<std::string> bells_;  // subscribed
  std::map<std::uint32_t, Topic> topics_;
  std::vector<std::max_align_t> scratch_;
  // The picture thread's.
  images::Encoder encoder_;
  struct Encoded {
    std::uint32_t topic, sequence;
    foxglove::PictureSize size;
    foxglove::Item item;
  };
  std::vector<Encoded> encoded_;  // of one round

  std::thread reader_, shower_;
};

}  // namespace sinew::monitor
