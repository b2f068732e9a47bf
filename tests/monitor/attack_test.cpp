// What a hostile program can do to the monitor from outside: it stays in its bounds, and a good client is served.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "site_rig.hpp"
#include "web_socket.hpp"

namespace sinew::monitor::attack_test {
namespace {

using test::HttpClient;
using test::Reply;
using test::SiteRig;
using test::WebSocket;
using namespace std::chrono_literals;

std::size_t resident_kb() {
  std::ifstream status("/proc/self/status");
  std::string line;
  while (std::getline(status, line))
    if (line.starts_with("VmRSS:")) return std::strtoul(line.c_str() + 6, nullptr, 10);
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
#ifndef SINEW_SANITIZED  // they keep what was freed
    EXPECT_LT(resident_kb(), before_kb_ + 48 * 1024);
#endif
  }
  /// A client that was there before is still served.
  void expect_good() { EXPECT_EQ(good_.get("/robot/images/eye.image.png").status, 200); }
  std::vector<std::unique_ptr<HttpClient>> crowd(std::size_t size, const std::string& says) {
    std::vector<std::unique_ptr<HttpClient>> all;
    for (std::size_t i = 0; i < size; ++i) {
      all.push_back(std::make_unique<HttpClient>(rig_.port(), 0x7f000002));
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
    HttpClient head(rig_.port(), 0x7f000002), body(rig_.port(), 0x7f000002);
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
    all.push_back(std::make_unique<HttpClient>(rig_.port(), 0x7f000002));
    all.back()->send("GET /robot/images/eye.image.mjpg HTTP/1.1\r\nHost: " + good_.host() + "\r\n\r\n");
  }
  for (int i = 0; i < 10; ++i) {
    std::this_thread::sleep_for(50ms);
    expect_good();
  }
}

/// A WebSocket frame as a client sends it, or ought not to. `length`: what its head says; nothing: the payload's.
std::string frame(std::uint8_t first, const std::string& payload, bool masked = true,
                  std::optional<std::uint64_t> length = {}) {
  const std::uint64_t n = length.value_or(payload.size());
  std::string f(1, static_cast<char>(first));
  const std::uint8_t mask_bit = masked ? 0x80 : 0;
  const int wide = n < 126 ? 0 : n < 65536 ? 2 : 8;
  f += static_cast<char>(mask_bit | (wide == 0 ? n : wide == 2 ? 126 : 127));
  for (int i = wide - 1; i >= 0; --i) f += static_cast<char>(n >> (8 * i));
  if (!masked) return f + payload;
  const char mask[4] = {1, 2, 3, 4};
  f.append(mask, 4);
  for (std::size_t i = 0; i < payload.size(); ++i) f += static_cast<char>(payload[i] ^ mask[i % 4]);
  return f;
}

std::unique_ptr<WebSocket> web_socket(const SiteRig& rig) {
  auto socket = std::make_unique<WebSocket>(rig.port(), "/robot", "foxglove.websocket.v1", "", 0x7f000002);
  EXPECT_TRUE(socket->is_open());
  return socket;
}

// RFC 6455, 5.2 to 5.5: what a server must fail the connection for. (Frames without a mask, 5.1, the library takes.)
TEST_F(MonitorAttack, FramesThatAreNone) {
  const std::string text = R"({"op": "subscribe", "subscriptions": []})";
  const std::vector<std::pair<const char*, std::string>> frames = {
      {"a reserved bit", frame(0x81 | 0x40, text)},
      {"reserved opcode of data", frame(0x80 | 3, text)},
      {"reserved opcode of control", frame(0x80 | 0xb, "")},
      {"ping of more than 125 bytes", frame(0x80 | 9, std::string(126, 'p'))},
      {"ping in pieces", frame(9, "p")},
      {"a piece that continues nothing", frame(0x80, text)},
      {"a message within another", frame(1, text) + frame(0x81, text)},
      {"a length of 64 bits with the first one set", frame(0x82, "x", true, std::uint64_t{1} << 63)},
      {"close with half a code", frame(0x80 | 8, "x")},
      {"a message over the bound", frame(0x82, std::string(300 << 10, 'x'))},
      {"pieces that never end",
       [&] {
         std::string all = frame(2, std::string(60000, 'x'));
         for (int i = 0; i < 200; ++i) all += frame(0, std::string(60000, 'x'));
         return all;
       }()},
  };
  for (const auto& [what, bytes] : frames) {
    const auto bad = web_socket(rig_);
    bad->send_raw(bytes);
    EXPECT_TRUE(bad->is_refused()) << what;
    expect_good();
  }
}

TEST_F(MonitorAttack, AFrameThatStopsHalfWayHoldsNobodyUp) {
  std::vector<std::unique_ptr<WebSocket>> all;
  for (int i = 0; i < 40; ++i) {
    all.push_back(web_socket(rig_));
    all.back()->send_raw(frame(0x82, "begins", true, 200 << 10));
  }
  expect_good();
}

TEST_F(MonitorAttack, BytesWithoutAnyOrder) {
  std::uint32_t state = 1;
  const auto noise = [&](std::size_t size) {
    std::string bytes(size, 0);
    for (char& c : bytes) c = static_cast<char>((state = state * 1664525 + 1013904223) >> 24);
    return bytes;
  };
  for (int i = 0; i < 200; ++i) {
    HttpClient raw(rig_.port(), 0x7f000002);
    raw.send(noise(300) + "\r\n\r\n");
    const auto socket = web_socket(rig_);
    socket->send_raw(noise(300));
    if (i % 20 == 0) expect_good();
  }
}

TEST_F(MonitorAttack, RequestsThatAreNone) {
  const std::string host = "Host: " + good_.host() + "\r\n";
  const std::vector<std::string> requests = {
      "GET\r\n\r\n" + host,
      "\r\n\r\n\r\n\r\n",
      "GET  HTTP/1.1\r\n" + host + "\r\n",
      "G\x01T / HTTP/1.1\r\n" + host + "\r\n",
      "GET /%zz%00%2e%2e%2f HTTP/1.1\r\n" + host + "\r\n",
      "POST /api/robots/robot/stop HTTP/1.1\r\n" + host + "Content-Length: -1\r\n\r\n",
      "POST /api/robots/robot/stop HTTP/1.1\r\n" + host + "Content-Length: 99999999999999999999\r\n\r\n",
      "POST /api/robots/robot/stop HTTP/1.1\r\n" + host + "Transfer-Encoding: chunked\r\n\r\nffffffffffffffff\r\n",
      "GET /robot HTTP/1.1\r\n" + host + "Upgrade: websocket\r\nConnection: Upgrade\r\n\r\n",
      "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
  };
  for (const std::string& text : requests) {
    HttpClient bad(rig_.port(), 0x7f000002);
    bad.send(text);
    const Reply r = bad.reply(false, 2s);
    EXPECT_TRUE(r.status == 0 || r.status >= 400) << text << r.status;
    expect_good();
  }
}

}  // namespace
}  // namespace sinew::monitor::attack_test
