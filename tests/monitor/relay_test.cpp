// A monitor that shows what another one shows.
#include "monitor/relay.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>

#include "site_rig.hpp"
#include "web_socket.hpp"

namespace sinew::monitor::relay_test {
namespace {

using test::HttpClient;
using test::Json;
using test::Reply;
using test::RigOptions;
using test::SiteRig;
using test::WebSocket;
using namespace std::chrono_literals;

constexpr const char* kFar = "fedcba9876543210";  // the token of the other monitor

std::string far_token() { return std::string("Authorization: Bearer ") + kFar + "\r\n"; }
Json parsed(const Reply& reply) { return Json::parse(reply.body, nullptr, false); }

bool comes_true(const std::function<bool()>& what) {
  const auto until = std::chrono::steady_clock::now() + 10s;
  while (!what()) {
    if (std::chrono::steady_clock::now() > until) return false;
    std::this_thread::sleep_for(5ms);
  }
  return true;
}

/// What the list says of the only monitor in it, once it has been looked at.
Json state_of_the_other(HttpClient& client) {
  Json one;
  comes_true([&] {
    one = parsed(client.get("/api/monitors"))["monitors"][0];
    return one["why"] != "not asked yet";
  });
  return one;
}

/// A robot with two monitors of its machine: one stands for that of another machine.
class MonitorRelay : public testing::Test {
 protected:
  tap::OwnRunDir dir_;
  tap::Robot robot_;
  std::unique_ptr<SiteRig> far_;
  SiteRig near_;
  HttpClient client_{near_.port()};
  std::string at_;

