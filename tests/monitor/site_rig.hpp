#pragma once
// A robot, and a monitor that shows it.
#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "../tap/tap_rig.hpp"
#include "http_client.hpp"
#include "monitor/site.hpp"

namespace sinew::monitor::test {

using Json = nlohmann::ordered_json;

struct RigOptions {
  bool commands = true;
  Runs::Options runs{};
  std::string sinew{};  // path of the program
  std::string token = "0123456789abcdef";
  std::uint16_t port = 0;
  std::string certificate{}, key{}, trust{};
  std::chrono::seconds patience{10};
};

class SiteRig {
 public:
  static constexpr const char* kToken = "0123456789abcdef";

  explicit SiteRig(RigOptions rig = {}) {
    ServerOptions options;
    options.port = rig.port;
    options.certificate = rig.certificate, options.key = rig.key, options.trust = rig.trust;
    options.patience = rig.patience;
    options.every_response = protective_headers();
    options.subprotocols = LiveSite::subprotocols();
    options.most_message_bytes = foxglove::kMostClientBytes;
    std::string why;
    server = Server::open(
        options,
        [this](Request r, ConnectionId id, const Server::Reply& reply) { site->answer(std::move(r), id, reply); },
        [this](const Request& r, ConnectionId id, Response& refusal) { return site->open_socket(r, id, refusal); },
        why);
    if (!server) {
      ADD_FAILURE() << why;
      return;
    }
    robots = std::make_unique<Robots>();
    Site::Options o;
    o.gate.hosts = {"127.0.0.1:" + std::to_string(server->port()), "localhost:" + std::to_string(server->port())};
    o.gate.token = rig.token;
    o.gate.commands = rig.commands;
    o.runs = std::move(rig.runs);
    o.sinew = std::move(rig.sinew);
    site = std::make_unique<Site>(*robots, *server, std::move(o));
    thread_ = std::thread([this] { server->run(); });
  }
  ~SiteRig() {
    if (!server) return;
    server->stop();
    thread_.join();
    site.reset();  // as the program does: before the robots and the server
    server.reset();
  }
  std::uint16_t port() const { return server->port(); }
  std::string address() const { return "127.0.0.1:" + std::to_string(port()); }
  /// Shows also what the monitor at this address shows.
  void with(const std::string& address) {
    std::string why;
    bool added = false;
    std::atomic<bool> done{false};
    server->post([&] {
      added = site->add_monitor(address, why);
      done = true;
    });
    while (!done) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_TRUE(added) << why;
  }
  static std::string token_line() { return std::string("Authorization: Bearer ") + kToken + "\r\n"; }

  std::unique_ptr<Server> server;
  std::unique_ptr<Robots> robots;
  std::unique_ptr<Site> site;

 private:
  std::thread thread_;
};

}  // namespace sinew::monitor::test
