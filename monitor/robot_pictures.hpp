#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "images/encode.hpp"
#include "monitor/http/server.hpp"
#include "monitor/robot_topics.hpp"

namespace sinew::monitor {

/// How a viewer wants a picture.
struct Recipe {
  images::Kind kind = images::Kind::jpeg;
  images::Cut cut{};
  images::EncodeOptions options{};
  bool operator==(const Recipe&) const = default;
};

/// One message as a file.
struct Picture {
  std::uint32_t sequence = 0;                   // of the message
  std::int64_t stamp_ns = 0, published_ns = 0;  // the robot's clock
  Bytes file{};
  std::string why{};  // instead of the file: it could not be encoded
};

/// The pictures of one robot: the newest message of each topic of images, encoded when a viewer wants it, once for each
/// recipe however many want it. Nothing is encoded that nobody wants.
/// Thread:  any.
class RobotPictures {
 public:
  explicit RobotPictures(RobotTopics& topics);
  ~RobotPictures();
  RobotPictures(const RobotPictures&) = delete;
  RobotPictures& operator=(const RobotPictures&) = delete;

  /// The topic of images of this name. Errors: nothing, with `why`, which names those that there are.
  std::optional<std::uint32_t> find(std::string_view topic, std::string& why) const;

  /// Called by the picture thread, for each want(); must not wait. Null, also unasked: the robot has ended. False: this
  /// one is no use, the viewer still wants one.
  using OnPicture = std::function<bool(const std::shared_ptr<const Picture>& picture)>;
  /// One who looks at a topic; gone with its last copy. A call may still be under way then.
  class Viewer {
   public:
    virtual ~Viewer() = default;
    /// The newest picture, when there is one that is newer than the last one it got.
    virtual void want(const Recipe& recipe) = 0;
  };
  static std::shared_ptr<Viewer> look(std::shared_ptr<RobotPictures> pictures, std::uint32_t topic,
                                      OnPicture on_picture);

  struct Counters {
    std::uint64_t encoded = 0, torn = 0;  // pictures of all recipes; overwritten while they were read
  };
  Counters counters() const;

 private:
  /// mutex_, but for the first two.
  struct Seat {
    std::uint32_t topic;
    OnPicture on_picture;
    bool wants = false;
    Recipe recipe{};
    std::optional<std::uint32_t> last{};  // sequence
  };
  struct Look;
  using Seats = std::vector<std::shared_ptr<Seat>>;
  using PicturePtr = std::shared_ptr<const Picture>;
  struct Newest {  // all that was encoded of the newest message of a topic
    std::uint32_t sequence = 0;
    std::vector<std::pair<Recipe, PicturePtr>> pictures{};
  };

  void serve();
  bool serve(Seat& seat, const Recipe& recipe, std::optional<std::uint32_t> last);
  PicturePtr newest(std::uint32_t topic, const Recipe& recipe, std::optional<std::uint32_t> last);
  PicturePtr encode(const tap::Message& message, const Recipe& recipe);
  void end();

  RobotTopics& topics_;
  RobotTopics::Waiter waiter_;
  mutable std::mutex mutex_;  // of the next four
  bool stop_ = false;
  Seats seats_;
  std::vector<std::uint32_t> followed_;  // topics whose messages wake the thread
  Counters counters_;
  // The picture thread's.
  std::optional<hal::Time> forgets_at_{};  // topics that nobody looks at any more
  images::Encoder encoder_;
  std::map<std::uint32_t, Newest> newest_;  // by topic
  std::thread thread_;
};

}  // namespace sinew::monitor
