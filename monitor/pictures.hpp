#pragma once
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "monitor/http/server.hpp"
#include "monitor/image_stream.hpp"
#include "monitor/robots.hpp"

namespace sinew::monitor {

/// Topics of images, each read by one stream however many look. Lets go of those that nobody looks at.
/// Thread:  the server's. Nothing here waits for a robot.
class ImageStreams {
 public:
  using WithStream = std::function<void(std::shared_ptr<ImageStream> stream, const std::string& why)>;
  ImageStreams(Robots& robots, Server& server) : robots_(robots), server_(server) {}

  /// Calls `what` once, now or later, with the stream, or with null and why.
  void with(const std::string& robot, const std::string& topic, WithStream what);

  static constexpr std::chrono::seconds kIdle{5};  // then a topic that nobody looks at is let go
  static constexpr std::size_t kMost = 64;

 private:
  using Key = std::pair<std::string, std::string>;  // robot, topic
  struct Entry {
    std::shared_ptr<ImageStream> stream{};
    std::chrono::steady_clock::time_point used{};
  };
  void let_go();

  Robots& robots_;
  Server& server_;
  Worker undertaker_{SIZE_MAX};  // ends streams, whose threads may have to be waited for
  std::map<Key, Entry> entries_;
  bool letting_go_ = false;
};

/// Pictures over HTTP: /ROBOT/images/TOPIC.KIND.
/// Thread:  the server's.
class Pictures {
 public:
  Pictures(ImageStreams& streams, Server& server) : streams_(streams), server_(server) {}
  /// False: the path is none of a picture, and `reply` was not used.
  bool answer(const Request& request, ConnectionId connection, const Server::Reply& reply);

  static constexpr std::chrono::milliseconds kFirst{2000};  // patience for the first picture

 private:
  void movie(const Recipe& recipe, ConnectionId connection, std::shared_ptr<ImageStream> stream,
             const Server::Reply& reply);
  void one(const Request& request, const Recipe& recipe, std::shared_ptr<ImageStream> stream,
           const Server::Reply& reply);

  ImageStreams& streams_;
  Server& server_;
};

}  // namespace sinew::monitor
