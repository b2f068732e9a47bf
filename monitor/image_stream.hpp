#pragma once
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "images/encode.hpp"
#include "monitor/http/server.hpp"
#include "tap/client.hpp"

namespace sinew::monitor {

inline constexpr const char* kPartBoundary = "sinew-picture";  // of a multipart movie

/// How a viewer wants its pictures.
struct Recipe {
  images::Kind kind = images::Kind::jpeg;
  images::Cut cut{};
  images::EncodeOptions options{};
  bool as_part = false;  // with the head and end of a part of a multipart movie
  bool operator==(const Recipe&) const = default;
};

struct Picture {
  std::uint64_t serial = 0;  // counts the pictures of its recipe; 0: none yet
  std::uint32_t sequence = 0;
  std::int64_t stamp_ns = 0;
  Bytes bytes{};
  std::string why{};  // instead of bytes: it could not be encoded
};

/// The pictures of one topic of one robot, read in place and encoded once for each recipe, however many look. Without
/// viewers its thread sleeps and the topic is not subscribed.
/// Thread:  any.
class ImageStream {
 public:
  /// One look at the stream; gone with its last copy.
  class Viewer {
   public:
    virtual ~Viewer() = default;
    virtual Picture newest() const = 0;
  };
  /// Called by the stream's thread for each new picture of the viewer's recipe; must not wait.
  using OnNew = std::function<void()>;

  /// Errors: null, with `why`: the robot is gone, has no such topic (`allowed` names those of pictures), or no shared
  /// memory.
  static std::shared_ptr<ImageStream> open(const std::string& robot, const std::string& topic, std::string& why);
  virtual ~ImageStream() = default;

  /// The newest picture comes at once, if there is any.
  virtual std::shared_ptr<Viewer> look(const Recipe& recipe, OnNew on_new) = 0;
  virtual bool is_gone() const = 0;  // the robot has ended

  struct Counters {
    std::uint64_t seen = 0, encoded = 0, torn = 0;  // messages; pictures of all recipes; overwritten while encoded
  };
  virtual Counters counters() const = 0;
};

}  // namespace sinew::monitor
