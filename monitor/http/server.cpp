#include "monitor/http/server.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <libwebsockets.h>
#include <linux/sockios.h>
#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <map>
#include <mutex>
#include <thread>
#include <unordered_map>
#include <utility>

#include "hal/wide.hpp"
#include "monitor/http/head.hpp"
#include "monitor/http/library_log.hpp"
#include "monitor/http/lws_client.hpp"

namespace sinew::monitor {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kPiece = 64 << 10;  // written at once: what the library may keep for a slow peer
constexpr unsigned kRead = 16 << 10;      // read at once
constexpr std::size_t kMostReason = 120;  // of the end of a WebSocket: it has to fit into one small frame
constexpr int kUnsent = 8 << 10;          // bytes of a WebSocket that may wait in the system for the link
constexpr auto kSweep = std::chrono::milliseconds(500);  // between two looks for connections that do not get on
constexpr std::size_t kMostHeldBack = kUnsent / 4;       // bytes of messages that share packets
constexpr unsigned kMostDoomed = 64;                     // connections that are being ended to make room
constexpr std::size_t kMostHeaderBytes = 8 << 10;        // of a request, and of a response

struct Connection {
  lws* wsi = nullptr;
  ConnectionId id = 0;
  std::string peer;
  Clock::time_point since;     // of the state that the patience bounds
  bool bounded = true;         // it has to get on: to finish its request, or to take what it asked for
  bool answered = false;       // of the present request: its response has begun
  bool idle = true;            // no whole request has come since the connection began, or since the last response
  bool doomed = false;         // it makes room for another: ends soon
  Request request{};           // while its body comes
  std::size_t body_bytes = 0;  // that it announced
  bool too_long = false;
  Response response{};
  std::optional<Piece> piece{};                // being sent
  std::size_t sent = 0;                        // of it
  std::optional<std::uint64_t> stream_left{};  // of a stream of known length: what has not been taken from it
  bool head_only = false;
  std::unique_ptr<Socket> socket{};
  std::vector<std::byte> message{};  // that comes in
  std::optional<Socket::Message> out{};
  bool corks = false;  // its messages may share packets
  bool corked = false;
  std::size_t held_back = 0;  // bytes given to the system since then
  bool responding = false;    // a response is being made or sent
  bool speaks = false;        // meanwhile, when it was looked at last
};

/// Empty: it has none (a Unix socket), or the peer has gone.
std::string peer_of(int fd) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  if (getpeername(fd, reinterpret_cast<sockaddr*>(&address), &size) != 0) return {};
  char text[INET6_ADDRSTRLEN] = "";
  if (address.ss_family == AF_INET)
    inet_ntop(AF_INET, &reinterpret_cast<sockaddr_in&>(address).sin_addr, text, sizeof text);
  else if (address.ss_family == AF_INET6)
    inet_ntop(AF_INET6, &reinterpret_cast<sockaddr_in6&>(address).sin6_addr, text, sizeof text);
  return text;
}

class LwsServer final : public Server {
 public:
  LwsServer(ServerOptions options, OnRequest on_request, OnSocket on_socket)
      : options_(std::move(options)), on_request_(std::move(on_request)), on_socket_(std::move(on_socket)) {}

  ~LwsServer() override {
    // First: what their owners do from other threads needs the context.
    if (client_) client_->end_all("this monitor ends");
    for (auto& [wsi, c] : connections_) c->socket.reset(), c->response = {};
    if (context_) lws_context_destroy(context_);
  }