  void SetUp() override {
    robot_.start();
    far_ = std::make_unique<SiteRig>(RigOptions{.token = kFar});
    far_->robots->look();
    near_.with(far_->address());
    at_ = "/at/" + far_->address();
  }
};

TEST_F(MonitorRelay, RobotsAndPicturesOfTheOtherAreReachedBelowItsAddress) {
  EXPECT_EQ(parsed(client_.get("/api"))["monitors"], true);
  EXPECT_EQ(parsed(client_.get(at_ + "/api"))["program"], "sinew-monitor");
  EXPECT_EQ(parsed(client_.get(at_ + "/api/robots"))["robots"][0]["robot"], "robot");
  EXPECT_GT(parsed(client_.get(at_ + "/api/robots/robot/timeline?last_ms=50"))["columns"].size(), 2u);
  EXPECT_EQ(client_.get(at_ + "/api/robots/nobody/status").status, 404);
  const Reply jpeg = client_.get(at_ + "/robot/images/eye.image.jpg?scale=0.5&region=0%2C0,80,50");
  EXPECT_EQ(jpeg.headers.at("content-type"), "image/jpeg");
  EXPECT_EQ(jpeg.body.substr(0, 2), "\xff\xd8");
  EXPECT_GT(std::stoul(jpeg.headers.at("x-sinew-sequence")), 0u);
  const Reply head = client_.ask("HEAD", at_ + "/robot/images/eye.image.png");
  EXPECT_GT(std::stoul(head.headers.at("content-length")), 0u);
  robot_.real->stop();
  const Reply last = client_.get(at_ + "/robot/images/eye.image.png");
  EXPECT_EQ(last.body.substr(1, 3), "PNG");
  const std::string tag = "If-None-Match: " + last.headers.at("etag") + "\r\n";
  EXPECT_EQ(client_.get(at_ + "/robot/images/eye.image.png", tag).status, 304);
  EXPECT_EQ(client_.get(at_ + "/api/robots").status, 200);
  EXPECT_EQ(near_.server->counters().accepted, 1u);  // all of it went over one connection of the page
}

TEST_F(MonitorRelay, AMovieComesThrough) {
  client_.send("GET " + at_ + "/robot/images/eye.image.mjpg HTTP/1.1\r\nHost: " + client_.host() + "\r\n\r\n");
  const Reply head = client_.reply(true);
  EXPECT_EQ(head.headers.at("content-type").substr(0, 25), "multipart/x-mixed-replace");
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(client_.wait_for("\r\ncontent-type: image/jpeg\r\n"));
  robot_.real->stop();  // a robot that ends publishes nothing more
  robot_.server.reset(), robot_.name.reset();
  EXPECT_TRUE(client_.is_ended());
}

TEST_F(MonitorRelay, AMovieThatNobodyWatchesAnyMoreIsLeft) {
  {
    HttpClient viewer(near_.port());
    viewer.send("GET " + at_ + "/robot/images/eye.image.mjpg HTTP/1.1\r\nHost: " + viewer.host() + "\r\n\r\n");
    EXPECT_TRUE(viewer.wait_for("image/jpeg"));
    EXPECT_EQ(far_->server->counters().open, 1u);
  }
  EXPECT_TRUE(comes_true([&] { return far_->server->counters().open == 0; }));
}

TEST_F(MonitorRelay, AWebSocketSpeaksWithTheRobotsOfTheOther) {
  WebSocket socket(near_.port(), at_ + "/robot");
  ASSERT_TRUE(socket.is_open());
  EXPECT_NE(socket.wait_for("serverInfo").bytes.find("sinew monitor"), std::string::npos);
  const Json channels = Json::parse(socket.wait_for("\"advertise\"").bytes)["channels"];
  Json::number_unsigned_t picture = 0;
  for (const auto& c : channels)
    if (c["topic"] == "/eye.image") picture = c["id"];
  socket.send(R"({"op": "subscribe", "subscriptions": [{"id": 7, "channelId": )" + std::to_string(picture) + "}]}");
  for (int i = 0; i < 5; ++i) {
    WebSocket::Message m;
    do m = socket.receive();
    while (m.opcode == 1);
    ASSERT_EQ(m.opcode, 2);
    // Every pixel of a frame has its number.
    const std::string pixels = m.bytes.substr(m.bytes.size() - 1000);
    EXPECT_EQ(pixels, std::string(1000, pixels[0]));
  }
  WebSocket all(near_.port(), at_ + "/", "foxglove.sdk.v1");
  EXPECT_NE(all.wait_for("advertise").bytes.find("/robot/eye.image"), std::string::npos);
  EXPECT_EQ(WebSocket(near_.port(), at_ + "/robot/more").status(), 404);
  const WebSocket::Message end = WebSocket(near_.port(), at_ + "/nobody").end();
  EXPECT_EQ(end.code(), 1013);
  EXPECT_EQ(end.why(), far_->address() + ": it refuses: status 404");
}

TEST_F(MonitorRelay, TheOtherMonitorDecidesWhoCommands) {
  const std::string set = at_ + "/api/robots/robot/param.set";
  const std::string body = R"({"module": "counter", "param": "gain", "value": 2})";
  const auto gain = [&] {
    return parsed(client_.get(at_ + "/api/robots/robot/params?module=counter"))["params"][0]["value"];
  };
  EXPECT_EQ(client_.post(set, body, "").status, 401);
  EXPECT_EQ(client_.post(set, body, "Authorization: Bearer guess\r\n").status, 401);
  EXPECT_EQ(gain(), 1.0);
  EXPECT_EQ(client_.post(set, body, far_token()).status, 200);
  EXPECT_EQ(gain(), 2.0);
  const std::string late = far_token() + "X-Sinew-Until-Ns: 1\r\n";
  EXPECT_EQ(client_.post(set, body, late).status, 408);
  const std::string control = at_ + "/api/robots/robot/control";
  const Json taken = parsed(client_.post(control, R"({"action": "take", "who": "Ada"})", far_token()));
  EXPECT_EQ(client_.post(set, body, far_token()).status, 409);
  const std::string key = "X-Sinew-Control: " + taken["key"].get<std::string>() + "\r\n";
  EXPECT_EQ(client_.post(set, body, far_token() + key).status, 200);
  WebSocket commands(near_.port(), at_ + "/robot?token=" + kFar);
  EXPECT_NE(commands.wait_for("serverInfo").bytes.find("clientPublish"), std::string::npos);
  WebSocket looks(near_.port(), at_ + "/robot");
  EXPECT_EQ(looks.wait_for("serverInfo").bytes.find("clientPublish"), std::string::npos);
  EXPECT_EQ(WebSocket(near_.port(), at_ + "/robot?token=guess").end().code(), 1008);
}

TEST_F(MonitorRelay, TheOtherMonitorNeverLearnsOurToken) {
  const Reply refused = client_.post(at_ + "/api/robots/robot/stop", "{}", SiteRig::token_line());
  EXPECT_EQ(refused.status, 403);
  EXPECT_EQ(WebSocket(near_.port(), at_ + "/robot?token=" + SiteRig::kToken).status(), 403);
  EXPECT_EQ(far_->server->counters().accepted, 0u);
}

TEST_F(MonitorRelay, OurGateStaysInFront) {
  EXPECT_EQ(client_.get(at_ + "/api", "Origin: http://evil.example\r\n").status, 403);
  EXPECT_EQ(
      WebSocket(near_.port(), at_ + "/robot", "foxglove.websocket.v1", "Origin: http://evil.example\r\n").status(),
      403);
  EXPECT_EQ(far_->server->counters().accepted, 0u);
}

TEST_F(MonitorRelay, OnlyWhatPagesNeedIsRelayedAndNoRelayOfARelay) {
  far_->with(near_.address());
  for (const std::string path : {"/", "", "/assets/page.js", "/panels/a.js", "/index.html", "/at", "/apix"})
    EXPECT_EQ(client_.get(at_ + path).status, 404) << path;
  EXPECT_EQ(client_.get(at_ + "/at/" + near_.address() + "/api").status, 404);
  EXPECT_EQ(client_.get("/at/127.0.0.1:1/api").status, 404);
  EXPECT_EQ(client_.ask("DELETE", at_ + "/api").status, 405);
  EXPECT_EQ(far_->server->counters().accepted, 0u);
}

TEST_F(MonitorRelay, AnotherMonitorThatEndsIsSaidAndComesBack) {
  WebSocket socket(near_.port(), at_ + "/robot");
  EXPECT_EQ(socket.wait_for("serverInfo").opcode, 1);
  EXPECT_EQ(state_of_the_other(client_)["state"], "reached");
  const std::uint16_t port = far_->port();
  far_.reset();
  EXPECT_EQ(socket.end().code(), 1013);
  const Reply gone = client_.get(at_ + "/api/robots");
  EXPECT_EQ(gone.status, 502);
  EXPECT_NE(
      parsed(gone)["error"]["why"].get<std::string>().find("127.0.0.1:" + std::to_string(port) + ": no connection"),
      std::string::npos)
      << gone.body;
  EXPECT_EQ(client_.get(at_ + "/robot/images/eye.image.jpg").status, 502);
  EXPECT_TRUE(comes_true([&] { return state_of_the_other(client_)["state"] == "not reached"; }));
  far_ = std::make_unique<SiteRig>(RigOptions{.token = kFar, .port = port});
  EXPECT_EQ(client_.get(at_ + "/api/robots").status, 200);
  EXPECT_TRUE(comes_true([&] { return state_of_the_other(client_)["state"] == "reached"; }));
  EXPECT_TRUE(WebSocket(near_.port(), at_ + "/robot").wait_for("serverInfo").opcode == 1);
}

TEST_F(MonitorRelay, TheTokenAddsAndRemovesMonitors) {
  const std::string third = near_.address();  // itself
  const auto post = [&](const std::string& path, const std::string& address, const std::string& more) {
    return client_.post("/api/monitors" + path, R"({"address": ")" + address + "\"}", more);
  };
  const std::string ours = SiteRig::token_line();
  EXPECT_EQ(post("", third, "").status, 401);
  EXPECT_EQ(post("/remove", far_->address(), "").status, 401);
  EXPECT_EQ(post("", third, ours).status, 200);
  EXPECT_EQ(post("", third, ours).status, 200);
  EXPECT_EQ(parsed(client_.get("/api/monitors"))["monitors"].size(), 2u);
  EXPECT_EQ(client_.get("/at/" + third + "/api/robots").status, 200);
  for (const std::string bad : {"", "desk", "desk:", "desk:0", "desk:65536", "de sk:80", "desk:80/x", "ftp://desk:80",
                                "a/b:80", "[::1]:80", "desk:8080:1"})
    EXPECT_EQ(post("", bad, ours).status, 400) << bad;
  EXPECT_EQ(post("/remove", "desk:1", ours).status, 404);
  WebSocket socket(near_.port(), at_ + "/robot");
  EXPECT_EQ(socket.wait_for("serverInfo").opcode, 1);
  HttpClient movie(near_.port());
  movie.send("GET " + at_ + "/robot/images/eye.image.mjpg HTTP/1.1\r\nHost: " + movie.host() + "\r\n\r\n");
  EXPECT_TRUE(movie.wait_for("image/jpeg"));
  EXPECT_EQ(post("/remove", far_->address(), ours).status, 200);
  EXPECT_EQ(socket.end().code(), 1013);
  EXPECT_TRUE(movie.is_ended());
  EXPECT_EQ(client_.get(at_ + "/api").status, 404);
  EXPECT_TRUE(comes_true([&] { return far_->server->counters().open == 0; }));
  for (std::size_t i = 1; i < Monitors::kMost; ++i)
    EXPECT_EQ(post("", "127.0.0.1:" + std::to_string(i), ours).status, 200);
  EXPECT_EQ(post("", "127.0.0.1:99", ours).status, 400);
}

TEST_F(MonitorRelay, TheListSaysWhichMonitorsAnswerAndWhyNot) {
  const Json one = state_of_the_other(client_);
  EXPECT_EQ(one["address"], far_->address());
  EXPECT_EQ(one["state"], "reached");
  EXPECT_EQ(one["program"], "sinew-monitor");
  EXPECT_EQ(one["commands"], true);
  SiteRig other;
  other.with("localhost:" + std::to_string(far_->port()));
  HttpClient client(other.port());
  EXPECT_EQ(state_of_the_other(client)["state"], "reached");  // by its name
  SiteRig stranger;
  stranger.with("no-such-host.invalid:80");
  HttpClient asks(stranger.port());
  const Json none = state_of_the_other(asks);
  EXPECT_EQ(none["state"], "not reached");
  EXPECT_NE(none["why"].get<std::string>().find("no-such-host.invalid"), std::string::npos);
}

TEST_F(MonitorRelay, AMonitorThatDoesNotKnowItsNameSaysSo) {
  SiteRig other;
  other.with("127.1:" + std::to_string(far_->port()));  // leads to 127.0.0.1
  HttpClient client(other.port());
  const Json one = state_of_the_other(client);
  EXPECT_EQ(one["state"], "refused");
  EXPECT_NE(one["why"].get<std::string>().find("--host NAME adds a name"), std::string::npos) << one;
}

// ---- other monitors that are none

/// Takes connections, and does with each what the test says.
class FakeRemote {
 public:
  explicit FakeRemote(std::function<void(int fd, const std::string& head)> serve) : serve_(std::move(serve)) {
    listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in own{};
    socklen_t size = sizeof own;
    own.sin_family = AF_INET, own.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(bind(listener_, reinterpret_cast<const sockaddr*>(&own), size), 0);
    EXPECT_EQ(listen(listener_, 16), 0);
    getsockname(listener_, reinterpret_cast<sockaddr*>(&own), &size);
    port_ = ntohs(own.sin_port);
    thread_ = std::thread([this] { run(); });
  }
  ~FakeRemote() {
    over_ = true;
    shutdown(listener_, SHUT_RDWR);
    thread_.join();
    close(listener_);
  }
  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }
  std::string head() {
    const std::lock_guard lock(mutex_);
    return head_;
  }
  static bool say(int fd, std::string_view text) {
    while (!text.empty()) {
      const ssize_t n = ::send(fd, text.data(), text.size(), MSG_NOSIGNAL);
      if (n <= 0) return false;
      text.remove_prefix(static_cast<std::size_t>(n));
    }
    return true;
  }

