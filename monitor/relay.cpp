#include "monitor/relay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <utility>

#include "monitor/json_reply.hpp"

namespace sinew::monitor {
namespace {

constexpr std::string_view kAt = "/at/";
// A page of another machine must not become one of ours: only what shows nothing by itself keeps its type.
constexpr std::string_view kTypes[] = {"application/json", "image/jpeg", "image/png",
                                       "image/tiff",       "image/bmp",  "multipart/x-mixed-replace",
                                       "text/plain"};
constexpr const char* kOtherType = "application/octet-stream";
constexpr std::uint16_t kTryAgain = 1013, kRefused = 1008;  // ends of WebSockets, RFC 6455 and its registry

std::string encoded(std::string_view text, std::string_view also) {
  std::string out;
  for (const char c : text) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                          std::string_view("-._~").find(c) != std::string_view::npos || also.find(c) != also.npos;
    if (is_plain)
      out += c;
    else
      out += fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return out;
}

/// What another monitor has for pages: robots, their pictures, and runs; neither its page nor other monitors of it.
bool is_relayed(std::string_view path) {
  if (path == "/api" || path.starts_with("/api/")) return true;
  const std::size_t slash = path.find('/', 1);
  return slash != std::string_view::npos && path.substr(slash).starts_with("/images/") && !path.starts_with(kAt);
}

std::string type_to_show(const std::string& type) {
  const std::string name = type.substr(0, type.find(';'));
  return std::find(std::begin(kTypes), std::end(kTypes), name) != std::end(kTypes) ? type : kOtherType;
}

Response refusal_for(std::string_view path, int status, std::string_view code, const std::string& why) {
  const bool is_api = path.find("/api") != std::string_view::npos;
  return is_api ? json_error(status, code, why) : plain(status, why);
}

}  // namespace

/// Where a request goes.
struct Relay::Route {
  const MonitorPlace* place = nullptr;
  Call call{};
};

/// All that goes through at the moment.
class Relay::Passages {
 public:
  std::set<Passage*> all{};
};

class Relay::Passage : public Client::Listener {
 public:
  Passage(std::shared_ptr<Passages> passages, std::string address)
      : passages_(std::move(passages)), address_(std::move(address)) {
    passages_->all.insert(this);
  }
  ~Passage() override { passages_->all.erase(this); }
  const std::string& address() const { return address_; }
  /// Ends it; it may be gone afterwards.
  virtual void cut(const std::string& why) = 0;

 protected:
  std::string said(const std::string& why) const { return address_ + ": " + why; }

 private:
  const std::shared_ptr<Passages> passages_;
  const std::string address_;
};

// ---- requests

/// Lives as long as its Stream; before there is one, until the answer has a head.
class Relay::ResponsePassage final : public Passage, public std::enable_shared_from_this<ResponsePassage> {
 public:
  ResponsePassage(std::shared_ptr<Passages> passages, std::string address, Server& server, ConnectionId connection,
                  std::string path, Server::Reply reply)
      : Passage(std::move(passages), std::move(address)),
        server_(server),
        id_(connection),
        path_(std::move(path)),
        reply_(std::move(reply)) {}

  void begin(Call call) {
    self_ = shared_from_this();
    is_head_only_ = call.method == "HEAD";
    connection_ = server_.client().open(std::move(call), *this);
  }

  void answered(const Client::Answer& answer) override;
  void received(const Client::Piece& piece) override {
    held_.insert(held_.end(), piece.bytes.begin(), piece.bytes.end());
    if (held_.size() >= kAhead) connection_->read(false);
    server_.wake(id_);
  }
  void ended(Client::End, const std::string& why) override {
    const auto self = std::exchange(self_, nullptr);
    is_over_ = true;
    if (reply_) return give(refusal_for(path_, 502, "io", said(why)));
    server_.wake(id_);
  }
  void cut(const std::string& why) override {
    const auto self = shared_from_this();
    if (is_over_) return;
    connection_.reset();
    ended(Client::End::lost, why);
  }

  Bytes take() {
    if (held_.empty()) return nullptr;
    auto bytes = std::make_shared<const std::vector<std::byte>>(std::exchange(held_, {}));
    if (!is_over_) connection_->read(true);
    return bytes;
  }
  bool is_over() const { return is_over_ && held_.empty(); }
  void leave() {
    is_over_ = true;
    connection_.reset();
  }

