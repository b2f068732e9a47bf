#include "monitor/pictures.hpp"

#include <fmt/format.h>

#include <mutex>
#include <utility>

#include "monitor/picture_request.hpp"

namespace sinew::monitor {
namespace {

constexpr std::string_view kBoundary = "sinew-picture";  // of a multipart movie

std::string entity_tag(const Picture& picture) {
  return fmt::format("\"{:x}-{:x}\"", picture.sequence, static_cast<std::uint64_t>(picture.stamp_ns));
}

Response picture_response(const Request& request, const Picture& picture, images::Kind kind) {
  if (!picture.file) return plain(400, picture.why);
  Response r;
  r.media_type = images::media_type(kind);
  r.headers = {{"etag", entity_tag(picture)},
               {"cache-control", "no-cache"},
               {"x-sinew-stamp-ns", std::to_string(picture.stamp_ns)},
               {"x-sinew-sequence", std::to_string(picture.sequence)}};
  if (request.if_none_match == entity_tag(picture))
    r.status = 304;
  else
    r.body = picture.file;
  return r;
}

/// What the picture thread hands to the server's.
struct Slot {
  std::mutex mutex{};
  std::shared_ptr<const Picture> picture{};
  bool over = false;  // the robot has ended

  void put(const std::shared_ptr<const Picture>& next) {
    const std::lock_guard lock(mutex);
    picture = next, over = over || !next;
  }
  std::shared_ptr<const Picture> take() {
    const std::lock_guard lock(mutex);
    return std::exchange(picture, nullptr);
  }
  bool is_over() {
    const std::lock_guard lock(mutex);
    return over && !picture;
  }
};

/// The movie of one viewer: a picture is asked for when the connection can take one, so that each is the newest.
class Movie final : public Stream {
 public:
  Movie(const std::shared_ptr<RobotPictures>& pictures, std::uint32_t topic, Recipe recipe, std::function<void()> wake)
      : recipe_(std::move(recipe)), slot_(std::make_shared<Slot>()) {
    viewer_ = RobotPictures::look(pictures, topic, [slot = slot_, wake = std::move(wake)](const auto& picture) {
      slot->put(picture);
      wake();
      return true;
    });
  }
  std::optional<Piece> next() override {
    const auto picture = slot_->take();
    if (!picture) {
      if (!wants_) viewer_->want(recipe_);
      wants_ = true;
      return std::nullopt;
    }
    wants_ = false;
    failed_ = !picture->file;
    if (failed_) return std::nullopt;
    Piece piece;
    if (!begun_) piece.head = fmt::format("--{}\r\n", kBoundary);
    begun_ = true;
    piece.head += fmt::format("content-type: {}\r\ncontent-length: {}\r\n\r\n", images::media_type(recipe_.kind),
                              picture->file->size());
    piece.bytes = picture->file;
    // Browsers show a picture when the next one begins.
    piece.tail = fmt::format("\r\n--{}\r\n", kBoundary);
    return piece;
  }
  bool is_over() const override { return failed_ || slot_->is_over(); }

 private:
  const Recipe recipe_;
  const std::shared_ptr<Slot> slot_;
  std::shared_ptr<RobotPictures::Viewer> viewer_;
  bool wants_ = false, begun_ = false, failed_ = false;
};

/// A request for one picture that waits for it.
struct OnePicture {
  Request request;
  images::Kind kind = images::Kind::jpeg;
  Server::Reply reply{};  // empty: answered
  std::shared_ptr<RobotPictures::Viewer> viewer{};

  void answer(Response response) {
    if (!reply) return;
    reply(std::move(response));
    reply = nullptr;
    viewer.reset();
  }
};

void send_one(Server& server, const std::shared_ptr<RobotPictures>& pictures, std::uint32_t topic,
              const Request& request, const Recipe& recipe, const Server::Reply& reply) {
  const auto one = std::make_shared<OnePicture>();
  one->request = request, one->kind = recipe.kind, one->reply = reply;
  one->viewer =
      RobotPictures::look(pictures, topic, [server = &server, weak = std::weak_ptr(one)](const auto& picture) {
        server->post([weak, picture] {
          const auto here = weak.lock();
          if (here)
            here->answer(picture ? picture_response(here->request, *picture, here->kind)
                                 : plain(410, "the robot has ended"));
        });
        return true;
      });
  one->viewer->want(recipe);
  server.after(Pictures::kFirst, [one] { one->answer(plain(503, "no picture came within 2 s")); });
}

}  // namespace

bool Pictures::answer(const Request& request, ConnectionId connection, const Server::Reply& reply) {
  bool is_picture = false;
  std::string why;
  const auto wanted = parse_picture_request(request, is_picture, why);
  if (!is_picture) return false;
  if (!wanted) {
    reply(plain(400, why));
    return true;
  }
  feeds_.with(wanted->robot, [server = &server_, request, connection, wanted = *wanted, reply](
                                 const std::shared_ptr<RobotFeed>& feed, const std::string& reason) {
    if (!feed) return reply(plain(404, reason));
    const auto pictures = feed->pictures();
    if (!pictures) return reply(plain(404, wanted.robot + ": keeps its topics in memory of its own"));
    std::string none;
    const auto topic = pictures->find(wanted.topic, none);
    if (!topic) return reply(plain(404, wanted.robot + ": " + none));
    if (!wanted.movie) return send_one(*server, pictures, *topic, request, wanted.recipe, reply);
    Response r;
    r.media_type = fmt::format("multipart/x-mixed-replace; boundary={}", kBoundary);
    r.headers = {{"cache-control", "no-store"}};
    r.stream =
        std::make_unique<Movie>(pictures, *topic, wanted.recipe, [server, connection] { server->wake(connection); });
    reply(std::move(r));
  });
  return true;
}

}  // namespace sinew::monitor