 private:
  void run() {
    while (!over_) {
      const int fd = accept(listener_, nullptr, nullptr);
      if (fd < 0) return;
      timeval patience{3, 0};
      setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
      setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
      std::string head;
      char c = 0;
      while (head.find("\r\n\r\n") == std::string::npos && recv(fd, &c, 1, 0) == 1) head += c;
      {
        const std::lock_guard lock(mutex_);
        head_ = head;
      }
      serve_(fd, head);
      close(fd);
    }
  }
  const std::function<void(int, const std::string&)> serve_;
  int listener_ = -1;
  std::uint16_t port_ = 0;
  std::atomic<bool> over_{false};
  std::mutex mutex_;
  std::string head_;
  std::thread thread_;
};

class MonitorRelayTo : public testing::Test {
 protected:
  tap::OwnRunDir dir_;
  SiteRig near_;
  HttpClient client_{near_.port()};

  /// What a page gets from a remote that says this to each request.
  Reply answer_to(const std::string& says, const std::string& path = "/api/robots") {
    FakeRemote remote([&](int fd, const std::string&) { FakeRemote::say(fd, says); });
    near_.with(remote.address());
    HttpClient client(near_.port());
    return client.get("/at/" + remote.address() + path);
  }
  void TearDown() override { EXPECT_EQ(HttpClient(near_.port()).get("/api").status, 200); }
};