 private:
  void give(Response response) {
    const Server::Reply reply = std::exchange(reply_, nullptr);
    reply(std::move(response));
  }

  Server& server_;
  const ConnectionId id_;
  const std::string path_;
  Server::Reply reply_;  // empty: used
  std::shared_ptr<ResponsePassage> self_{};
  std::unique_ptr<Client::Connection> connection_{};
  std::vector<std::byte> held_{};
  bool is_over_ = false, is_head_only_ = false;
};

class Relay::ResponseStream final : public Stream {
 public:
  explicit ResponseStream(std::shared_ptr<ResponsePassage> passage) : passage_(std::move(passage)) {}
  ~ResponseStream() override { passage_->leave(); }
  std::optional<Piece> next() override {
    Bytes bytes = passage_->take();
    return bytes ? std::optional(Piece{{}, std::move(bytes), {}}) : std::nullopt;
  }
  bool is_over() const override { return passage_->is_over(); }

 private:
  const std::shared_ptr<ResponsePassage> passage_;
};

void Relay::ResponsePassage::answered(const Client::Answer& answer) {
  const auto self = std::exchange(self_, nullptr);  // the stream's from now on
  if (!reply_) return;
  if (answer.status >= 300 && answer.status < 400 && answer.status != 304) {
    leave();
    return give(refusal_for(path_, 502, "io", said(fmt::format("no monitor answers there: status {}", answer.status))));
  }
  Response r;
  r.status = answer.status;
  r.media_type = kOtherType;
  for (const auto& [name, value] : answer.headers) {
    if (name == "content-type")
      r.media_type = type_to_show(value);
    else
      r.headers.emplace_back(name, value);
  }
  if (answer.status == 304) r.media_type.clear();
  r.headers.emplace_back("content-security-policy", "sandbox; default-src 'none'");
  if (answer.status != 304 && answer.status != 204 && answer.length != 0u) {
    r.stream = std::make_unique<ResponseStream>(self);
    r.stream_bytes = answer.length;
  }
  give(std::move(r));
}

// ---- WebSockets

/// Its owner is the server's connection.
class Relay::SocketPassage final : public Passage, public Socket {
 public:
  SocketPassage(std::shared_ptr<Passages> passages, std::string address, Server& server, ConnectionId connection)
      : Passage(std::move(passages), std::move(address)), server_(server), id_(connection) {}

  void begin(Call call) { connection_ = server_.client().open(std::move(call), *this); }

  void answered(const Client::Answer& answer) override { status_ = answer.status; }
  void received(const Client::Piece& piece) override {
    Message message;
    message.binary = piece.binary, message.begins = piece.begins, message.ends = piece.ends;
    message.bytes = std::make_shared<const std::vector<std::byte>>(piece.bytes.begin(), piece.bytes.end());
    held_bytes_ += piece.bytes.size() + sizeof(Message);
    held_.push_back(std::move(message));
    if (held_bytes_ >= kAhead) connection_->read(false);
    server_.wake(id_);
  }
  void ended(Client::End, const std::string& why) override {
    const bool is_refused = status_ >= 400 && status_ < 500 && status_ != 404;
    ending_ = Ending{is_refused ? kRefused : kTryAgain, said(why)};
    server_.wake(id_);
  }
  void cut(const std::string& why) override {
    if (ending_) return;
    connection_.reset();
    held_.clear();
    ended(Client::End::lost, why);
  }

  bool receive(bool binary, std::span<const std::byte> message) override {
    return ending_ || connection_->send(binary, message);
  }
  std::optional<Message> next() override {
    if (held_.empty()) return std::nullopt;
    Message message = std::move(held_.front());
    held_.pop_front();
    held_bytes_ -= message.bytes->size() + sizeof(Message);
    if (!ending_ && held_bytes_ < kAhead / 2) connection_->read(true);
    return message;
  }
  const Ending* ending() const override { return ending_ ? &*ending_ : nullptr; }

