#include "monitor/site.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <map>

#include "monitor/control.hpp"
#include "monitor/token_file.hpp"
#include "site_rig.hpp"

namespace sinew::monitor::site_test {
namespace {

using test::HttpClient;
using test::Json;
using test::Reply;
using test::SiteRig;
using namespace std::chrono_literals;

/// A running robot of three modules, and the monitor of its machine.
class MonitorSite : public testing::Test {
 protected:
  tap::OwnRunDir dir_;
  tap::Robot robot_;
  void SetUp() override { robot_.start(); }
  static Json json(const Reply& reply) { return Json::parse(reply.body, nullptr, false); }
  static std::string code(const Reply& reply) { return json(reply)["error"]["code"]; }
};

TEST_F(MonitorSite, ListsTheRobotsAsTheyComeAndGo) {
  SiteRig rig;
  HttpClient client(rig.port());
  Json robots = json(client.get("/api/robots"))["robots"];
  ASSERT_EQ(robots.size(), 1u);
  EXPECT_EQ(robots[0]["robot"], "robot");
  EXPECT_EQ(robots[0]["pid"], ::getpid());
  EXPECT_EQ(robots[0]["control"]["who"], nullptr);
  robot_.server.reset(), robot_.name.reset();
  rig.robots->look();
  EXPECT_EQ(json(client.get("/api/robots"))["robots"], Json::array());
  EXPECT_EQ(client.get("/api/robots/robot/status").status, 404);
}

TEST_F(MonitorSite, PassesLooksOnAndSaysWhatIsWrong) {
  SiteRig rig;
  HttpClient client(rig.port());
  EXPECT_EQ(json(client.get("/api/robots/robot/status"))["modules"].size(), 4u);
  EXPECT_EQ(json(client.get("/api/robots/robot/params?module=counter"))["params"].size(), 4u);
  EXPECT_GT(json(client.get("/api/robots/robot/timeline?last_ms=50"))["columns"].size(), 2u);
  EXPECT_EQ(client.get("/api/robots/robot/timeline?last_ms=soon").status, 400);
  EXPECT_EQ(client.get("/api/robots/nobody/status").status, 404);
  EXPECT_EQ(client.get("/api/robots/robot/memory").status, 403);
  EXPECT_EQ(client.get("/api/robots/robot/arm").status, 405);  // a look must not change anything
  EXPECT_EQ(client.get("/api/nothing").status, 404);
  EXPECT_EQ(client.get("/nothing").status, 404);
  EXPECT_EQ(json(client.get("/api"))["version"], 1);
}

TEST_F(MonitorSite, AsksTheRobotOnceForAllWhoLook) {
  SiteRig rig;
  HttpClient client(rig.port());
  const std::uint64_t before = json(client.get("/api/robots/robot/status"))["outsiders"]["requests"];
  for (int i = 0; i < 20; ++i) client.get("/api/robots/robot/status");
  const std::uint64_t after = json(client.get("/api/robots/robot/status"))["outsiders"]["requests"];
  EXPECT_LT(after - before, 20u);
}

TEST_F(MonitorSite, OnlyTheTokenCommands) {
  SiteRig rig;
  HttpClient client(rig.port());
  const std::string body = R"({"module": "counter", "param": "gain", "value": 2})";
  EXPECT_EQ(client.post("/api/robots/robot/param.set", body, "").status, 401);
  EXPECT_EQ(client.post("/api/robots/robot/param.set", body, "Authorization: Bearer 0123456789abcdee\r\n").status, 401);
  EXPECT_EQ(
      client.ask("POST", "/api/robots/robot/param.set", "Content-Type: text/plain\r\n" + SiteRig::token_line(), body)
          .status,
      415);
  EXPECT_EQ(client.post("/api/robots/robot/param.set", "[1]", SiteRig::token_line()).status, 400);
  EXPECT_EQ(json(client.get("/api/robots/robot/params?module=counter"))["params"][0]["value"], 1.0);
  const Reply done = client.post("/api/robots/robot/param.set", body, SiteRig::token_line());
  EXPECT_EQ(done.status, 200) << done.body;
  EXPECT_EQ(json(client.get("/api/robots/robot/params?module=counter"))["params"][0]["value"], 2.0);
  const Reply refused = client.post("/api/robots/robot/param.set",
                                    R"({"module": "counter", "param": "gain", "value": 99})", SiteRig::token_line());
  EXPECT_EQ(refused.status, 400);
  EXPECT_EQ(code(refused), "bad_argument");
}

TEST_F(MonitorSite, TenWrongTokensAreEnough) {
  SiteRig rig;
  HttpClient client(rig.port());
  const std::string wrong = "Authorization: Bearer guess\r\n";
  for (unsigned i = 0; i < Gate::kMostWrong; ++i)
    EXPECT_EQ(client.post("/api/robots/robot/stop", "{}", wrong).status, 401);
  EXPECT_EQ(client.post("/api/robots/robot/stop", "{}", wrong).status, 429);
  EXPECT_EQ(client.post("/api/robots/robot/stop", "{}", SiteRig::token_line()).status, 429);  // whoever it is
  EXPECT_EQ(client.get("/api/robots").status, 200);
}

TEST_F(MonitorSite, OtherAddressesThanLoopbackCommandOnlyWithTls) {
  SiteRig rig({.commands = false});
  HttpClient client(rig.port());
  EXPECT_EQ(json(client.get("/api"))["commands"], false);
  EXPECT_EQ(client.post("/api/robots/robot/stop", "{}", SiteRig::token_line()).status, 403);
}

TEST_F(MonitorSite, PagesOfOtherSitesGetNothing) {
  SiteRig rig;
  const auto status = [&](const std::string& lines) {
    HttpClient client(rig.port());
    client.send("GET /api/robots HTTP/1.1\r\n" + lines + "\r\n");
    return client.reply().status;
  };
  const std::string port = std::to_string(rig.port());
  EXPECT_EQ(status("Host: 127.0.0.1:" + port + "\r\n"), 200);
  EXPECT_EQ(status("Host: LocalHost:" + port + "\r\nOrigin: http://localhost:" + port + "\r\n"), 200);
  EXPECT_EQ(status("Host: robot.example:" + port + "\r\n"), 403);  // a name of the attacker's that leads here
  EXPECT_EQ(status("Host: 127.0.0.1:1\r\n"), 403);
  EXPECT_EQ(status("Host: 127.0.0.1:" + port + "\r\nOrigin: http://evil.example\r\n"), 403);
  EXPECT_EQ(status("Host: 127.0.0.1:" + port + "\r\nOrigin: null\r\n"), 403);
  HttpClient client(rig.port());
  const Reply ok = client.get("/api/robots");
  EXPECT_NE(ok.headers.at("content-security-policy").find("default-src 'none'"), std::string::npos);
  EXPECT_EQ(ok.headers.at("x-content-type-options"), "nosniff");
}

TEST_F(MonitorSite, ACommandThatIsTooLateIsVoid) {
  SiteRig rig;
  HttpClient client(rig.port());
  const std::int64_t now = json(client.get("/api"))["now_ns"];
  const std::string body = R"({"module": "counter", "param": "gain", "value": 3})";
  const auto until = [](std::int64_t ns) {
    return SiteRig::token_line() + "X-Sinew-Until-Ns: " + std::to_string(ns) + "\r\n";
  };
  EXPECT_EQ(client.post("/api/robots/robot/param.set", body, until(now - 1)).status, 408);
  EXPECT_EQ(json(client.get("/api/robots/robot/params?module=counter"))["params"][0]["value"], 1.0);
  EXPECT_EQ(client.post("/api/robots/robot/param.set", body, until(now + 60'000'000'000)).status, 200);
  EXPECT_EQ(
      client.post("/api/robots/robot/param.set", body, SiteRig::token_line() + "X-Sinew-Until-Ns: soon\r\n").status,
      400);
}

TEST_F(MonitorSite, OneCommandsAtATimeAndTheOthersSeeWho) {
  SiteRig rig;
  HttpClient client(rig.port());
  const auto control = [&](const std::string& body) {
    return client.post("/api/robots/robot/control", body, SiteRig::token_line());
  };
  const auto set = [&](const std::string& key) {
    return client.post("/api/robots/robot/param.set", R"({"module": "counter", "param": "gain", "value": 2})",
                       SiteRig::token_line() + (key.empty() ? "" : "X-Sinew-Control: " + key + "\r\n"));
  };
  EXPECT_EQ(set("").status, 200);  // nobody has control
  EXPECT_EQ(client.post("/api/robots/robot/control", R"({"action": "take", "who": "Ada"})", "").status, 401);
  const Reply taken = control(R"({"action": "take", "who": "Ada"})");
  const std::string key = json(taken)["key"];
  EXPECT_EQ(key.size(), 64u);
  EXPECT_EQ(json(client.get("/api/robots"))["robots"][0]["control"]["who"], "Ada");
  EXPECT_EQ(set("").status, 409);
  EXPECT_EQ(set(std::string(64, '0')).status, 409);
  EXPECT_EQ(set(key).status, 200);
  EXPECT_EQ(control(R"({"action": "take", "who": "Bob"})").status, 409);
  EXPECT_EQ(control(R"({"action": "ask", "who": "Bob"})").status, 200);
  EXPECT_EQ(json(client.get("/api/robots"))["robots"][0]["control"]["asked"], Json({"Bob"}));
  EXPECT_EQ(client.post("/api/robots/robot/disarm", "{}", SiteRig::token_line()).status, 501);  // reaches the robot
  EXPECT_EQ(control(R"({"action": "keep", "key": ")" + key + "\"}").status, 200);
  EXPECT_EQ(control(R"({"action": "release", "key": "wrong"})").status, 409);
  EXPECT_EQ(control(R"({"action": "release", "key": ")" + key + "\"}").status, 200);
  EXPECT_EQ(control(R"({"action": "take", "who": "Bob"})").status, 200);
  EXPECT_EQ(set(key).status, 409);  // the key of before
  EXPECT_EQ(control(R"({"action": "grab"})").status, 400);
}

TEST(MonitorControl, ACommanderThatSaysNothingLosesControl) {
  Control control;
  const Control::Time start{};
  ASSERT_EQ(control.take("Ada", "", "k1", start), "k1");
  EXPECT_EQ(control.take("Bob", "", "k2", start + 4s), "");
  EXPECT_TRUE(control.keep("k1", start + 4s));
  EXPECT_FALSE(control.allows("", start + 8s));
  EXPECT_TRUE(control.allows("", start + 9s));
  EXPECT_FALSE(control.keep("k1", start + 9s));
  EXPECT_EQ(control.who(start + 9s), "");
  EXPECT_EQ(control.take("Bob", "k1", "k3", start + 9s), "k3");
  EXPECT_FALSE(control.allows("k1", start + 9s));
}

TEST(MonitorToken, IsInTheRunFolderForItsUserAloneAndGoesWithTheMonitor) {
  tap::OwnRunDir dir;
  std::string why, path;
  {
    const auto token = TokenFile::make(why);
    ASSERT_TRUE(token) << why;
    path = token->path();
    EXPECT_EQ(token->token().size(), 64u);
    EXPECT_EQ(std::filesystem::status(path).permissions(),
              std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
    EXPECT_NE(TokenFile::make(why)->token(), token->token());
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace sinew::monitor::site_test