TEST_F(MonitorRelayTo, TheOtherSeesItsOwnNameAndWhatMeansSomething) {
  FakeRemote remote([](int fd, const std::string&) {
    FakeRemote::say(fd,
                    "HTTP/1.1 200 OK\r\nContent-Type: application/json\r\nContent-Length: 2\r\n"
                    "Set-Cookie: a=b\r\nLocation: /x\r\nETag: \"7\"\r\n\r\n{}");
  });
  near_.with(remote.address());
  const std::string at = "/at/" + remote.address();
  const Reply r = client_.post(at + "/api/robots/a%20b/stop?x=%26%3d+1", "{}",
                               "Origin: http://" + client_.host() + "\r\nCookie: a=b\r\nX-Other: 1\r\n" + far_token() +
                                   "X-Sinew-Control: key\r\nX-Sinew-Until-Ns: 5\r\n");
  EXPECT_EQ(r.status, 200);
  EXPECT_EQ(r.headers.count("set-cookie"), 0u);
  EXPECT_EQ(r.headers.count("location"), 0u);
  EXPECT_EQ(r.headers.at("etag"), "\"7\"");
  const std::string head = remote.head();
  EXPECT_EQ(head.substr(0, head.find("\r\n")), "POST /api/robots/a%20b/stop?x=%26%3D%201 HTTP/1.1");
  for (const std::string& part :
       {"Host: " + remote.address(), "authorization: Bearer " + std::string(kFar), std::string("x-sinew-control: key"),
        std::string("x-sinew-until-ns: 5"), std::string("content-length: 2")})
    EXPECT_NE(head.find(part), std::string::npos) << head;
  for (const std::string part : {"Origin", "Cookie", "X-Other", "x-other"})
    EXPECT_EQ(head.find(part), std::string::npos) << head;
}

