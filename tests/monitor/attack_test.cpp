// What a hostile program can do to the monitor from outside: it stays in its bounds, and a good client is served.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "monitor/foxglove/session.hpp"
#include "site_rig.hpp"

namespace sinew::monitor::attack_test {
namespace {

using test::HttpClient;
using test::Reply;
using test::SiteRig;
using namespace std::chrono_literals;

std::size_t resident_kb() {
  std::ifstream status("/proc/self/status");
  std::string line;
  while (std::getline(status, line))
    if (line.starts_with("VmRSS:")) return std::strtoull(line.c_str() + 6, nullptr, 10);
  return 0;
}

class MonitorAttack : public testing::Test {
 protected:
  void SetUp() override {
    rlimit files{};
    getrlimit(RLIMIT_NOFILE, &files);
    files.rlim_cur = std::min<rlim_t>(files.rlim_max, 8192);
    setrlimit(RLIMIT_NOFILE, &files);
    robot_.start();
    rig_.robots->look();
    EXPECT_EQ(good_.get("/api/robots").status, 200);
    EXPECT_EQ(good_.get("/robot/images/eye.image.png").status, 200);
    before_kb_ = resident_kb();
  }
  void TearDown() override {
    expect_good();
    HttpClient fresh(rig_.port());
    EXPECT_EQ(fresh.get("/api/robots").status, 200);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // they keep what was freed
    EXPECT_LT(resident_kb(), before_kb_ + 48 * 1024);
#endif
  }
  /// A client that was there before is answered at once.
  void expect_good() {
    const auto from = std::chrono::steady_clock::now();
    EXPECT_EQ(good_.get("/robot/images/eye.image.png").status, 200);
    EXPECT_LT(std::chrono::steady_clock::now() - from, 10s);
  }
  std::vector<std::unique_ptr<HttpClient>> crowd(std::size_t size, const std::string& says) {
    std::vector<std::unique_ptr<HttpClient>> all;
    for (std::size_t i = 0; i < size; ++i) {
      all.push_back(std::make_unique<HttpClient>(rig_.port()));
      all.back()->send(says);
      if (i % 100 == 0) expect_good();
    }
    return all;
  }

  tap::OwnRunDir dir_;
  tap::Robot robot_;
  SiteRig rig_;
  HttpClient good_{rig_.port()};
  std::size_t before_kb_ = 0;
};

TEST_F(MonitorAttack, AThousandIdleConnections) {
  const auto all = crowd(1000, "");
  expect_good();
  EXPECT_LE(rig_.server->counters().open, 64u + 64u);  // all are of one peer
  EXPECT_GT(rig_.server->counters().made_room, 800u);
}

TEST_F(MonitorAttack, AThousandRequestsThatNeverEnd) {
  const auto all = crowd(1000, "GET /api/robots HTTP/1.1\r\nX-A: b\r\n");
  expect_good();
}

TEST_F(MonitorAttack, HugeHeadsAndBodies) {
  const std::string host = "Host: " + good_.host() + "\r\n";
  for (int i = 0; i < 20; ++i) {
    HttpClient head(rig_.port()), body(rig_.port());
    head.send("GET / HTTP/1.1\r\n" + host);
    for (int k = 0; k < 100; ++k)
      if (!head.send("X-Header-" + std::to_string(k) + ": " + std::string(1000, 'x') + "\r\n")) break;
    EXPECT_TRUE(head.is_ended());
    EXPECT_EQ(body.post("/api/robots/robot/stop", std::string(1 << 20, 'x'), SiteRig::token_line()).status, 413);
  }
}

TEST_F(MonitorAttack, ClientsThatStopReadingPicturesAndMovies) {
  std::vector<std::unique_ptr<HttpClient>> all;
  for (int i = 0; i < 40; ++i) {
    all.push_back(std::make_unique<HttpClient>(rig_.port()));
    all.back()->send("GET /robot/images/eye.image.mjpg HTTP/1.1\r\nHost: " + good_.host() + "\r\n\r\n");
  }
  for (int i = 0; i < 10; ++i) {
    std::this_thread::sleep_for(50ms);
    expect_good();
  }
}

TEST_F(MonitorAttack, WebSocketsThatLieAboutLengthsAndFlood) {
  const std::string upgrade = "GET /robot HTTP/1.1\r\nHost: " + good_.host() +
                              "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                              "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                              "Sec-WebSocket-Protocol: foxglove.websocket.v1\r\n\r\n";
  const auto frame = [](unsigned char head, std::uint64_t announced, const std::string& payload) {
    std::string f(1, static_cast<char>(head));
    f += static_cast<char>(0x80 | 127);
    for (int shift = 56; shift >= 0; shift -= 8) f += static_cast<char>(announced >> shift & 0xff);
    return f + std::string(4, '\0') + payload;  // a mask of zeros
  };
  const std::string messages[] = {
      frame(0x81, ~std::uint64_t{0} >> 1, std::string(100000, '{')),           // longer than any memory
      frame(0x81, foxglove::kMostClientBytes + 1, std::string(8 << 20, 'x')),  // longer than allowed
      frame(0x8b, 10, "0123456789"),                                           // an opcode that is none
      frame(0xf1, 10, "0123456789"),                                           // bits that are reserved
      frame(0x82, 3, "\x01\xff\xff"),                                          // a client's message cut off
      frame(0x81, 12, "{\"op\": 17,}}"),
      frame(0x81, 4, "\xff\xfe\xfd\xfc")};
  for (const std::string& message : messages) {
    HttpClient client(rig_.port());
    client.send(upgrade);
    EXPECT_TRUE(client.wait_for("101"));
    client.send(message);
    std::this_thread::sleep_for(20ms);
    expect_good();
  }
  // Subscribes to everything, again and again, and reads nothing.
  HttpClient stalled(rig_.port());
  stalled.send(upgrade);
  EXPECT_TRUE(stalled.wait_for("101"));
  for (int i = 0; i < 2000; ++i) {
    const std::string text =
        "{\"op\":\"subscribe\",\"subscriptions\":[{\"id\":" + std::to_string(i) + ",\"channelId\":1}]}";
    if (!stalled.send(frame(0x81, text.size(), text))) break;
    if (i % 200 == 0) expect_good();
  }
}

}  // namespace
}  // namespace sinew::monitor::attack_test
