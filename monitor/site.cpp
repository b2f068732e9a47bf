#include "monitor/site.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "monitor/picture_request.hpp"

namespace sinew::monitor {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kApi = "/api/robots";
constexpr const char* kJsonType = "application/json";
// Requests of docs/robot-socket.md that change nothing; those that hand out memory are for programs of this machine.
constexpr std::string_view kLooks[] = {"hello", "topics", "status", "params", "timeline", "record.status"};
constexpr std::string_view kOfMemory[] = {"memory", "doorbells", "subscribe"};

std::string to_text(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

Response json_response(int status, const std::string& text) {
  Response r;
  r.status = status, r.media_type = kJsonType, r.body = bytes_of(text + "\n");
  r.headers = {{"cache-control", "no-store"}};
  return r;
}

Response json_error(int status, const char* code, std::string_view why) {
  return json_response(status, to_text({{"ok", false}, {"error", {{"code", code}, {"why", why}}}}));
}

int status_of(const Json& reply) {
  static constexpr std::pair<std::string_view, int> kStatus[] = {
      {"not_found", 404}, {"busy", 409},    {"denied", 403}, {"not_supported", 501}, {"bad_argument", 400},
      {"bad_data", 502},  {"timeout", 504}, {"closed", 410}, {"out_of_memory", 503}};
  if (reply.value("ok", false)) return 200;
  const auto error = reply.find("error");
  const std::string code = error != reply.end() && error->is_object() ? error->value("code", "") : "";
  for (const auto& [name, status] : kStatus)
    if (name == code) return status;
  return 500;
}

/// "last_ms=100" as a number, other values as text.
Json arguments_of(const Request& request) {
  Json arguments = Json::object();
  for (const auto& [name, value] : request.query) {
    Json number = Json::parse(value, nullptr, false);
    arguments[name] = number.is_number() || number.is_boolean() ? number : Json(value);
  }
  return arguments;
}

std::string entity_tag(const Picture& picture) {
  return fmt::format("\"{:x}-{:x}\"", picture.sequence, static_cast<std::uint64_t>(picture.stamp_ns));
}

Response picture_response(const Request& request, const Picture& picture, images::Kind kind) {
  if (!picture.why.empty()) return plain(400, picture.why);
  Response r;
  r.media_type = images::media_type(kind);
  r.headers = {{"etag", entity_tag(picture)},
               {"cache-control", "no-cache"},
               {"x-stamp-ns", std::to_string(picture.stamp_ns)},
               {"x-sequence", std::to_string(picture.sequence)}};
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

Headers protective_headers() {
  return {{"content-security-policy",
           "default-src 'self'; img-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; connect-src 'self'; "
           "object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
          {"x-content-type-options", "nosniff"},
          {"x-frame-options", "DENY"},
          {"referrer-policy", "no-referrer"},
          {"cross-origin-resource-policy", "same-origin"}};
}

void Site::answer(Request request, ConnectionId connection, Server::Reply reply) {
  if (auto refusal = gate_.refuses(request)) return reply(std::move(*refusal));
  const bool reads = request.method == "GET" || request.method == "HEAD";
  if (request.path == kApi && reads) return robots(std::move(reply));
  if (request.path.starts_with(std::string(kApi) + "/")) return ask_robot(request, std::move(reply));
  if (!reads) {
    Response r = plain(405, "only GET and HEAD here");
    r.headers = {{"allow", "GET, HEAD"}};
    return reply(std::move(r));
  }
  picture(request, connection, std::move(reply));
}

void Site::robots(Server::Reply reply) const {
  Json list = Json::array();
  for (const auto& link : robots_.all()) {
    Json robot = Json::parse(link->hello(), nullptr, false);
    if (!robot.is_object()) continue;
    robot.erase("ok");
    list.push_back(std::move(robot));
  }
  Json whole{{"ok", true}, {"robots", std::move(list)}};
  if (const std::string problem = robots_.problem(); !problem.empty()) whole["problem"] = problem;
  reply(json_response(200, to_text(whole)));
}

void Site::ask_robot(const Request& request, Server::Reply reply) {
  const std::string_view rest = std::string_view(request.path).substr(kApi.size() + 1);
  const std::size_t slash = rest.find('/');
  const std::string robot(rest.substr(0, slash));
  const std::string what(slash == std::string_view::npos ? "hello" : rest.substr(slash + 1));
  const bool looks = std::find(std::begin(kLooks), std::end(kLooks), what) != std::end(kLooks);
  const bool reads = request.method == "GET" || request.method == "HEAD";
  if (std::find(std::begin(kOfMemory), std::end(kOfMemory), what) != std::end(kOfMemory))
    return reply(json_error(403, "denied", what + ": for programs of the robot's machine only"));
  Json arguments;
  if (reads) {
    if (!looks)
      return reply(json_error(405, "bad_argument",
                              fmt::format("{}: GET only looks ({}); POST changes", what, fmt::join(kLooks, ", "))));
    arguments = arguments_of(request);
  } else if (request.method == "POST") {
    if (auto refusal = gate_.refuses_command(request)) return reply(std::move(*refusal));
    // Forms of other sites cannot send this type without asking first, which nobody here permits.
    if (!request.content_type.starts_with(kJsonType))
      return reply(json_error(415, "bad_argument", "the body's content-type has to be application/json"));
    arguments = request.body.empty() ? Json::object() : Json::parse(request.body, nullptr, false);
    if (!arguments.is_object()) return reply(json_error(400, "bad_argument", "the body has to be a JSON object"));
  } else {
    return reply(json_error(405, "bad_argument", "GET looks, POST changes"));
  }
  const auto link = robots_.find(robot);
  if (!link) return reply(json_error(404, "not_found", fmt::format("no robot '{}' runs", robot)));
  link->ask(what, to_text(arguments), [reply = std::move(reply)](const std::string& answer) {
    const Json json = Json::parse(answer, nullptr, false);
    if (json.is_object())
      reply(json_response(status_of(json), answer));
    else
      reply(json_error(502, "bad_data", "the robot's reply is no JSON object"));
  });
}

void Site::picture(const Request& request, ConnectionId connection, Server::Reply reply) {
  bool is_picture = false;
  std::string why;
  const auto wanted = parse_picture_request(request, is_picture, why);
  if (!is_picture) return reply(plain(404, "nothing here; GET /api/robots lists the robots"));
  if (!wanted) return reply(plain(400, why));
  with_stream(wanted->robot, wanted->topic,
              [this, request, connection, recipe = wanted->recipe, movie = wanted->movie, reply = std::move(reply)](
                  std::shared_ptr<ImageStream> stream, const std::string& reason) {
                if (!stream) return reply(plain(404, reason));
                Server* const server = server_;
                if (movie) {
                  auto viewer = stream->look(recipe, [server, connection] { server->wake(connection); });
                  Response r;
                  r.media_type = std::string("multipart/x-mixed-replace; boundary=") + kPartBoundary;
                  r.headers = {{"cache-control", "no-store"}};
                  r.stream = std::make_unique<Movie>(stream, std::move(viewer));
                  return reply(std::move(r));
                }
                const auto one = std::make_shared<OnePicture>();
                one->request = request, one->kind = recipe.kind, one->stream = stream, one->reply = reply;
                const std::weak_ptr<OnePicture> waiting = one;
                one->viewer = stream->look(recipe, [server, waiting] {
                  server->post([waiting] {
                    if (const auto here = waiting.lock()) here->look();
                  });
                });
                one->look();
                if (one->reply)
                  server->after(kFirstPicture, [one] { one->answer(plain(503, "no picture came within 2 s")); });
              });
}

void Site::with_stream(const std::string& robot, const std::string& topic, WithStream what) {
  const StreamKey key{robot, topic};
  const auto known = streams_.find(key);
  if (known != streams_.end() && !known->second.stream->is_gone()) {
    known->second.used = std::chrono::steady_clock::now();
    return what(known->second.stream, "");
  }
  const auto link = robots_.find(robot);
  if (!link) return what(nullptr, fmt::format("no robot '{}' runs", robot));
  if (streams_.size() >= kMostStreams && known == streams_.end())
    return what(nullptr, fmt::format("{} topics are being shown already", streams_.size()));
  Server* const server = server_;
  const bool taken = link->post([this, server, key, what] {  // connecting waits for the robot
    std::string why;
    std::shared_ptr<ImageStream> stream = ImageStream::open(key.first, key.second, why);
    server->post([this, key, what, stream, why] {
      if (!stream) return what(nullptr, why);
      StreamEntry& entry = streams_[key];
      if (!entry.stream || entry.stream->is_gone()) entry.stream = stream;
      entry.used = std::chrono::steady_clock::now();
      if (!sweeping_) sweep();
      what(entry.stream, "");
    });
  });
  if (!taken) what(nullptr, "too many requests wait for this robot");
}

void Site::sweep() {
  const auto now = std::chrono::steady_clock::now();
  for (auto at = streams_.begin(); at != streams_.end();) {
    StreamEntry& e = at->second;
    if (!e.stream->is_gone() && (e.stream.use_count() > 1 || now - e.used <= kStreamIdle)) {
      ++at;
      continue;
    }
    undertaker_.post([stream = std::move(e.stream)]() mutable { stream.reset(); });
    at = streams_.erase(at);
  }
  sweeping_ = !streams_.empty();
  if (sweeping_) server_->after(kStreamIdle, [this] { sweep(); });
}

}  // namespace sinew::monitor