TEST_F(MonitorRelayTo, PagesOfTheOtherDoNotBecomeOurs) {
  const std::string script = "<script>fetch('/api')</script>";
  const Reply html =
      answer_to("HTTP/1.1 200 OK\r\nContent-Type: text/html\r\nContent-Length: " + std::to_string(script.size()) +
                "\r\n\r\n" + script);
  EXPECT_EQ(html.headers.at("content-type"), "application/octet-stream");
  EXPECT_EQ(html.headers.at("content-security-policy"), "sandbox; default-src 'none'");
  EXPECT_EQ(html.headers.at("x-content-type-options"), "nosniff");
  EXPECT_EQ(answer_to("HTTP/1.1 200 OK\r\nContent-Length: 1\r\n\r\nx").headers.at("content-type"),
            "application/octet-stream");
  EXPECT_EQ(answer_to("HTTP/1.1 302 Found\r\nLocation: http://127.0.0.1:1/\r\nContent-Length: 0\r\n\r\n").status, 502);
}

TEST_F(MonitorRelayTo, WhatIsNoAnswerIsSaidWith502) {
  EXPECT_EQ(answer_to("").status, 502);
  EXPECT_EQ(answer_to("SSH-2.0-OpenSSH_9.2\r\n").status, 502);
  EXPECT_EQ(answer_to("\x16\x03\x01\x02\r\n\r\n\r\n").status, 502);
  EXPECT_EQ(answer_to("HTTP/1.1 200 OK\r\nX: " + std::string(1 << 20, 'x') + "\r\n\r\n").status, 502);
  EXPECT_EQ(answer_to("HTTP/1.1 100 Continue\r\n\r\n").status, 502);
  EXPECT_EQ(answer_to("HTTP/1.1 200 OK\r\nContent-Length: -5\r\n\r\nx").status, 502);
  EXPECT_EQ(answer_to("HTTP/1.1 200 OK\r\nContent-Length: 99999999999999999999\r\n\r\nx").status, 502);
  // The length of this chunk is below zero for a reader with 32 bits.
  EXPECT_EQ(
      answer_to("HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\nfffffff0\r\n" + std::string(5000, 'x')).status,
      502);
}

