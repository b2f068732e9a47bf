#pragma once
// A robot, and a monitor that shows it.
#include <memory>
#include <string>
#include <thread>

#include "../tap/tap_rig.hpp"
#include "http_client.hpp"
#include "monitor/site.hpp"

namespace sinew::monitor::test {

using Json = nlohmann::ordered_json;

class SiteRig {
 public:
  static constexpr const char* kToken = "0123456789abcdef";

  explicit SiteRig(bool commands = true, Runs::Options runs = {}, std::string sinew = {}) {
    ServerOptions options;
    options.port = 0;
    options.every_response = protective_headers();
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
    o.gate.token = kToken;
    o.gate.commands = commands;
    o.runs = std::move(runs);
    o.sinew = std::move(sinew);
    site = std::make_unique<Site>(*robots, *server, std::move(o));
    thread_ = std::thread([this] { server->run(); });
  }
  ~SiteRig() {
    if (!server) return;
    server->stop();
    thread_.join();
    site->stop();
  }
  std::uint16_t port() const { return server->port(); }
  static std::string token_line() { return std::string("Authorization: Bearer ") + kToken + "\r\n"; }

  std::unique_ptr<Server> server;
  std::unique_ptr<Robots> robots;
  std::unique_ptr<Site> site;

 private:
  std::thread thread_;
};

}  // namespace sinew::monitor::test
