// Recorded runs and the doctor over HTTP, with a program in place of `sinew` that says what it was asked.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <thread>

#include "site_rig.hpp"

namespace sinew::monitor::runs_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using test::HttpClient;
using test::Json;
using test::Reply;
using test::SiteRig;

bool until(const std::function<bool()>& is) {
  for (const auto end = std::chrono::steady_clock::now() + 20s; std::chrono::steady_clock::now() < end;) {
    if (is()) return true;
    std::this_thread::sleep_for(10ms);
  }
  return false;
}

/// A folder with two runs, one of them no recording.
class MonitorRuns : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"good", "bad"}) {
      fs::create_directories(folder_ / name);
      std::ofstream(folder_ / name / "run.mcap") << name << std::string(600'000, 'x');
    }
    fs::create_directory_symlink("good", folder_ / "latest");
    std::ofstream(sinew_) << R"(#!/bin/sh
here=$(dirname "$0")
echo "$@" >>"$here/asked"
case "$*" in
  "bag info --json "*/good/*) echo '{"duration_s": 2.5, "run": {"robot": "quad", "unix_ns": "17"}, "result": {"outcome": "landed"}}' ;;
  "replay --compare --json "*/good/*)
    while [ ! -e "$here/go" ]; do sleep 0.01; done
    echo '{"identical": false, "steps": 12, "first_difference": {"module": "filter"}}'; exit 1 ;;
  "bag compare --json "*/good/*) echo '{"a": {"result": "landed"}, "fields": []}' ;;
  "doctor --json") echo '{"problems": 1, "warnings": 0, "checks": [{"id": "clock", "state": "problem", "seen": "hpet", "advice": "tsc"}]}'; exit 1 ;;
  *) echo "warned" >&2; echo "sinew: no recording" >&2; exit 2 ;;
esac
)";
    fs::permissions(sinew_, fs::perms::owner_all);
  }
  std::string asked() const {
    std::ifstream in(fs::path(dir_.path()) / "asked");
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void let_go() const { std::ofstream(fs::path(dir_.path()) / "go") << "go"; }
  static Json json(const Reply& reply) { return Json::parse(reply.body, nullptr, false); }

  tap::OwnRunDir dir_;
  fs::path folder_ = fs::path(dir_.path()) / "runs";
  fs::path sinew_ = fs::path(dir_.path()) / "sinew";
};

TEST_F(MonitorRuns, AreListedWithWhatIsInThemAndCanBeTaken) {
  SiteRig rig({.runs = {folder_.string()}, .sinew = sinew_.string()});
  HttpClient client(rig.port());
  EXPECT_EQ(json(client.get("/api"))["runs"], true);
  std::map<std::string, Json> runs;
  const Json listed = json(client.get("/api/runs"));
  for (const Json& run : listed["runs"]) runs[run["name"]] = run;
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(listed["busy"], nullptr);
  EXPECT_EQ(runs["good"], Json({{"name", "good"},
                                {"path", (folder_ / "good/run.mcap").string()},
                                {"bytes", 600004},
                                {"begin_unix_ns", 17},
                                {"duration_s", 2.5},
                                {"robot", "quad"},
                                {"verdict", "landed"},
                                {"replay", "none"},
                                {"open", false}}));
  EXPECT_EQ(runs["bad"]["verdict"], "cannot be read");
  const Reply file = client.get("/api/runs/good/run.mcap");
  EXPECT_EQ(file.headers.at("content-length"), "600004");
  EXPECT_EQ(file.body, "good" + std::string(600'000, 'x'));
  HttpClient other(rig.port());
  EXPECT_EQ(other.get("/api/runs/none/run.mcap").status, 404);
  EXPECT_EQ(other.get("/api/runs/good/info").status, 404);
  EXPECT_EQ(other.get("/api/runs/%2e%2e/run.mcap").status / 100, 4);
}

TEST_F(MonitorRuns, AreReplayedOneAtATimeWhileTheMonitorAnswersOthers) {
  SiteRig rig({.runs = {folder_.string()}, .sinew = sinew_.string()});
  HttpClient client(rig.port());
  const auto replay = [&](const std::string& name) {
    return client.post("/api/runs/" + name + "/replay", "{}", SiteRig::token_line());
  };
  EXPECT_EQ(json(client.get("/api/runs/good/replay"))["state"], "none");
  EXPECT_EQ(client.post("/api/runs/good/replay", "{}", "").status, 401);
  EXPECT_EQ(json(replay("good"))["state"], "running");
  const Reply second = replay("bad");
  EXPECT_EQ(second.status, 409);
  EXPECT_NE(second.body.find("replay of good"), std::string::npos);
  EXPECT_EQ(json(client.get("/api/runs/good/replay"))["state"], "running");
  EXPECT_EQ(json(client.get("/api/runs"))["busy"], "replay of good");
  let_go();
  ASSERT_TRUE(until([&] { return json(client.get("/api/runs/good/replay"))["state"] != "running"; }));
  const Json done = json(client.get("/api/runs/good/replay"));
  EXPECT_EQ(done["state"], "differs");
  EXPECT_EQ(done["result"]["first_difference"]["module"], "filter");
  EXPECT_EQ(json(replay("bad"))["state"], "running");
  ASSERT_TRUE(until([&] { return json(client.get("/api/runs/bad/replay"))["state"] == "failed"; }));
  EXPECT_EQ(json(client.get("/api/runs/bad/replay"))["why"], "sinew: no recording");
}

TEST_F(MonitorRuns, AReplayCanBeEnded) {
  SiteRig rig({.runs = {folder_.string()}, .sinew = sinew_.string()});
  HttpClient client(rig.port());
  EXPECT_EQ(client.post("/api/runs/good/stop", "{}", SiteRig::token_line()).status, 404);  // nothing runs
  EXPECT_EQ(client.post("/api/runs/good/replay", "{}", SiteRig::token_line()).status, 200);
  EXPECT_EQ(client.post("/api/runs/good/stop", "{}", SiteRig::token_line()).status, 200);
  ASSERT_TRUE(until([&] { return json(client.get("/api/runs/good/replay"))["state"] == "failed"; }));
  EXPECT_EQ(json(client.get("/api/runs/good/replay"))["why"], "it was ended");
}

TEST_F(MonitorRuns, TheMonitorEndsAReplayThatRuns) {
  SiteRig rig({.runs = {folder_.string()}, .sinew = sinew_.string()});
  HttpClient client(rig.port());
  EXPECT_EQ(client.post("/api/runs/good/replay", "{}", SiteRig::token_line()).status, 200);
  ASSERT_TRUE(until([&] { return asked().find("replay") != std::string::npos; }));
  // The rig ends here, and the test with it: the program waits for a file that never comes.
}

TEST_F(MonitorRuns, TwoAreCompared) {
  SiteRig rig({.runs = {folder_.string()}, .sinew = sinew_.string()});
  HttpClient client(rig.port());
  const auto compare = [&](const std::string& with) {
    return client.post("/api/runs/good/compare", Json({{"with", with}}).dump(), SiteRig::token_line()).status;
  };
  EXPECT_EQ(compare("none"), 404);
  EXPECT_EQ(compare("../good"), 404);
  EXPECT_EQ(compare(""), 404);
  EXPECT_EQ(compare("bad"), 200);
  const auto state = [&] { return json(client.get("/api/runs/good/compare?with=bad")); };
  ASSERT_TRUE(until([&] { return state()["state"] == "done"; }));
  EXPECT_EQ(state()["result"]["a"]["result"], "landed");
  const std::string line =
      "bag compare --json " + (folder_ / "good/run.mcap").string() + " " + (folder_ / "bad/run.mcap").string() + "\n";
  EXPECT_NE(asked().find(line), std::string::npos) << asked();
}

TEST_F(MonitorRuns, OneThatCannotStandUpSaysWhy) {
  SiteRig rig({.runs = {folder_.string()}, .sinew = sinew_.string()});
  HttpClient client(rig.port());
  const auto post = [&](const std::string& path, const std::string& more = SiteRig::token_line()) {
    return client.post("/api/runs/" + path, "{}", more);
  };
  EXPECT_EQ(post("good/open", "").status, 401);
  EXPECT_EQ(post("none/open").status, 404);
  EXPECT_EQ(post("..%2f..%2fetc/open").status / 100, 4);
  EXPECT_EQ(post(".hidden/open").status, 404);
  EXPECT_EQ(post("good/close").status, 404);
  const Reply open = post("good/open");
  EXPECT_EQ(open.status, 502);
  EXPECT_EQ(json(open)["error"]["why"], "it cannot be played: sinew: no recording");
  EXPECT_NE(asked().find("bag play --stay --paused " + (folder_ / "good/run.mcap").string()), std::string::npos);
  EXPECT_EQ(post("good/open").status, 502);  // it may be tried again
}

TEST_F(MonitorRuns, OfTheBeginningAreToldWhenTheyEnd) {
  std::mutex mutex;
  std::string told;
  Runs::Options options{folder_.string(), {(folder_ / "bad/run.mcap").string()}};
  options.on_failure = [&](const std::string& path, const std::string& why) {
    const std::lock_guard lock(mutex);
    told = path + ": " + why;
  };
  SiteRig rig({.runs = options, .sinew = sinew_.string()});
  EXPECT_TRUE(until([&] {
    const std::lock_guard lock(mutex);
    return told == (folder_ / "bad/run.mcap").string() + ": sinew: no recording";
  }));
}

TEST_F(MonitorRuns, TheDoctorIsAskedOnceForAllWhoLook) {
  SiteRig rig({.sinew = sinew_.string()});
  HttpClient client(rig.port());
  for (int i = 0; i < 3; ++i) {
    const Json said = json(client.get("/api/doctor"));
    EXPECT_EQ(said["ok"], true);
    EXPECT_EQ(said["problems"], 1);
    EXPECT_EQ(said["checks"][0]["advice"], "tsc");
  }
  EXPECT_EQ(asked(), "doctor --json\n");
  EXPECT_EQ(client.get("/api/runs").status, 404);  // this one shows none
}

TEST_F(MonitorRuns, ADoctorThatCannotBeAskedSaysWhy) {
  SiteRig rig({.sinew = (fs::path(dir_.path()) / "none").string()});
  HttpClient client(rig.port());
  const Reply said = client.get("/api/doctor");
  EXPECT_EQ(said.status, 502);
  EXPECT_EQ(json(said)["error"]["code"], "io");
}

}  // namespace
}  // namespace sinew::monitor::runs_test