TEST_F(MonitorRelayTo, AnAnswerThatEndsTooEarlyIsSeenToEnd) {
  const Reply r = answer_to("HTTP/1.1 200 OK\r\nContent-Length: 100\r\n\r\nshort");
  EXPECT_EQ(r.status, 200);
  EXPECT_TRUE(r.closed);
  const Reply longer = answer_to("HTTP/1.1 200 OK\r\nContent-Length: 5\r\n\r\nshort and more");
  EXPECT_EQ(longer.body, "short");
}

TEST_F(MonitorRelayTo, OneThatSaysNothingIsLeftAndHoldsUpNobody) {
  std::atomic<bool> over{false};
  FakeRemote remote([&](int, const std::string&) {
    while (!over) std::this_thread::sleep_for(5ms);
  });
  near_.with(remote.address());
  HttpClient waits(near_.port());
  waits.send("GET /at/" + remote.address() + "/api/robots HTTP/1.1\r\nHost: " + waits.host() + "\r\n\r\n");
  for (int i = 0; i < 10; ++i) EXPECT_EQ(client_.get("/api").status, 200);
  const Reply r = waits.reply(false, 20s);
  EXPECT_EQ(r.status, 502);
  EXPECT_NE(r.body.find("no answer within"), std::string::npos) << r.body;
  over = true;
}

TEST_F(MonitorRelayTo, NoMoreThanAFewConnectionsGoToOneMonitor) {
  std::atomic<bool> over{false};
  FakeRemote remote([&](int, const std::string&) {
    while (!over) std::this_thread::sleep_for(5ms);
  });
  near_.with(remote.address());
  std::vector<std::unique_ptr<HttpClient>> all;
  for (std::size_t i = 0; i < Relay::kMostOfOne; ++i) {
    all.push_back(std::make_unique<HttpClient>(near_.port(), 0x7f000002));
    all.back()->send("GET /at/" + remote.address() + "/api HTTP/1.1\r\nHost: " + client_.host() + "\r\n\r\n");
  }
  EXPECT_TRUE(comes_true([&] { return near_.server->counters().requests >= Relay::kMostOfOne; }));
  EXPECT_EQ(client_.get("/at/" + remote.address() + "/api").status, 503);
  over = true;
}

/// Answers the handshake of a WebSocket.
bool upgrade(int fd, const std::string& head) {
  // The answer to the key needs SHA-1: let the system's tool make it.
  const std::size_t at = head.find("Sec-WebSocket-Key: ");
  if (at == std::string::npos) return false;
  const std::string key = head.substr(at + 19, 24);
  const std::string command =
      "printf %s " + key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11 | openssl dgst -sha1 -binary | openssl base64";
  std::FILE* const pipe = popen(command.c_str(), "r");
  char text[64] = "";
  const bool read = std::fgets(text, sizeof text, pipe) != nullptr;
  pclose(pipe);
  std::string accept = text;
  while (!accept.empty() && accept.back() == '\n') accept.pop_back();
  return read && FakeRemote::say(fd,
                                 "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                                 "Sec-WebSocket-Accept: " +
                                     accept + "\r\nSec-WebSocket-Protocol: foxglove.websocket.v1\r\n\r\n");
}