 private:
  Server& server_;
  const ConnectionId id_;
  std::unique_ptr<Client::Connection> connection_{};
  std::deque<Message> held_{};
  std::size_t held_bytes_ = 0;
  int status_ = 0;
  std::optional<Ending> ending_{};
};

// ---- both

Relay::Relay(Server& server, const Gate& gate, const Monitors& monitors)
    : server_(server), gate_(gate), monitors_(monitors), passages_(std::make_shared<Passages>()) {}

bool Relay::route(const Request& request, Route& route, Response& refusal) const {
  const std::string_view rest = std::string_view(request.path).substr(kAt.size());
  const std::size_t slash = rest.find('/');
  const std::string address(rest.substr(0, slash));
  const std::string_view path = slash == std::string_view::npos ? std::string_view() : rest.substr(slash);
  const auto refuse = [&](int status, std::string_view code, const std::string& why) {
    refusal = refusal_for(path, status, code, why);
    return false;
  };
  route.place = monitors_.find(address);
  if (!route.place)
    return refuse(404, "not_found", fmt::format("no monitor '{}' is known; /api/monitors lists them", address));
  const bool is_socket = !request.subprotocol.empty();
  if (is_socket ? path.find('/', 1) != std::string_view::npos || path.empty() : !is_relayed(path))
    return refuse(404, "not_found", "of other monitors there are /api, pictures, and WebSockets of their robots");
  const std::string* const token = request.argument("token");
  if (gate_.is_our_token(bearer_token(request)) || (token && gate_.is_our_token(*token)))
    return refuse(403, "denied", "this is the token of this monitor, and the other one must not learn it");
  const auto goes_there = [&](const Passage* p) { return p->address() == address; };
  if (std::count_if(passages_->all.begin(), passages_->all.end(), goes_there) >= static_cast<int>(kMostOfOne))
    return refuse(503, "busy", fmt::format("{}: {} connections are open", address, kMostOfOne));
  Call& call = route.call;
  call.host = route.place->host, call.port = route.place->port, call.tls = route.place->tls;
  call.method = request.method, call.patience = kPatience;
  call.target = encoded(path, "/:@!$'()*,;");
  char mark = '?';
  for (const auto& [name, value] : request.query) {
    call.target += mark + encoded(name, "") + "=" + encoded(value, "");
    mark = '&';
  }
  if (call.target.size() > Call::kMostTarget)
    return refuse(414, "bad_argument", "the path is too long to be passed on");
  call.subprotocol = request.subprotocol;
  const std::pair<const char*, const std::string*> kCarried[] = {
      {"authorization", &request.authorization}, {"if-none-match", &request.if_none_match},
      {"content-type", &request.content_type},   {"accept-encoding", &request.accept_encoding},
      {"x-sinew-until-ns", &request.until_ns},   {"x-sinew-control", &request.control_key}};
  for (const auto& [name, value] : kCarried)
    if (!value->empty()) call.headers.emplace_back(name, *value);
  call.body = request.body;
  return true;
}

void Relay::answer(const Request& request, ConnectionId connection, const Server::Reply& reply) {
  if (request.method != "GET" && request.method != "HEAD" && request.method != "POST")
    return reply(json_error(405, "bad_argument", "GET looks, POST changes"));
  Route way;
  Response refusal;
  if (!route(request, way, refusal)) return reply(std::move(refusal));
  std::make_shared<ResponsePassage>(passages_, way.place->address, server_, connection, request.path, reply)
      ->begin(std::move(way.call));
}

std::unique_ptr<Socket> Relay::open_socket(const Request& request, ConnectionId connection, Response& refusal) {
  Route way;
  if (request.subprotocol.empty()) {
    refusal = plain(400, "this WebSocket speaks the subprotocols of Foxglove alone");
    return nullptr;
  }
  if (!route(request, way, refusal)) return nullptr;
  auto passage = std::make_unique<SocketPassage>(passages_, way.place->address, server_, connection);
  passage->begin(std::move(way.call));
  return passage;
}

void Relay::cut(const std::string& address) {
  std::vector<Passage*> there;
  for (Passage* const p : passages_->all)
    if (p->address() == address) there.push_back(p);
  // None of them destroys another one: the server does, later.
  for (Passage* const p : there) p->cut("it has been removed from the monitors here");
}

}  // namespace sinew::monitor
