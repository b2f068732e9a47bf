#include "monitor/http/lws_client.hpp"

#include <fmt/format.h>
#include <libwebsockets.h>
#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <deque>
#include <utility>

#include "monitor/http/head.hpp"
#include "monitor/http/library_log.hpp"

namespace sinew::monitor {

struct LwsClient::Peer {
  struct Message {
    bool binary;
    std::vector<unsigned char> bytes;  // after LWS_PRE bytes for the library
  };
  LwsClient* client = nullptr;
  lws* wsi = nullptr;  // null: before and after the connection
  Call call;
  Listener* listener = nullptr;    // null: it has been told the end, or has left
  Clock::time_point since{};       // of the beginning; when it is answered, of the last sign of life
  std::optional<Answer> answer{};  // its head has come
  std::uint64_t received = 0;      // bytes of the body
  bool is_over = false;            // nothing more is wanted
  bool is_read = true;
  bool asks = false;        // whether it is there
  std::size_t sent = 0;     // of the body, or of the first message that waits
  std::size_t waiting = 0;  // bytes
  std::deque<Message> messages{};
  std::string why{};  // it ends, where the library does not know it

  bool is_socket() const { return !call.subprotocol.empty(); }
};

namespace {

constexpr std::size_t kClientPiece = 64 << 10;  // of a message: received and written at once
constexpr std::size_t kClientRead = 16 << 10;   // of a body
constexpr int kConnect = 5;                     // seconds
constexpr const char* kClientName = "sinew-client";

// What a relay passes on, and no more: above all no cookies, and no policy of another site.
constexpr std::pair<const char*, int> kKnownHeaders[] = {{"content-type", WSI_TOKEN_HTTP_CONTENT_TYPE},
                                                         {"content-encoding", WSI_TOKEN_HTTP_CONTENT_ENCODING},
                                                         {"content-disposition", WSI_TOKEN_HTTP_CONTENT_DISPOSITION},
                                                         {"cache-control", WSI_TOKEN_HTTP_CACHE_CONTROL},
                                                         {"etag", WSI_TOKEN_HTTP_ETAG},
                                                         {"vary", WSI_TOKEN_HTTP_VARY},
                                                         {"retry-after", WSI_TOKEN_HTTP_RETRY_AFTER},
                                                         {"allow", WSI_TOKEN_HTTP_ALLOW}};
constexpr const char* kOwnHeaders[] = {"x-sinew-sequence", "x-sinew-stamp-ns"};

bool is_one_line(std::string_view text) {
  return std::none_of(text.begin(), text.end(),
                      [](char c) { return static_cast<unsigned char>(c) < ' ' || c == '\x7f'; });
}

/// False: no number of bytes.
bool length_of(const std::string& text, std::uint64_t& length) {
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, length);
  return read.ec == std::errc() && read.ptr == end;
}

void set_option(lws* wsi, int level, int option, int value) {
  static_cast<void>(setsockopt(lws_get_socket_fd(wsi), level, option, &value, sizeof value));
}

/// A peer's machine that has gone says nothing: without these its connections would stay for hours. The window keeps
/// the system from storing what the reader does not take, since the peer takes what is acknowledged for delivered.
void set_up(lws* wsi) {
  set_option(wsi, SOL_SOCKET, SO_KEEPALIVE, 1);
  set_option(wsi, IPPROTO_TCP, TCP_KEEPIDLE, 5);
  set_option(wsi, IPPROTO_TCP, TCP_KEEPINTVL, 2);
  set_option(wsi, IPPROTO_TCP, TCP_KEEPCNT, 4);
  set_option(wsi, IPPROTO_TCP, TCP_USER_TIMEOUT, 15'000);
  set_option(wsi, IPPROTO_TCP, TCP_WINDOW_CLAMP, Client::kWindow);
}

}  // namespace

class LwsClient::Handle final : public Client::Connection {
 public:
  explicit Handle(std::shared_ptr<Peer> peer) : peer_(std::move(peer)) {}
  ~Handle() override {
    peer_->listener = nullptr;
    if (peer_->is_over) return;
    peer_->is_over = true;
    if (peer_->client) peer_->client->drop(*peer_);
  }
  void read(bool wanted) override {
    if (peer_->is_over || peer_->is_read == wanted) return;
    peer_->is_read = wanted, peer_->since = Clock::now();
    if (peer_->wsi) lws_rx_flow_control(peer_->wsi, wanted ? 1 : 0);
  }
  bool send(bool binary, std::span<const std::byte> message) override {
    if (peer_->is_over || peer_->waiting + message.size() > kMostWaiting) return false;
    std::vector<unsigned char> bytes(LWS_PRE + message.size());
    if (!message.empty()) std::memcpy(bytes.data() + LWS_PRE, message.data(), message.size());
    peer_->waiting += message.size();
    peer_->messages.push_back({binary, std::move(bytes)});
    if (peer_->wsi && peer_->answer) lws_callback_on_writable(peer_->wsi);
    return true;
  }