TEST_F(MonitorRelayTo, GarbageOnAWebSocketEndsItAlone) {
  const std::string garbage[] = {
      std::string(3000, '\xff'),
      std::string("\x83\x01x", 3),                                   // an opcode that is none
      std::string("\x89\x7e\xff\xff", 4) + std::string(70000, 'p'),  // a ping that is too long
      std::string("\x82\x7f\xff\xff\xff\xff\xff\xff\xff\xff", 10),   // a length with its highest bit
      std::string("\x80\x01x", 3),                                   // a continuation of nothing
      std::string("\x88\x01x", 3),                                   // an end with half a code
      std::string("\x02\x00\x02\x00", 4)};                           // a message within a message
  if (std::system("openssl version > /dev/null 2>&1") != 0) GTEST_SKIP() << "no openssl";
  for (const std::string& bytes : garbage) {
    FakeRemote remote([&](int fd, const std::string& head) {
      if (!upgrade(fd, head)) return;
      FakeRemote::say(fd, std::string("\x81\x02hi", 4) + bytes);
      char c = 0;
      while (recv(fd, &c, 1, 0) > 0) {
      }
    });
    near_.with(remote.address());
    WebSocket socket(near_.port(), "/at/" + remote.address() + "/robot");
    ASSERT_TRUE(socket.is_open());
    EXPECT_EQ(socket.receive().bytes, "hi");
    EXPECT_EQ(socket.end().code(), 1013);
  }
}

/// Sends one message after the other for as long as they are taken.
class Source final : public Socket {
 public:
  static constexpr std::size_t kSize = 1'000'003;
  explicit Source(std::atomic<std::size_t>& taken) : taken_(taken) {}
  bool receive(bool, std::span<const std::byte> message) override {
    echo_ = std::vector<std::byte>(message.begin(), message.end());
    return true;
  }
  std::optional<Message> next() override {
    ++taken_;
    auto bytes = std::make_shared<std::vector<std::byte>>(kSize);
    for (std::size_t i = 0; i < kSize; ++i) (*bytes)[i] = static_cast<std::byte>((i * 7 + count_) % 251);
    ++count_;
    return Message{true, bytes};
  }

 private:
  std::atomic<std::size_t>& taken_;
  std::size_t count_ = 0;
  std::vector<std::byte> echo_;
};

/// Reads nothing at first, then everything, from a monitor whose WebSocket never ends.
void expect_back_pressure(ServerOptions options, const std::string& scheme, const std::string& trust) {
  std::atomic<std::size_t> taken{0};
  options.port = 0, options.subprotocols = LiveSite::subprotocols();
  std::string why;
  const auto remote = Server::open(
      options, [](const Request&, ConnectionId, const Server::Reply& reply) { reply(plain(404, "none")); },
      [&](const Request&, ConnectionId, Response&) { return std::make_unique<Source>(taken); }, why);
  ASSERT_TRUE(remote) << why;
  std::thread thread([&] { remote->run(); });
  {
    const std::string address = "127.0.0.1:" + std::to_string(remote->port());
    SiteRig near({.trust = trust});
    near.with(scheme + address);
    WebSocket socket(near.port(), "/at/" + address + "/robot");
    EXPECT_TRUE(socket.is_open());
    EXPECT_TRUE(comes_true([&] { return taken > 0; }));
    std::size_t before = 0;
    do {
      before = taken;
      std::this_thread::sleep_for(300ms);
    } while (taken != before);
    // The systems of the reader and of the other hold some, too; without back pressure it would be hundreds by now.
    EXPECT_LT(before, 12u);
    for (std::size_t i = 0; i < 30; ++i) {
      const WebSocket::Message m = socket.receive();
      EXPECT_EQ(m.bytes.size(), Source::kSize);
      if (m.bytes.size() != Source::kSize) break;
      std::size_t wrong = 0;
      for (std::size_t k = 0; k < m.bytes.size(); ++k)
        wrong += static_cast<std::uint8_t>(m.bytes[k]) != (k * 7 + i) % 251 ? 1 : 0;
      EXPECT_EQ(wrong, 0u) << i;
    }
  }
  remote->stop();
  thread.join();
}

TEST_F(MonitorRelayTo, WhatTheReaderDoesNotTakeStaysWithTheOther) { expect_back_pressure({}, "", ""); }

TEST_F(MonitorRelayTo, AWebSocketWhoseOtherEndIsDeadIsClosedAndOneThatHasNothingToSayIsNot) {
  if (std::system("openssl version > /dev/null 2>&1") != 0) GTEST_SKIP() << "no openssl";
  std::atomic<bool> over{false};
  FakeRemote dead([&](int fd, const std::string& head) {
    if (!upgrade(fd, head)) return;
    while (!over) std::this_thread::sleep_for(5ms);
  });
  SiteRig far({.token = kFar});  // without a robot it has nothing to say after the first messages
  near_.with(dead.address()), near_.with(far.address());
  WebSocket silent(near_.port(), "/at/" + far.address() + "/");
  WebSocket gone(near_.port(), "/at/" + dead.address() + "/robot");
  EXPECT_EQ(gone.receive(30s).why(), dead.address() + ": it has said nothing for 15 s");
  over = true;
  silent.send(R"({"op": "getParameters", "parameterNames": [], "id": "still there"})");
  EXPECT_NE(silent.wait_for("still there").bytes.find("parameterValues"), std::string::npos);
}