  bool listen(std::string& why) {
    keep_library_errors();
    last_error().clear();
    protocols_.push_back(protocol("http"));
    for (const std::string& name : options_.subprotocols) protocols_.push_back(protocol(name.c_str()));
    protocols_.push_back({});
    lws_context_creation_info info{};
    info.port = options_.port;
    info.iface = options_.address == "0.0.0.0" ? nullptr : options_.address.c_str();
    info.protocols = protocols_.data();
    info.user = this;
    info.gid = info.uid = static_cast<decltype(info.uid)>(-1);
    info.max_http_header_data = kMostHeaderBytes;
    info.timeout_secs = static_cast<unsigned>(options_.patience.count());
    info.keepalive_timeout = 30;
    info.options = LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND | LWS_SERVER_OPTION_DISABLE_IPV6;
    info.alpn = "http/1.1";
    info.server_string = "sinew";
    info.pt_serv_buf_size = kRead;
    // The client speaks TLS in any case, and believes certificates by a list of its own.
    info.options |= LWS_SERVER_OPTION_DO_SSL_GLOBAL_INIT | LWS_SERVER_OPTION_DISABLE_OS_CA_CERTS;
    if (!options_.certificate.empty()) {
      info.ssl_cert_filepath = options_.certificate.c_str();
      info.ssl_private_key_filepath = options_.key.c_str();
    }
    context_ = lws_create_context(&info);
    vhost_ = context_ ? lws_get_vhost_by_name(context_, "default") : nullptr;
    if (!vhost_ || lws_get_vhost_listen_port(vhost_) <= 0) {
      const std::string& said = last_error();
      why = fmt::format("cannot listen on {}:{}{}", options_.address, options_.port, said.empty() ? "" : ": " + said);
      return false;
    }
    port_ = static_cast<std::uint16_t>(lws_get_vhost_listen_port(vhost_));
    lws_sock_file_fd_type timer{};
    timer.filefd = timer_fd_ = timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK);
    if (timer_fd_ < 0 || !lws_adopt_descriptor_vhost(vhost_, LWS_ADOPT_RAW_FILE_DESC, timer, "http", nullptr)) {
      why = "there is no timer to be had";
      return false;
    }
    LwsClient::Options client{options_.trust};
    client.post = [this](std::function<void()> what) { post(std::move(what)); };
    client.is_full = [this] { return is_full(); };
    client_ = LwsClient::make(context_, std::move(client), why);
    return client_ != nullptr;
  }

  std::uint16_t port() const override { return port_; }

  void run() override {
    thread_ = std::this_thread::get_id();
    tick();
    while (!stop_.load(std::memory_order_relaxed) && lws_service(context_, 0) >= 0) {
    }
    for (auto& [wsi, c] : connections_) c->socket.reset(), c->response = {};
  }

  void stop() override {
    stop_.store(true, std::memory_order_relaxed);
    lws_cancel_service(context_);
  }

  void wake(ConnectionId connection) override {
    {
      const std::lock_guard lock(mutex_);
      woken_.push_back(connection);
    }
    lws_cancel_service(context_);
  }

  void post(std::function<void()> what) override {
    {
      const std::lock_guard lock(mutex_);
      posted_.push_back(std::move(what));
    }
    lws_cancel_service(context_);
  }

  void after(std::chrono::milliseconds time, std::function<void()> what) override {
    later_.emplace(Clock::now() + time, std::move(what));
    schedule();
  }

  Client& client() override { return *client_; }

  std::optional<Link> link(ConnectionId connection) const override {
    const auto found = by_id_.find(connection);
    if (found == by_id_.end()) return std::nullopt;
    const int fd = lws_get_socket_fd(found->second->wsi);
    tcp_info info{};
    socklen_t size = sizeof info;
    int outstanding = 0;
    if (getsockopt(fd, IPPROTO_TCP, TCP_INFO, &info, &size) != 0 || ioctl(fd, SIOCOUTQ, &outstanding) != 0)
      return std::nullopt;
    return Link{info.tcpi_bytes_acked, static_cast<std::uint32_t>(std::max(outstanding, 0)), info.tcpi_notsent_bytes,
                info.tcpi_rtt, info.tcpi_min_rtt};
  }

  Counters counters() const override {
    return {accepted_.value(), refused_full_.value(),     refused_peer_.value(), made_room_.value(),
            requests_.value(), refused_requests_.value(), open_.load()};
  }

  int callback(lws* wsi, lws_callback_reasons reason, void* in, std::size_t length) {
    switch (reason) {
      case LWS_CALLBACK_FILTER_NETWORK_CONNECTION:
        return let_in(static_cast<int>(reinterpret_cast<std::intptr_t>(in))) ? 0 : 1;
      case LWS_CALLBACK_SERVER_NEW_CLIENT_INSTANTIATED:
        begin(wsi);
        return 0;
      case LWS_CALLBACK_WSI_DESTROY:
        end(wsi);
        return 0;
      case LWS_CALLBACK_EVENT_WAIT_CANCELLED:
        drain();
        return 0;
      case LWS_CALLBACK_RAW_RX_FILE: {
        std::uint64_t ticks = 0;
        if (read(timer_fd_, &ticks, sizeof ticks) == sizeof ticks) tick();
        return 0;
      }
      case LWS_CALLBACK_HTTP:
        return with(wsi, [&](Connection& c) { return request(c); });
      case LWS_CALLBACK_HTTP_BODY:
        return with(wsi, [&](Connection& c) { return body(c, static_cast<const char*>(in), length); });
      case LWS_CALLBACK_HTTP_BODY_COMPLETION:
        return with(wsi, [&](Connection& c) { return handle(c); });
      case LWS_CALLBACK_HTTP_WRITEABLE:
        return with(wsi, [&](Connection& c) { return send(c); });
      case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION:
        return with(wsi, [&](Connection& c) { return open_socket(c); });
      case LWS_CALLBACK_ESTABLISHED:
        return with(wsi, [&](Connection& c) {
          c.bounded = false, c.idle = false;
          lws_callback_on_writable(wsi);
          return 0;
        });
      case LWS_CALLBACK_RECEIVE:
        return with(wsi, [&](Connection& c) { return receive(c, static_cast<const std::byte*>(in), length); });
      case LWS_CALLBACK_SERVER_WRITEABLE:
        return with(wsi, [&](Connection& c) { return send_message(c); });
      case LWS_CALLBACK_CLOSED:
        return with(wsi, [](Connection& c) {
          c.socket.reset();
          return 0;
        });
      case LWS_CALLBACK_CLOSED_HTTP:
        return with(wsi, [](Connection& c) {
          c.response = {};
          return 0;
        });
      default:
        return 0;
    }
  }

 private:
  lws_protocols protocol(const char* name) {
    lws_protocols p{};
    p.name = name;
    p.callback = [](lws* wsi, lws_callback_reasons reason, void*, void* in, std::size_t length) {
      auto* const server = static_cast<LwsServer*>(lws_context_user(lws_get_context(wsi)));
      return server ? server->callback(wsi, reason, in, length) : 0;
    };
    p.rx_buffer_size = kPiece;
    return p;
  }

  template <class F>
  int with(lws* wsi, F&& what) {
    const auto found = connections_.find(wsi);
    return found == connections_.end() ? -1 : what(*found->second);
  }

  // ---- connections

  /// Idle connections make room for new ones: whoever has a request is served, however many hold places for nothing.
  bool let_in(int fd) {
    accepted_.add();
    const std::string peer = peer_of(fd);
    const auto found = peers_.find(peer);
    if (found != peers_.end() && found->second >= options_.most_per_peer && !make_room(&peer)) {
      refused_peer_.add();
      return false;
    }
    if ((is_full() && !make_room(nullptr)) || doomed_ >= kMostDoomed) {
      refused_full_.add();
      return false;
    }
    return true;
  }

  bool is_full() const {
    return connections_.size() - doomed_ + client_->open_connections() >= options_.most_connections;
  }

  /// Ends the connection that has been idle for longest: of this peer; without one, of the peer with the most of them.
  bool make_room(const std::string* peer) {
    Connection* oldest = nullptr;
    unsigned most = 0;
    for (auto& [wsi, c] : connections_) {
      if (!c->idle || c->doomed || (peer && c->peer != *peer)) continue;
      const unsigned held = peers_[c->peer];
      if (oldest && (held < most || (held == most && c->since >= oldest->since))) continue;
      oldest = c.get(), most = held;
    }
    if (!oldest) return false;
    oldest->doomed = true, oldest->bounded = false;
    ++doomed_;
    const auto held = peers_.find(oldest->peer);
    if (held != peers_.end() && --held->second == 0) peers_.erase(held);
    made_room_.add();
    lws_set_timeout(oldest->wsi, PENDING_TIMEOUT_USER_OK, LWS_TO_KILL_ASYNC);
    return true;
  }

  void begin(lws* wsi) {
    auto c = std::make_unique<Connection>();
    c->wsi = wsi, c->id = ++last_id_, c->since = Clock::now();
    c->peer = peer_of(lws_get_socket_fd(wsi));
    ++peers_[c->peer];
    by_id_[c->id] = c.get();
    connections_[wsi] = std::move(c);
    open_.store(static_cast<std::uint32_t>(connections_.size()), std::memory_order_relaxed);
  }

  void end(lws* wsi) {
    const auto found = connections_.find(wsi);
    if (found == connections_.end()) return;
    if (found->second->doomed) {
      --doomed_;
    } else {
      const auto peer = peers_.find(found->second->peer);
      if (peer != peers_.end() && --peer->second == 0) peers_.erase(peer);
    }
    by_id_.erase(found->second->id);
    connections_.erase(found);
    open_.store(static_cast<std::uint32_t>(connections_.size()), std::memory_order_relaxed);
  }

  /// Ends connections that do not get on.
  void tick() {
    const auto now = Clock::now();
    const bool is_sweep = now - swept_ >= kSweep;
    if (is_sweep) swept_ = now;
    for (auto& [wsi, c] : connections_)
      if (is_sweep && ((c->bounded && now - c->since > options_.patience) || interrupts(*c))) {
        c->bounded = false, c->responding = false;
        lws_set_timeout(wsi, PENDING_TIMEOUT_USER_OK, LWS_TO_KILL_ASYNC);
      }
    client_->tick(now);
    std::vector<std::function<void()>> due;
    while (!later_.empty() && later_.begin()->first <= now) {
      due.push_back(std::move(later_.begin()->second));
      later_.erase(later_.begin());
    }
    for (const auto& what : due) what();
    schedule();
  }

  /// By a timer of the system: the library's own are looked at without pause for the last millisecond before each.
  void schedule() {
    Clock::time_point next = swept_ + kSweep;
    if (!later_.empty()) next = std::min(next, later_.begin()->first);
    const auto ns = std::chrono::duration_cast<std::chrono::nanoseconds>(next.time_since_epoch()).count();
    itimerspec when{};
    when.it_value = {static_cast<time_t>(ns / 1'000'000'000), static_cast<long>(ns % 1'000'000'000)};
    timerfd_settime(timer_fd_, TFD_TIMER_ABSTIME, &when, nullptr);
  }

  void drain() {
    std::vector<std::function<void()>> posted;
    std::vector<ConnectionId> woken;
    {
      const std::lock_guard lock(mutex_);
      posted.swap(posted_);
      woken.swap(woken_);
    }
    for (const auto& what : posted) what();
    for (const ConnectionId id : woken)
      if (const auto found = by_id_.find(id); found != by_id_.end()) lws_callback_on_writable(found->second->wsi);
  }

  // ---- requests

  int request(Connection& c) {
    requests_.add();
    c.answered = false, c.idle = false, c.bounded = true, c.since = Clock::now(), c.too_long = false;
    c.response = {}, c.piece.reset(), c.sent = 0;
    Response refusal;
    c.request.peer = c.peer;
    if (!read_request(c.wsi, c.request, refusal)) {
      refused_requests_.add();
      return respond(c, std::move(refusal));
    }
    c.head_only = c.request.method == "HEAD";
    const std::string announced = header_of(c.wsi, WSI_TOKEN_HTTP_CONTENT_LENGTH);
    const bool chunked = !header_of(c.wsi, WSI_TOKEN_HTTP_TRANSFER_ENCODING).empty();
    c.body_bytes =
        static_cast<std::size_t>(std::min<unsigned long long>(std::strtoull(announced.c_str(), nullptr, 10), SIZE_MAX));
    if (chunked || c.body_bytes > options_.most_body_bytes) {
      refused_requests_.add();
      c.too_long = true;
      return respond(c, chunked ? plain(411, "a body needs its length")
                                : plain(413, fmt::format("a body has at most {} bytes", options_.most_body_bytes)));
    }
    if (c.body_bytes > 0) return 0;  // its body comes
    return handle(c);
  }

  int body(Connection& c, const char* data, std::size_t length) {
    if (c.too_long) return 0;
    if (c.request.body.size() + length > options_.most_body_bytes) return -1;
    c.request.body.append(data, length);
    c.since = Clock::now();
    return 0;
  }

  int handle(Connection& c) {
    if (c.too_long) return 0;
    struct Pending {
      LwsServer* server;
      ConnectionId id;
      std::atomic<bool> used{false};
      void give(Response response) {
        if (used.exchange(true)) return;
        if (std::this_thread::get_id() == server->thread_ && server->handling_ == id) {
          server->direct_ = std::move(response);
          return;
        }
        auto kept = std::make_shared<Response>(std::move(response));
        server->post([s = server, i = id, kept] { s->respond_later(i, std::move(*kept)); });
      }
      ~Pending() { give(plain(503, "nobody answered")); }
    };
    c.bounded = false;  // it waits for us now
    auto pending = std::make_shared<Pending>();
    pending->server = this, pending->id = c.id;
    handling_ = c.id;
    direct_.reset();
    on_request_(std::move(c.request), c.id, [pending](Response response) { pending->give(std::move(response)); });
    pending.reset();
    handling_ = 0;
    c.request = {};
    if (!direct_) {
      c.responding = true;
      return 0;
    }
    Response response = std::move(*direct_);
    direct_.reset();
    return respond(c, std::move(response));
  }

  void respond_later(ConnectionId id, Response response) {
    const auto found = by_id_.find(id);
    if (found == by_id_.end() || found->second->answered) return;
    if (respond(*found->second, std::move(response)) != 0)
      lws_set_timeout(found->second->wsi, PENDING_TIMEOUT_USER_OK, LWS_TO_KILL_ASYNC);
  }

  int respond(Connection& c, Response response) {
    c.answered = true, c.bounded = true, c.since = Clock::now();
    c.response = std::move(response);
    std::array<unsigned char, LWS_PRE + kMostHeaderBytes> buffer;
    unsigned char *const start = buffer.data() + LWS_PRE, *at = start, *const end = buffer.data() + buffer.size();
    const auto add = [&](std::string_view name, std::string_view value) {
      const std::string key = std::string(name) + ":";
      return lws_add_http_header_by_name(c.wsi, reinterpret_cast<const unsigned char*>(key.c_str()),
                                         reinterpret_cast<const unsigned char*>(value.data()),
                                         static_cast<int>(value.size()), &at, end) == 0;
    };
    const Response& r = c.response;
    const std::size_t size = r.body ? r.body->size() : 0;
    bool ok = lws_add_http_header_status(c.wsi, static_cast<unsigned>(r.status), &at, end) == 0;
    if (!r.media_type.empty()) ok = ok && add("content-type", r.media_type);
    for (const auto& [name, value] : options_.every_response) ok = ok && add(name, value);
    for (const auto& [name, value] : r.headers) ok = ok && add(name, value);
    c.stream_left = r.stream_bytes;
    if ((r.stream && !r.stream_bytes) || c.too_long) ok = ok && add("connection", "close");
    if (r.stream_bytes)
      ok = ok && add("content-length", std::to_string(*r.stream_bytes));
    else if (!r.stream)
      ok = ok && (r.status == 304 || add("content-length", std::to_string(size)));
    if (!ok || lws_finalize_write_http_header(c.wsi, start, &at, end) != 0) return -1;
    c.piece.reset();
    if (size > 0 && !c.head_only) c.piece = Piece{{}, r.body, {}};
    c.sent = 0;
    if (!c.response.stream && !c.piece) return completed(c);
    c.responding = true;
    lws_callback_on_writable(c.wsi);
    return 0;
  }

  /// While a response is made and sent, the library reads nothing, but is woken without end by what has come, also by
  /// the end of the connection. Who speaks then for longer than a sweep ends: no client of ours sends one request into
  /// the response to another.
  static bool interrupts(Connection& c) {
    char byte = 0;
    const bool speaks = c.responding && recv(lws_get_socket_fd(c.wsi), &byte, 1, MSG_PEEK | MSG_DONTWAIT) >= 0;
    return std::exchange(c.speaks, speaks) && speaks;
  }

  int completed(Connection& c) {
    // What ends before its announced length has to be seen to end.
    const bool is_short = c.response.stream && (c.head_only ? !c.stream_left : c.stream_left != 0u);
    const bool close = c.too_long || is_short;
    c.response = {}, c.piece.reset(), c.bounded = false;  // the library bounds how long it may stay idle
    c.idle = true, c.since = Clock::now();
    c.responding = false;
    return lws_http_transaction_completed(c.wsi) != 0 || close ? -1 : 0;
  }

  int send(Connection& c) {
    if (!c.answered) return 0;
    if (c.response.stream && !c.piece) {
      if (c.head_only) return completed(c);
      c.piece = c.response.stream->next();
      c.sent = 0;
      c.bounded = c.piece.has_value();
      c.since = Clock::now();
      if (!c.piece) return c.response.stream->is_over() ? completed(c) : 0;
      if (c.stream_left && c.piece->size() > *c.stream_left) return -1;
      if (c.stream_left) *c.stream_left -= c.piece->size();
    }
    if (!c.piece) return 0;
    const Parts parts{as_span(c.piece->head), as_span(c.piece->bytes), as_span(c.piece->tail)};
    const std::size_t left = size_of(parts) - c.sent, now = std::min(left, kPiece);
    const bool last = now == left && (!c.response.stream || c.stream_left == 0u);
    // The library writes nothing before the bytes of HTTP/1.1, so those that are alone need no copy.
    const bool alone = c.piece->head.empty() && c.piece->tail.empty();
    auto* const from = alone ? reinterpret_cast<unsigned char*>(const_cast<std::byte*>(c.piece->bytes->data() + c.sent))
                             : gather(parts, c.sent, now);
    if (lws_write(c.wsi, from, now, last ? LWS_WRITE_HTTP_FINAL : LWS_WRITE_HTTP) < static_cast<int>(now)) return -1;
    c.sent += now;
    c.since = Clock::now();
    if (last) return completed(c);
    if (now == left) c.piece.reset();
    lws_callback_on_writable(c.wsi);
    return 0;
  }

  using Parts = std::array<std::span<const std::byte>, 3>;
  static std::span<const std::byte> as_span(const std::string& text) { return std::as_bytes(std::span(text)); }
  static std::span<const std::byte> as_span(const Bytes& bytes) {
    return bytes ? std::span(*bytes) : std::span<const std::byte>();
  }
  static std::size_t size_of(const Parts& parts) { return parts[0].size() + parts[1].size() + parts[2].size(); }

  /// `size` bytes of the parts in a row, from `begin`; the library may write before them.
  unsigned char* gather(const Parts& parts, std::size_t begin, std::size_t size) {
    unsigned char *const start = frame_.data() + LWS_PRE, *to = start;
    for (const auto& part : parts) {
      const std::size_t skipped = std::min(begin, part.size()), taken = std::min(part.size() - skipped, size);
      if (taken > 0) std::memcpy(to, part.data() + skipped, taken);
      begin -= skipped, size -= taken, to += taken;
    }
    return start;
  }

  // ---- WebSockets

  static void set(lws* wsi, int option, int value) {
    static_cast<void>(setsockopt(lws_get_socket_fd(wsi), IPPROTO_TCP, option, &value, sizeof value));
  }

  /// A message that waits in the system's buffers is old when it arrives, and nothing newer can overtake it.
  static void keep_young(Connection& c) {
    set(c.wsi, TCP_NOTSENT_LOWAT, kUnsent);
    set(c.wsi, TCP_THIN_LINEAR_TIMEOUTS, 1);
    // The system holds back what fills no packet for 200 ms. Where a packet takes more than may wait unsent (loopback:
    // 64 KiB), nothing would ever fill one.
    tcp_info info{};
    socklen_t size = sizeof info;
    c.corks = getsockopt(lws_get_socket_fd(c.wsi), IPPROTO_TCP, TCP_INFO, &info, &size) == 0 &&
              info.tcpi_snd_mss <= kUnsent / 4;
  }

  /// Messages that follow one another at once share packets: each packet is one more that may be lost.
  static void cork(Connection& c, bool corked) {
    if (!c.corks || c.corked == corked) return;
    c.corked = corked, c.held_back = 0;
    set(c.wsi, TCP_CORK, corked ? 1 : 0);
  }

  int open_socket(Connection& c) {
    Response refusal = plain(403, "no WebSocket here");
    c.request.peer = c.peer;
    if (read_request(c.wsi, c.request, refusal)) {
      // The library has chosen: the first of the client's that is one of ours, or, when it offers none, the first of
      // all.
      const lws_protocols* const chosen = lws_get_protocol(c.wsi);
      if (chosen && chosen != &protocols_.front() && chosen->name != protocols_.front().name)
        c.request.subprotocol = chosen->name;
      c.socket = on_socket_(c.request, c.id, refusal);
    }
    c.request = {};
    if (c.socket) {
      keep_young(c);
      return 0;
    }
    refused_requests_.add();
    const std::string body(reinterpret_cast<const char*>(refusal.body ? refusal.body->data() : nullptr),
                           refusal.body ? refusal.body->size() : 0);
    lws_return_http_status(c.wsi, static_cast<unsigned>(refusal.status), body.c_str());
    return -1;
  }

  int receive(Connection& c, const std::byte* data, std::size_t length) {
    if (!c.socket) return -1;
    if (lws_is_first_fragment(c.wsi)) c.message.clear();
    if (c.message.size() + length > options_.most_message_bytes) {
      lws_close_reason(c.wsi, LWS_CLOSE_STATUS_MESSAGE_TOO_LARGE, nullptr, 0);
      return -1;
    }
    c.message.insert(c.message.end(), data, data + length);
    if (!lws_is_final_fragment(c.wsi)) return 0;
    const bool taken = c.socket->receive(lws_frame_is_binary(c.wsi) != 0, c.message);
    if (c.message.capacity() > kPiece) c.message = {};
    if (!taken) lws_close_reason(c.wsi, LWS_CLOSE_STATUS_POLICY_VIOLATION, nullptr, 0);
    return taken ? 0 : -1;
  }

  int end_if_over(Connection& c) {
    const Socket::Ending* const ending = c.socket->ending();
    if (!ending) return 0;
    std::string why = ending->why.substr(0, kMostReason);  // the library's interface wants bytes that may change
    lws_close_reason(c.wsi, static_cast<lws_close_status>(ending->code), reinterpret_cast<unsigned char*>(why.data()),
                     why.size());
    return -1;
  }

  /// Small messages that are there go at once, without a look at the system for each.
  int send_message(Connection& c) {
    if (!c.socket) return -1;
    do {
      if (!c.out) {
        c.out = c.socket->next();
        c.sent = 0;
        c.bounded = c.out.has_value();
        c.since = Clock::now();
        cork(c, c.out.has_value());
        if (!c.out) return end_if_over(c);
      }
      if (!send_piece(c)) return -1;
    } while (c.corked && !c.out);
    lws_callback_on_writable(c.wsi);
    return 0;
  }

  bool send_piece(Connection& c) {
    const Parts parts{c.out->head, as_span(c.out->bytes), {}};
    const std::size_t size = size_of(parts), left = size - c.sent, now = std::min(left, kPiece);
    const int kind = lws_write_ws_flags(c.out->binary ? LWS_WRITE_BINARY : LWS_WRITE_TEXT, c.sent == 0 && c.out->begins,
                                        now == left && c.out->ends);
    // Before a frame the library writes its head, therefore a copy.
    unsigned char* const from = gather(parts, c.sent, now);
    if (lws_write(c.wsi, from, now, static_cast<lws_write_protocol>(kind)) < static_cast<int>(now)) return false;
    c.sent += now;
    c.since = Clock::now();
    if (c.sent == size) c.out.reset();
    // With half of kUnsent the system takes no more, and we would not learn that there is none to come.
    c.held_back += now;
    if (c.held_back >= kMostHeldBack) cork(c, false);
    return true;
  }

  const ServerOptions options_;
  const OnRequest on_request_;
  const OnSocket on_socket_;
  std::vector<lws_protocols> protocols_;
  lws_context* context_ = nullptr;
  lws_vhost* vhost_ = nullptr;
  std::uint16_t port_ = 0;
  std::unique_ptr<LwsClient> client_;
  int timer_fd_ = -1;  // the library closes it
  Clock::time_point swept_{};
  std::thread::id thread_{};
  std::atomic<bool> stop_{false};
  std::mutex mutex_;  // of the next two
  std::vector<std::function<void()>> posted_;
  std::vector<ConnectionId> woken_;

  // The server's thread alone.
  std::unordered_map<lws*, std::unique_ptr<Connection>> connections_;
  std::unordered_map<ConnectionId, Connection*> by_id_;
  std::map<std::string, unsigned> peers_;
  std::multimap<Clock::time_point, std::function<void()>> later_;
  ConnectionId last_id_ = 0, handling_ = 0;
  unsigned doomed_ = 0;
  std::optional<Response> direct_;  // given while its request was being handled
  std::array<unsigned char, LWS_PRE + kPiece> frame_;
  hal::Tally accepted_, refused_full_, refused_peer_, made_room_, requests_, refused_requests_;
  std::atomic<std::uint32_t> open_{0};
};

}  // namespace

std::unique_ptr<Server> Server::open(const ServerOptions& options, OnRequest on_request, OnSocket on_socket,
                                     std::string& why) {
  auto server = std::make_unique<LwsServer>(options, std::move(on_request), std::move(on_socket));
  if (!server->listen(why)) return nullptr;
  return server;
}

}  // namespace sinew::monitor
