#pragma once
// The Client in the context of a server. Inside of the room only.
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "monitor/http/client.hpp"
#include "monitor/http/resolver.hpp"

struct lws;
struct lws_context;
struct lws_vhost;

namespace sinew::monitor {

/// Owner:   outlives the context, whose end may still call it.
class LwsClient final : public Client {
 public:
  using Clock = std::chrono::steady_clock;
  struct Options {
    std::string trust{};  // file in PEM; empty: the system's certificates
    std::function<void(std::function<void()>)> post{};
    std::function<bool()> is_full{};
  };

  /// Errors: null, with `why`: the file of certificates.
  static std::unique_ptr<LwsClient> make(lws_context* context, Options options, std::string& why);
  ~LwsClient() override;

  std::unique_ptr<Connection> open(Call call, Listener& listener) override;

  std::size_t open_connections() const { return peers_.size(); }
  /// Leaves peers that say nothing. To be called each second.
  void tick(Clock::time_point now);
  /// Ends all connections, with this reason, and takes no more. Before the context ends.
  void end_all(const std::string& why);

  struct Peer;

 private:
  class Handle;
  LwsClient(lws_context* context, Options options);

  /// What connections belong to. Errors: null, with `why`.
  lws_vhost* host(bool tls, std::string& why);
  void connect(const std::shared_ptr<Peer>& peer, const std::string& address);
  static int callback(lws* wsi, int reason, void* in, std::size_t length);
  int called(Peer& peer, int reason, void* in, std::size_t length);
  int head(Peer& peer, bool is_socket);
  int body(Peer& peer, const char* data, std::size_t length);
  int message(Peer& peer, const std::byte* data, std::size_t length);
  bool add_headers(Peer& peer, unsigned char** at, std::size_t room);
  int send_body(Peer& peer);
  int send_message(Peer& peer);
  /// Tells the listener, once.
  void finish(Peer& peer, End how, const std::string& why);
  void failed(Peer& peer, std::string_view said);
  /// Closes the connection, from outside of its callbacks.
  void drop(Peer& peer);
  void forget(Peer* peer);

  const Options options_;
  lws_context* const context_;
  lws_vhost *host_ = nullptr, *tls_host_ = nullptr;
  std::map<Peer*, std::shared_ptr<Peer>> peers_;
  std::vector<unsigned char> buffer_;
  std::unique_ptr<Resolver> resolver_;  // null: it ends
};

}  // namespace sinew::monitor