// ---- TLS

class MonitorRelayTls : public testing::Test {
 protected:
  tap::OwnRunDir dir_;

  /// Makes `name`.pem and `name`.key for 127.0.0.1, or for another name. False: there is no openssl.
  bool certificate(const std::string& name, const std::string& subject = "IP:127.0.0.1") const {
    const std::string command =
        "openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 2 "
        "-subj /CN=monitor -addext subjectAltName=" +
        subject + " -keyout " + path(name + ".key") + " -out " + path(name + ".pem") + " > /dev/null 2>&1";
    return std::system(command.c_str()) == 0;
  }
  std::string path(const std::string& name) const { return dir_.path() + "/" + name; }
};

TEST_F(MonitorRelayTls, AMonitorWithTlsIsReachedWhenItsCertificateIsTrusted) {
  if (!certificate("good") || !certificate("bad") || !certificate("elsewhere", "DNS:elsewhere"))
    GTEST_SKIP() << "no openssl";
  tap::Robot robot;
  robot.start();
  SiteRig far({.token = kFar, .certificate = path("good.pem"), .key = path("good.key")});
  const auto state = [&](const std::string& trust, const SiteRig& to, const std::string& scheme = "https://") {
    SiteRig near({.trust = trust});
    near.with(scheme + to.address());
    HttpClient client(near.port());
    Json one = state_of_the_other(client);
    return one["state"].get<std::string>() + ": " + one["why"].get<std::string>();
  };
  EXPECT_EQ(state(path("good.pem"), far), "reached: ");
  EXPECT_EQ(state(path("bad.pem"), far).substr(0, 42), "refused: its certificate is not believed: ");
  EXPECT_EQ(state("", far).substr(0, 42), "refused: its certificate is not believed: ");
  EXPECT_EQ(state("", far, "").substr(0, 7), "not rea");  // it was asked without TLS
  {                                                       // a robot takes few connections of one program
    SiteRig elsewhere({.certificate = path("elsewhere.pem"), .key = path("elsewhere.key")});
    EXPECT_NE(state(path("elsewhere.pem"), elsewhere).find("not believed: IP address mismatch"), std::string::npos);
  }
  {
    SiteRig bare;
    EXPECT_EQ(state(path("good.pem"), bare).substr(0, 7), "not rea");
  }

  SiteRig near({.trust = path("good.pem")});
  near.with("https://" + far.address());
  HttpClient client(near.port());
  const std::string at = "/at/" + far.address();
  EXPECT_EQ(client.get(at + "/robot/images/eye.image.png").body.substr(1, 3), "PNG");
  EXPECT_EQ(client
                .post(at + "/api/robots/robot/param.set", R"({"module": "counter", "param": "gain", "value": 2})",
                      far_token())
                .status,
            200);
  WebSocket socket(near.port(), at + "/robot");
  EXPECT_EQ(socket.wait_for("serverInfo").opcode, 1);
}

TEST_F(MonitorRelayTls, WhatTheReaderDoesNotTakeStaysWithTheOther) {
  if (!certificate("good")) GTEST_SKIP() << "no openssl";
  ServerOptions options;
  options.certificate = path("good.pem"), options.key = path("good.key");
  expect_back_pressure(options, "https://", path("good.pem"));
}

TEST_F(MonitorRelayTls, AFileThatHasNoCertificateIsAnError) {
  ServerOptions options;
  options.port = 0, options.trust = path("none.pem");
  std::string why;
  EXPECT_EQ(Server::open(options, nullptr, nullptr, why), nullptr);
  EXPECT_NE(why.find("none.pem: no certificates"), std::string::npos) << why;
}

}  // namespace
}  // namespace sinew::monitor::relay_test
