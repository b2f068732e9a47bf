#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "monitor/foxglove/inbox.hpp"
#include "monitor/foxglove/protocol.hpp"

namespace sinew::foxglove {

struct Channel {
  enum class Kind : std::uint8_t { messages, pictures, report };  // report: JSON that the monitor asks for
  std::string topic{}, encoding{}, schema_name{}, schema{}, schema_encoding{};  // topic: "/imu.raw", without the robot
  Kind kind = Kind::messages;
  bool is_small = false;  // its messages are: the last ones wait for a connection, so that a plot has no holes
};

/// How a viewer wants its pictures.
struct PictureSize {
  int quality = 80;  // of JPEG
  double scale = 1;
  bool operator==(const PictureSize&) const = default;
};

/// What a session knows of a robot once, when it appears.
struct RobotFacts {
  std::string name{};
  std::vector<Channel> channels{};
  Ends published{}, subscribed{};       // topics without the robot; modules
  std::vector<std::string> requests{};  // of the robot's socket, as services
  std::vector<std::string> external{};  // topics that publish writes, without '/'
  std::vector<std::string> threads{};
  std::int64_t unix_ns = 0;  // added to the robot's clock for the times of messages
  bool own_clock = false;    // its time is not this machine's: virtual, or recorded
  std::optional<std::pair<std::uint64_t, std::uint64_t>> recorded_ns{};  // begin and end, of a recorded run
};

/// One picture at a time for one viewer, encoded when it is wanted.
/// Thread:  any.
class PictureTap {
 public:
  virtual ~PictureTap() = default;
  /// The next picture is to be one that is newer than the last one; it comes to the inbox.
  virtual void want(const PictureSize& size) = 0;
};

/// A robot that runs, or a recorded run that stands up as one.
/// Thread:  any.
class Robot {
 public:
  /// The reply of docs/robot-socket.md. From any thread, also at once.
  using Done = std::function<void(std::string reply)>;
  virtual ~Robot() = default;
  virtual const RobotFacts& facts() const = 0;
  /// Messages of this channel go to the inbox until the returned object is destroyed.
  virtual std::shared_ptr<void> subscribe(std::size_t channel, std::shared_ptr<Inbox> inbox) = 0;
  virtual std::shared_ptr<PictureTap> look(std::size_t channel, std::shared_ptr<Inbox> inbox) = 0;
  virtual void ask(std::string request, std::string arguments, Done done) = 0;
  /// The reply to `status`, which may be a fifth of a second old: one for all who look.
  virtual void recent_status(Done done) = 0;
  /// The newest instant on the robot's own clock that is known here, as times of messages.
  virtual std::uint64_t time_ns() const = 0;
};

}  // namespace sinew::foxglove
