// What a hostile program can do to the monitor from outside: it stays in its bounds, and a good client is served.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

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

}  // namespace
}  // namespace sinew::monitor::attack_test