 private:
  const std::shared_ptr<Peer> peer_;
};

LwsClient::LwsClient(lws_context* context, Options options)
    : options_(std::move(options)),
      context_(context),
      buffer_(LWS_PRE + kClientRead),
      resolver_(std::make_unique<Resolver>(options_.post)) {}

LwsClient::~LwsClient() {
  for (auto& [key, peer] : peers_) peer->client = nullptr, peer->wsi = nullptr, peer->is_over = true;
}

std::unique_ptr<LwsClient> LwsClient::make(lws_context* context, Options options, std::string& why) {
  std::unique_ptr<LwsClient> client(new LwsClient(context, std::move(options)));
  if (!client->host(false, why)) return nullptr;
  // The system's certificates are read when they are needed: it takes 25 ms and 0.7 MB.
  if (!client->options_.trust.empty() && !client->host(true, why)) return nullptr;
  return client;
}

lws_vhost* LwsClient::host(bool tls, std::string& why) {
  static const lws_protocols kProtocols[] = {
      {kClientName,
       [](lws* wsi, lws_callback_reasons reason, void*, void* in, std::size_t length) {
         return callback(wsi, static_cast<int>(reason), in, length);
       },
       0, kClientPiece, 0, nullptr, 0},
      {}};
  lws_vhost*& made = tls ? tls_host_ : host_;
  if (made) return made;
  const std::string& trust = options_.trust;
  lws_context_creation_info info{};
  info.port = CONTEXT_PORT_NO_LISTEN;
  info.vhost_name = tls ? "sinew-client-tls" : "sinew-client";
  info.protocols = kProtocols;
  info.options = LWS_SERVER_OPTION_DISABLE_IPV6;
  info.connect_timeout_secs = kConnect;
  // Other monitors are near: a proxy of the environment is none of theirs.
  info.http_proxy_address = "";
  if (tls) info.options |= LWS_SERVER_OPTION_DO_SSL_GLOBAL_INIT;
  if (tls && !trust.empty()) {
    info.options |= LWS_SERVER_OPTION_DISABLE_OS_CA_CERTS;
    info.client_ssl_ca_filepath = trust.c_str();
  }
  last_error().clear();
  lws_vhost* const host = lws_create_vhost(context_, &info);
  if (host && (!tls || trust.empty() || last_error().find("certs") == std::string::npos)) return made = host;
  why = tls && !trust.empty() ? fmt::format("{}: no certificates can be read from it", trust)
                              : "the client cannot be set up: " + last_error();
  return nullptr;
}

std::unique_ptr<Client::Connection> LwsClient::open(Call call, Listener& listener) {
  auto peer = std::make_shared<Peer>();
  peer->client = this, peer->listener = &listener, peer->since = Clock::now();
  peer->call = std::move(call);
  const Call& c = peer->call;
  std::size_t headers = 0;
  bool is_plain = is_one_line(c.target) && is_one_line(c.host) && is_one_line(c.subprotocol);
  for (const auto& [name, value] : c.headers)
    headers += name.size() + value.size() + 4, is_plain = is_plain && is_one_line(name) && is_one_line(value);
  if (!is_plain || c.target.size() > Call::kMostTarget || headers > Call::kMostHeaders)
    peer->why = "the request is too long to be passed on";
  else if (!resolver_ || options_.is_full())
    peer->why = "too many connections are open already";
  peers_[peer.get()] = peer;
  if (!peer->why.empty())
    options_.post([this, peer] { finish(*peer, End::lost, peer->why), forget(peer.get()); });
  else
    resolver_->resolve(c.host, [this, peer](const std::string& address, const std::string& why) {
      if (address.empty()) finish(*peer, End::lost, why);
      connect(peer, address);
    });
  return std::make_unique<Handle>(peer);
}

void LwsClient::connect(const std::shared_ptr<Peer>& peer, const std::string& address) {
  if (peer->is_over) return forget(peer.get());
  const Call& c = peer->call;
  const std::string name = fmt::format("{}:{}", c.host, c.port);
  lws_client_connect_info info{};
  info.context = context_, info.vhost = host(c.tls, peer->why);
  if (!info.vhost) {
    finish(*peer, End::lost, peer->why);
    return forget(peer.get());
  }
  info.address = address.c_str(), info.port = c.port, info.host = name.c_str(), info.path = c.target.c_str();
  info.ssl_connection = LCCSCF_HTTP_NO_FOLLOW_REDIRECT | (c.tls ? LCCSCF_USE_SSL : 0);
  if (peer->is_socket())
    info.protocol = c.subprotocol.c_str();
  else
    info.method = c.method.c_str();
  info.local_protocol_name = kClientName;
  info.ietf_version_or_minus_one = -1;
  info.alpn = "http/1.1";
  info.opaque_user_data = peer.get();
  info.pwsi = &peer->wsi;
  if (lws_client_connect_via_info(&info)) return;
  peer->wsi = nullptr;
  failed(*peer, "Unable to connect");
  forget(peer.get());
}

int LwsClient::callback(lws* wsi, int reason, void* in, std::size_t length) {
  switch (reason) {  // others may come without a connection
    case LWS_CALLBACK_WSI_CREATE:
    case LWS_CALLBACK_WSI_DESTROY:
    case LWS_CALLBACK_CLIENT_APPEND_HANDSHAKE_HEADER:
    case LWS_CALLBACK_CLIENT_HTTP_WRITEABLE:
    case LWS_CALLBACK_ESTABLISHED_CLIENT_HTTP:
    case LWS_CALLBACK_RECEIVE_CLIENT_HTTP:
    case LWS_CALLBACK_RECEIVE_CLIENT_HTTP_READ:
    case LWS_CALLBACK_COMPLETED_CLIENT_HTTP:
    case LWS_CALLBACK_CLOSED_CLIENT_HTTP:
    case LWS_CALLBACK_CLIENT_ESTABLISHED:
    case LWS_CALLBACK_CLIENT_RECEIVE:
    case LWS_CALLBACK_CLIENT_RECEIVE_PONG:
    case LWS_CALLBACK_CLIENT_WRITEABLE:
    case LWS_CALLBACK_CLIENT_CLOSED:
    case LWS_CALLBACK_CLIENT_CONNECTION_ERROR:
      break;
    default:
      return 0;
  }
  auto* const known = static_cast<Peer*>(lws_get_opaque_user_data(wsi));
  if (!known || !known->client) return 0;
  const auto at = known->client->peers_.find(known);
  if (at == known->client->peers_.end()) return 0;
  const std::shared_ptr<Peer> peer = at->second;  // stays until this call is over
  peer->wsi = wsi;                                // the first ones come before open() knows it
  return peer->client->called(*peer, reason, in, length);
}

int LwsClient::called(Peer& peer, int reason, void* in, std::size_t length) {
  lws* const wsi = peer.wsi;
  switch (reason) {
    case LWS_CALLBACK_WSI_CREATE:
      if (wsi) set_up(wsi);
      return 0;
    case LWS_CALLBACK_CLIENT_APPEND_HANDSHAKE_HEADER:
      return add_headers(peer, static_cast<unsigned char**>(in), length) ? 0 : -1;
    case LWS_CALLBACK_CLIENT_HTTP_WRITEABLE:
      return send_body(peer);
    case LWS_CALLBACK_ESTABLISHED_CLIENT_HTTP:
      return head(peer, false);
    case LWS_CALLBACK_CLIENT_ESTABLISHED:
      return head(peer, true);
    case LWS_CALLBACK_RECEIVE_CLIENT_HTTP: {
      char* at = reinterpret_cast<char*>(buffer_.data()) + LWS_PRE;
      int room = static_cast<int>(kClientRead);
      return lws_http_client_read(wsi, &at, &room) < 0 ? -1 : 0;
    }
    case LWS_CALLBACK_RECEIVE_CLIENT_HTTP_READ:
      return body(peer, static_cast<const char*>(in), length);
    case LWS_CALLBACK_COMPLETED_CLIENT_HTTP:
      finish(peer, End::whole, "");
      return -1;
    case LWS_CALLBACK_CLIENT_RECEIVE:
      return message(peer, static_cast<const std::byte*>(in), length);
    case LWS_CALLBACK_CLIENT_RECEIVE_PONG:
      peer.since = Clock::now();
      return 0;
    case LWS_CALLBACK_CLIENT_WRITEABLE:
      return send_message(peer);
    case LWS_CALLBACK_CLOSED_CLIENT_HTTP:
    case LWS_CALLBACK_CLIENT_CLOSED:
      finish(peer, End::lost, "it ended the connection");
      return 0;
    case LWS_CALLBACK_CLIENT_CONNECTION_ERROR:
      failed(peer, in && length > 0 ? std::string_view(static_cast<const char*>(in), length) : std::string_view());
      return 0;
    case LWS_CALLBACK_WSI_DESTROY:
      finish(peer, End::lost, "it ended the connection");
      forget(&peer);
      return 0;
    default:
      return 0;
  }
}

bool LwsClient::add_headers(Peer& peer, unsigned char** at, std::size_t room) {
  std::string text;
  for (const auto& [name, value] : peer.call.headers) text += fmt::format("{}: {}\r\n", name, value);
  if (peer.call.method == "POST") text += fmt::format("content-length: {}\r\n", peer.call.body.size());
  if (text.size() > room) return false;
  std::memcpy(*at, text.data(), text.size());
  *at += text.size();
  if (!peer.call.body.empty()) lws_client_http_body_pending(peer.wsi, 1);
  return true;
}

int LwsClient::send_body(Peer& peer) {
  const std::string& whole = peer.call.body;
  const std::size_t now = std::min(whole.size() - peer.sent, kClientPiece);
  if (now == 0) return 0;
  const bool is_last = peer.sent + now == whole.size();
  std::vector<unsigned char> piece(LWS_PRE + now);
  std::memcpy(piece.data() + LWS_PRE, whole.data() + peer.sent, now);
  if (is_last) lws_client_http_body_pending(peer.wsi, 0);
  const auto kind = is_last ? LWS_WRITE_HTTP_FINAL : LWS_WRITE_HTTP;
  if (lws_write(peer.wsi, piece.data() + LWS_PRE, now, kind) < static_cast<int>(now)) return -1;
  peer.sent += now;
  if (!is_last) lws_callback_on_writable(peer.wsi);
  return 0;
}

int LwsClient::head(Peer& peer, bool is_socket) {
  Answer answer;
  answer.status = is_socket ? 101 : static_cast<int>(lws_http_client_http_response(peer.wsi));
  // A WebSocket's head comes twice when it is opened; the first time it is not yet certain that it is.
  if (peer.is_socket() && !is_socket && answer.status == 101) return 0;
  const auto refuse = [&](const char* why) {
    peer.why = why;
    return -1;
  };
  if (!is_socket) {
    if (answer.status < 200 || answer.status > 599) return refuse("its answer is none of HTTP");
    // The library's reader of chunks trusts their lengths; no monitor sends chunks.
    if (!header_of(peer.wsi, WSI_TOKEN_HTTP_TRANSFER_ENCODING).empty()) return refuse("it answers in chunks");
    for (const auto& [name, token] : kKnownHeaders)
      if (std::string value = header_of(peer.wsi, token); !value.empty() && is_one_line(value))
        answer.headers.emplace_back(name, std::move(value));
    for (const char* name : kOwnHeaders)
      if (std::string value = custom_header(peer.wsi, std::string(name) + ":"); !value.empty() && is_one_line(value))
        answer.headers.emplace_back(name, std::move(value));
    if (const std::string text = header_of(peer.wsi, WSI_TOKEN_HTTP_CONTENT_LENGTH); !text.empty()) {
      std::uint64_t length = 0;
      if (!length_of(text, length)) return refuse("the length of its answer is no number");
      answer.length = length;
    }
  }
  peer.answer = answer, peer.since = Clock::now();
  const bool has_body = peer.call.method != "HEAD" && answer.status != 204 && answer.status != 304 && !peer.is_socket();
  if (peer.listener) peer.listener->answered(answer);
  if (peer.is_over) return -1;
  if (!is_socket && !has_body) {
    if (peer.is_socket())
      peer.why = fmt::format("it refuses: status {}", answer.status);
    else
      finish(peer, End::whole, "");
    return -1;
  }
  if (!peer.is_read) lws_rx_flow_control(peer.wsi, 0);
  if (!peer.messages.empty()) lws_callback_on_writable(peer.wsi);
  return 0;
}

int LwsClient::body(Peer& peer, const char* data, std::size_t length) {
  if (!peer.answer || length > kClientRead + LWS_PRE) return -1;
  if (peer.answer->length)
    length = static_cast<std::size_t>(std::min<std::uint64_t>(length, *peer.answer->length - peer.received));
  peer.received += length, peer.since = Clock::now();
  if (length > 0 && peer.listener)
    peer.listener->received({{reinterpret_cast<const std::byte*>(data), length}, true, false, false});
  if (!peer.is_over && peer.answer->length == peer.received) finish(peer, End::whole, "");
  return peer.is_over ? -1 : 0;
}

int LwsClient::message(Peer& peer, const std::byte* data, std::size_t length) {
  peer.since = Clock::now();
  if (peer.listener)
    peer.listener->received({{data, length},
                             lws_frame_is_binary(peer.wsi) != 0,
                             lws_is_first_fragment(peer.wsi) != 0,
                             lws_is_final_fragment(peer.wsi) != 0});
  return peer.is_over ? -1 : 0;
}

int LwsClient::send_message(Peer& peer) {
  if (peer.is_over) return -1;
  if (peer.asks) {
    peer.asks = false;
    unsigned char nothing[LWS_PRE];
    if (lws_write(peer.wsi, nothing + LWS_PRE, 0, LWS_WRITE_PING) < 0) return -1;
    lws_callback_on_writable(peer.wsi);
    return 0;
  }
  if (peer.messages.empty()) return 0;
  Peer::Message& first = peer.messages.front();
  const std::size_t left = first.bytes.size() - LWS_PRE - peer.sent, now = std::min(left, kClientPiece);
  const int kind = lws_write_ws_flags(first.binary ? LWS_WRITE_BINARY : LWS_WRITE_TEXT, peer.sent == 0, now == left);
  // What the library writes before the piece goes over bytes that have been sent.
  unsigned char* const from = first.bytes.data() + LWS_PRE + peer.sent;
  if (lws_write(peer.wsi, from, now, static_cast<lws_write_protocol>(kind)) < static_cast<int>(now)) return -1;
  peer.sent += now, peer.waiting -= now;
  if (now == left) peer.messages.pop_front(), peer.sent = 0;
  if (!peer.messages.empty()) lws_callback_on_writable(peer.wsi);
  return 0;
}

void LwsClient::failed(Peer& peer, std::string_view said) {
  constexpr std::string_view kDistrust = "SSL error: ";
  const std::string error = std::exchange(last_error(), "");
  if (!peer.why.empty()) return finish(peer, End::lost, peer.why);
  if (const std::size_t at = error.find(kDistrust); peer.call.tls && at != std::string::npos) {
    const std::size_t from = at + kDistrust.size();
    return finish(peer, End::distrusted,
                  "its certificate is not believed: " + error.substr(from, error.find(" (", from) - from));
  }
  if (said.find("Unable to connect") != std::string_view::npos)  // the library does not say why
    return finish(peer, End::lost,
                  Clock::now() - peer.since < std::chrono::seconds(kConnect)
                      ? "no connection: nothing listens there, or no way leads there"
                      : fmt::format("no connection: nobody answers there within {} s", kConnect));
  if (said.find("SSL") != std::string_view::npos) return finish(peer, End::lost, "it speaks no TLS");
  finish(peer, End::lost, peer.call.tls ? "it ended the connection" : "its answer is none of HTTP, or there is none");
}

void LwsClient::finish(Peer& peer, End how, const std::string& why) {
  peer.is_over = true;
  if (Listener* const listener = std::exchange(peer.listener, nullptr)) listener->ended(how, why);
}

void LwsClient::drop(Peer& peer) {
  if (peer.wsi) lws_set_timeout(peer.wsi, PENDING_TIMEOUT_USER_OK, LWS_TO_KILL_ASYNC);
}

void LwsClient::forget(Peer* peer) {
  peer->client = nullptr, peer->wsi = nullptr;
  peers_.erase(peer);
}

void LwsClient::tick(Clock::time_point now) {
  std::vector<std::shared_ptr<Peer>> all;  // whoever is told may open and leave others
  for (const auto& [key, peer] : peers_) all.push_back(peer);
  for (const auto& peer : all) {
    if (peer->is_over) continue;
    const auto silent = now - peer->since;
    const bool has_length = peer->answer && peer->answer->length;
    std::string why;
    if (!peer->answer ? silent > peer->call.patience : has_length && peer->is_read && silent > peer->call.patience)
      why = fmt::format("no answer within {} s", peer->call.patience.count());
    if (peer->answer && peer->is_socket() && peer->is_read) {
      if (silent > kLeaveAfter) why = fmt::format("it has said nothing for {} s", kLeaveAfter.count());
      peer->asks = silent > kAskAfter;
      if (peer->asks) lws_callback_on_writable(peer->wsi);
    }
    if (why.empty()) continue;
    finish(*peer, End::lost, why);
    drop(*peer);
  }
}

void LwsClient::end_all(const std::string& why) {
  resolver_.reset();  // what it posts needs the context
  std::vector<std::shared_ptr<Peer>> all;
  for (const auto& [key, peer] : peers_) all.push_back(peer);
  for (const auto& peer : all) finish(*peer, End::lost, why);
}

}  // namespace sinew::monitor
