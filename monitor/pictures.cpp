#include "monitor/pictures.hpp"

#include <fmt/format.h>

#include "monitor/picture_request.hpp"

namespace sinew::monitor {
namespace {

std::string entity_tag(const Picture& picture) {
  return fmt::format("\"{:x}-{:x}\"", picture.sequence, static_cast<std::uint64_t>(picture.stamp_ns));
}

Response picture_response(const Request& request, const Picture& picture, images::Kind kind) {
  if (!picture.why.empty()) return plain(400, picture.why);
  Response r;
  r.media_type = images::media_type(kind);
  r.headers = {{"etag", entity_tag(picture)},
               {"cache-control", "no-cache"},
               {"x-sinew-stamp-ns", std::to_string(picture.stamp_ns)},
               {"x-sinew-sequence", std::to_string(picture.sequence)}};
  if (request.if_none_match == entity_tag(picture))
    r.status = 304;
  else
    r.body = picture.bytes;
  return r;
}

/// The movie of one viewer: always the newest picture, never one twice.
class Movie final : public Stream {
 public:
  Movie(std::shared_ptr<ImageStream> stream, std::shared_ptr<ImageStream::Viewer> viewer)
      : stream_(std::move(stream)), viewer_(std::move(viewer)) {}
  Bytes next() override {
    const Picture picture = viewer_->newest();
    if (picture.serial == shown_) return nullptr;
    shown_ = picture.serial;
    failed_ = !picture.why.empty();
    return picture.bytes;
  }
  bool is_over() const override { return failed_ || stream_->is_gone(); }

 private:
  const std::shared_ptr<ImageStream> stream_;
  const std::shared_ptr<ImageStream::Viewer> viewer_;
  std::uint64_t shown_ = 0;
  bool failed_ = false;
};

/// A request for one picture that waits for it.
struct OnePicture {
  Request request;
  images::Kind kind = images::Kind::jpeg;
  std::shared_ptr<ImageStream> stream{};
  std::shared_ptr<ImageStream::Viewer> viewer{};
  Server::Reply reply{};  // empty: answered

  void look() {
    if (!reply) return;
    const Picture picture = viewer->newest();
    if (picture.serial > 0) return answer(picture_response(request, picture, kind));
    if (stream->is_gone()) answer(plain(410, "the robot has ended"));
  }
  void answer(Response response) {
    if (!reply) return;
    reply(std::move(response));
    reply = nullptr;
    viewer.reset(), stream.reset();
  }
};

}  // namespace

void ImageStreams::with(const std::string& robot, const std::string& topic, WithStream what) {
  const Key key{robot, topic};
  const auto known = entries_.find(key);
  if (known != entries_.end() && !known->second.stream->is_gone()) {
    known->second.used = std::chrono::steady_clock::now();
    return what(known->second.stream, "");
  }
  const auto link = robots_.find(robot);
  if (!link) return what(nullptr, fmt::format("no robot '{}' runs", robot));
  if (entries_.size() >= kMost && known == entries_.end())
    return what(nullptr, fmt::format("{} topics are being shown already", entries_.size()));
  const bool taken = link->post([this, key, what] {  // connecting waits for the robot
    std::string why;
    std::shared_ptr<ImageStream> stream = ImageStream::open(key.first, key.second, why);
    server_.post([this, key, what, stream, why] {
      if (!stream) return what(nullptr, why);
      Entry& entry = entries_[key];
      if (!entry.stream || entry.stream->is_gone()) entry.stream = stream;
      entry.used = std::chrono::steady_clock::now();
      if (!letting_go_) let_go();
      what(entry.stream, "");
    });
  });
  if (!taken) what(nullptr, "too many requests wait for this robot");
}

void ImageStreams::let_go() {
  const auto now = std::chrono::steady_clock::now();
  for (auto at = entries_.begin(); at != entries_.end();) {
    Entry& e = at->second;
    if (!e.stream->is_gone() && (e.stream.use_count() > 1 || now - e.used <= kIdle)) {
      ++at;
      continue;
    }
    undertaker_.post([stream = std::move(e.stream)]() mutable { stream.reset(); });
    at = entries_.erase(at);
  }
  letting_go_ = !entries_.empty();
  if (letting_go_) server_.after(kIdle, [this] { let_go(); });
}

bool Pictures::answer(const Request& request, ConnectionId connection, const Server::Reply& reply) {
  bool is_picture = false;
  std::string why;
  const auto wanted = parse_picture_request(request, is_picture, why);
  if (!is_picture) return false;
  if (!wanted) {
    reply(plain(400, why));
    return true;
  }
  streams_.with(wanted->robot, wanted->topic,
                [this, request, connection, recipe = wanted->recipe, is_movie = wanted->movie, reply](
                    std::shared_ptr<ImageStream> stream, const std::string& reason) {
                  if (!stream) return reply(plain(404, reason));
                  if (is_movie) return movie(recipe, connection, std::move(stream), reply);
                  one(request, recipe, std::move(stream), reply);
                });
  return true;
}

void Pictures::movie(const Recipe& recipe, ConnectionId connection, std::shared_ptr<ImageStream> stream,
                     const Server::Reply& reply) {
  auto viewer = stream->look(recipe, [server = &server_, connection] { server->wake(connection); });
  Response r;
  r.media_type = std::string("multipart/x-mixed-replace; boundary=") + kPartBoundary;
  r.headers = {{"cache-control", "no-store"}};
  r.stream = std::make_unique<Movie>(std::move(stream), std::move(viewer));
  reply(std::move(r));
}

void Pictures::one(const Request& request, const Recipe& recipe, std::shared_ptr<ImageStream> stream,
                   const Server::Reply& reply) {
  const auto one = std::make_shared<OnePicture>();
  one->request = request, one->kind = recipe.kind, one->stream = stream, one->reply = reply;
  const std::weak_ptr<OnePicture> waiting = one;
  one->viewer = stream->look(recipe, [server = &server_, waiting] {
    server->post([waiting] {
      if (const auto here = waiting.lock()) here->look();
    });
  });
  one->look();
  if (one->reply) server_.after(kFirst, [one] { one->answer(plain(503, "no picture came within 2 s")); });
}

}  // namespace sinew::monitor
