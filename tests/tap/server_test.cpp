// The robot's socket: its answers, its refusals, and its reaction to clients that misbehave.
#include <sys/stat.h>

#include <thread>

#include "raw_client.hpp"
#include "tap_rig.hpp"

namespace sinew::tap::server_test {
namespace {

OwnRunDir g_run_dir;

/// A value of the reply's list with this member of this value.
Json find_in(const Json& list, const char* member, const std::string& value) {
  for (const Json& j : list)
    if (j[member] == value) return j;
  return {};
}

TEST(Server, SaysWhoItIs) {
  Robot robot({.name = "quad", .server = {.board = "sim"}});
  robot.start();
  auto client = robot.client();
  const Json hello = ask(*client, "hello", {{"id", 7}});
  EXPECT_EQ(hello["ok"], true);
  EXPECT_EQ(hello["id"], 7);
  EXPECT_EQ(hello["version"], kProtocolVersion);
  EXPECT_EQ(hello["robot"], "quad");
  EXPECT_EQ(hello["board"], "sim");
  EXPECT_EQ(hello["pid"], ::getpid());
  EXPECT_EQ(client->pid(), ::getpid());
}

TEST(Server, ListsTopicsWithTheirTypes) {
  Robot robot;
  robot.start();
  const Json reply = ask(*robot.client(), "topics");
  const Json image = find_in(reply["topics"], "name", "eye.image");
  EXPECT_EQ(image["type"], "Image");
  EXPECT_EQ(image["writer"], "eye");
  EXPECT_EQ(image["thread"], "slow");
  EXPECT_EQ(image["bulk_bytes"], Eye::kWidth * Eye::kHeight);
  EXPECT_EQ(image["keep"], 5);
  EXPECT_EQ(find_in(reply["topics"], "name", "counter.range")["readers"], Json::array({"follower", "eye"}));
  EXPECT_EQ(find_in(reply["topics"], "name", "counter.range")["keep"], 251) << "500 ms of 2 ms, and the first";
  const Json field = find_in(reply["types"]["RangeSample"]["fields"], "name", "range_m");
  EXPECT_EQ(field["type"], "f64");
  EXPECT_EQ(field["unit"], "m");
  EXPECT_EQ(field["offset"], 8);
  EXPECT_EQ(reply["types"]["Image"]["bulk"], "data");
}

TEST(Server, StatusCountsGoOn) {
  Robot robot;
  robot.start();
  auto client = robot.client();
  const auto steps = [&] {
    return find_in(ask(*client, "status")["modules"], "name", "counter")["steps"].get<std::uint64_t>();
  };
  const auto before = steps();
  while (steps() == before) {
  }
  const Json status = ask(*client, "status");
  EXPECT_EQ(find_in(status["threads"], "name", "fast")["modules"], Json({"counter", "follower"}));
  EXPECT_GT(find_in(status["topics"], "name", "counter.range")["messages"], 0);
  EXPECT_EQ(status["outsiders"]["clients"], 1);
}

TEST(Server, StatusHasWhatDevicesComplainAbout) {
  RobotOptions options;
  std::atomic<int> asked{0};
  options.server.complaints = [&] {
    ++asked;
    return std::vector<std::string>{"imu: i2c 0x68: nothing answers"};
  };
  Robot robot(options);
  robot.start();
  auto client = robot.client();
  EXPECT_EQ(ask(*client, "status")["devices"]["complaints"], Json({"imu: i2c 0x68: nothing answers"}));
  EXPECT_EQ(asked, 1) << "only when somebody wants to know";
  Robot without({.name = "without"});
  without.start();
  EXPECT_FALSE(ask(*without.client(), "status").contains("devices"));
}

TEST(Server, StatusIsInTheRobotsTime) {
  hal::ManualClock clock;
  RobotOptions options;
  options.server.clock = &clock;
  Robot robot(options);
  robot.start();
  auto client = robot.client();
  clock.set({1'234});
  EXPECT_EQ(ask(*client, "status")["now_ns"], 1'234);
}

TEST(Server, ParameterIsSetBetweenTwoStepsAndAnsweredWithTheStep) {
  Robot robot;
  robot.start();
  auto client = robot.client();
  const auto value = [&] {
    return find_in(ask(*client, "params", {{"module", "counter"}})["params"], "param", "gain")["value"];
  };
  EXPECT_EQ(value(), 1.0);
  const Json set = ask(*client, "param.set", {{"module", "counter"}, {"param", "gain"}, {"value", 3}});
  EXPECT_EQ(set["ok"], true) << set;
  ASSERT_TRUE(set["step"].is_number_unsigned()) << set;
  EXPECT_EQ(value(), 3.0);
  const Json after = find_in(ask(*client, "params", {{"module", "counter"}})["params"], "param", "gain");
  EXPECT_EQ(after["start"], 1.0) << "what the run began with stays";
  auto reader = client->reader();
  ASSERT_TRUE(reader);
  const auto topic = *(*reader)->find("counter.range");
  // Steps count from 0 and the counter from 1.
  for (;;) {
    std::vector<std::byte> copy((*reader)->bytes(topic));
    const auto message = (*reader)->newest(topic);
    if (!message || !(*reader)->copy(*message, copy)) continue;
    const std::uint32_t step = message->sequence - 0xFFFFFF00;
    msg::RangeSample r;
    std::memcpy(&r, copy.data() + sizeof(rt::SlotHeader), sizeof r);
    EXPECT_EQ(r.range_m, step >= set["step"] ? 3 * (step + 1.0) : step + 1.0);
    break;
  }
}

TEST(Server, RefusesWhatIsNotAllowedAndSaysWhatIs) {
  Robot robot;
  robot.start();
  auto client = robot.client();
  const auto why = [&](const char* request, const Json& arguments) {
    const Json reply = ask(*client, request, arguments);
    EXPECT_EQ(reply["ok"], false) << reply;
    return reply["error"]["code"].get<std::string>() + ": " + reply["error"]["why"].get<std::string>();
  };
  const char* bad = code_name(hal::Errc::bad_argument);
  const char* no = code_name(hal::Errc::not_found);
  const char* never = code_name(hal::Errc::not_supported);
  EXPECT_EQ(why("param.set", {{"module", "counter"}, {"param", "gain"}, {"value", 11}}),
            std::string(bad) + ": counter.gain: 11: a number from 0 to 10");
  EXPECT_EQ(why("param.set", {{"module", "counter"}, {"param", "gain"}, {"value", {1}}}),
            std::string(bad) + ": \"value\": true, false, a number or a text");
  EXPECT_EQ(why("param.set", {{"module", "counter"}, {"param", "gains"}, {"value", 1}}),
            std::string(no) + ": counter has no parameter gains; it has: gain offset active label; did you mean gain?");
  EXPECT_EQ(why("param.set", {{"module", "counter"}, {"param", "label"}, {"value", "b"}}),
            std::string(never) + ": a text is set before the start only");
  EXPECT_EQ(why("param.set", {{"param", "gain"}, {"value", 1}}), std::string(bad) + ": \"module\": a module's name");
  EXPECT_EQ(why("param.set", {{"module", "follower"}, {"param", "height_m"}, {"value", 8001}}),
            std::string(bad) + ": follower.height_m: 8001: a number from -100 to 8000 m: what the barometer measures")
      << "declared without limits, narrowed by configure()";
  const Json height = ask(*client, "params", {{"module", "follower"}})["params"][0];
  EXPECT_EQ(height["min"], -100.0);
  EXPECT_EQ(height["max"], 8000.0);
  EXPECT_EQ(height["allowed"], "a number from -100 to 8000 m: what the barometer measures");
  EXPECT_EQ(why("module.disable", {{"module", "mixer"}}),
            std::string(no) + ": no module mixer; there are: counter follower eye operator");
  EXPECT_EQ(why("params", {{"module", "mixer"}}),
            std::string(no) + ": no module mixer; there are: counter follower eye operator");
  EXPECT_EQ(why("subscribe", {{"topics", {"mixer.out"}}}), std::string(no) + ": no topic mixer.out");
  EXPECT_EQ(why("subscribe", {{"topics", {"eye.image"}}, {"period_ms", 0}}),
            std::string(bad) + ": \"period_ms\": an integer from 1 to 1000");
  EXPECT_EQ(why("subscribe", {{"topics", {"eye.imgae"}}}),
            std::string(no) + ": no topic eye.imgae; did you mean eye.image?");
  EXPECT_EQ(why("fly", {}), std::string(no) + ": no request \"fly\" in this version");
  EXPECT_EQ(why("statsu", {}), std::string(no) + ": no request \"statsu\" in this version; did you mean status?");
  EXPECT_EQ(why("stop", {}), std::string(never) + ": this run cannot be stopped from outside");
}

TEST(Server, ModuleIsDisabledAndStartsAfreshWhenEnabled) {
  Robot robot;
  robot.start();
  auto client = robot.client();
  ASSERT_TRUE(ask(*client, "module.disable", {{"module", "counter"}})["step"].is_number());
  const auto steps = [&] { return find_in(ask(*client, "status")["modules"], "name", "counter"); };
  const Json before = steps();
  EXPECT_EQ(before["running"], false);
  std::this_thread::sleep_for(20ms);
  EXPECT_EQ(steps()["steps"], before["steps"]);
  ASSERT_TRUE(ask(*client, "module.enable", {{"module", "counter"}})["step"].is_number());
  EXPECT_EQ(steps()["running"], true);
}

TEST(Server, ChangeOfAThreadThatDoesNotRunIsAcceptedAndSaidToWait) {
  Robot robot({.server = {.limits = {.patience = 50ms}}});
  robot.prepare(1s);  // and never run
  auto client = robot.client();
  const Json set = ask(*client, "param.set", {{"module", "counter"}, {"param", "gain"}, {"value", 2}});
  EXPECT_EQ(set["ok"], true);
  EXPECT_EQ(set["step"], nullptr);
  const auto value = [&] { return ask(*client, "params", {{"module", "counter"}})["params"][0]["value"]; };
  EXPECT_EQ(value(), 1.0) << "not before it took effect";
  ASSERT_TRUE(robot.discrete->run());
  EXPECT_EQ(value(), 2.0);
}

TEST(Server, MessageFromOutsideIsPublishedWithTheStep) {
  Robot robot;
  robot.start();
  auto client = robot.client();
  const auto publish = [&](const Json& message) {
    return ask(*client, "publish", {{"topic", "operator.range"}, {"message", message}});
  };
  const Json reply = publish({{"range_m", 1.5}});
  EXPECT_EQ(reply["ok"], true) << reply;
  ASSERT_TRUE(reply["step"].is_number()) << reply;
  auto reader = client->reader();
  ASSERT_TRUE(reader);
  const auto topic = *(*reader)->find("operator.range");
  std::vector<std::byte> copy((*reader)->bytes(topic));
  for (;;) {
    const auto message = (*reader)->newest(topic);
    if (!message || !(*reader)->copy(*message, copy)) continue;
    msg::RangeSample r;
    std::memcpy(&r, copy.data() + sizeof(rt::SlotHeader), sizeof r);
    EXPECT_EQ(r.range_m, 1.5);
    break;
  }
  EXPECT_EQ(publish({{"range_m", "far"}})["error"]["why"],
            "\"message\": range_m: \"far\": a number, \"NaN\", \"Infinity\" or \"-Infinity\"");
  EXPECT_EQ(publish({{"range_m", "NaN"}})["error"]["why"], "not finite: finite numbers in every field");
  EXPECT_EQ(ask(*client, "publish", {{"topic", "counter.range"}, {"message", Json::object()}})["error"]["why"],
            "counter.range is written by module counter; only topics with writer = \"external\" take messages");
}

TEST(Server, PeriodOfAThreadIsChanged) {
  Robot robot;
  robot.start();
  auto client = robot.client();
  const Json reply = ask(*client, "thread.period", {{"thread", "slow"}, {"period_us", 2500.5}});
  EXPECT_EQ(reply["ok"], true) << reply;
  EXPECT_TRUE(reply["step"].is_number()) << reply;
  EXPECT_EQ(find_in(ask(*client, "status")["threads"], "name", "slow")["period_ns"], 2'500'500);
  EXPECT_EQ(ask(*client, "thread.period", {{"thread", "slow"}, {"period_us", 1}})["error"]["why"],
            "1 us: a number from 10 to 3600000000");
  EXPECT_EQ(ask(*client, "arm")["error"]["why"], "this robot has no actuators and so no guardian");
}

TEST(Server, TimeLineShowsTheLastCycles) {
  Robot robot;
  robot.start();
  auto client = robot.client();
  Json line;
  do line = ask(*client, "timeline", {{"last_ms", 500}});
  while (line["ok"] == true && line["events"].size() < 20);
  ASSERT_EQ(line["ok"], true) << line;
  EXPECT_EQ(line["columns"], Json({"kind", "thread", "module", "at_ns", "length_ns", "zone"}));
  for (const Json& e : line["events"]) ASSERT_EQ(e.size(), line["columns"].size());
  bool counter_stepped = false;
  for (const Json& e : line["events"])
    counter_stepped |= e[0] == "step" && line["modules"][e[2].get<std::size_t>()] == "counter" &&
                       line["threads"][e[1].get<std::size_t>()] == "fast";
  EXPECT_TRUE(counter_stepped);
  EXPECT_EQ(ask(*client, "timeline", {{"last_ms", 0}})["error"]["why"], "\"last_ms\": an integer from 1 to 60000");
  EXPECT_EQ(ask(*client, "zones", {{"on", true}})["ok"], true);
  EXPECT_EQ(ask(*client, "zones")["error"]["why"], "\"on\": true or false");
}

/// Answers the second time that it is asked, or never.
class FakeRecorder final : public RecordControl {
 public:
  std::uint64_t ask(Command command) override {
    asked.store(static_cast<int>(command));
    looked_ = 0;
    return 7;
  }
  std::optional<Answer> answer(std::uint64_t number) override {
    EXPECT_EQ(number, 7u);
    if (silent || ++looked_ < 2) return std::nullopt;
    if (asked.load() == static_cast<int>(Command::stop)) return Answer{hal::Errc::not_found, "nothing is recorded"};
    return Answer{{}, R"({"path":"here"})"};
  }
  std::atomic<int> asked{-1};
  std::atomic<bool> silent{false};

 private:
  int looked_ = 0;
};

TEST(Server, TheDeskOfTheRecorderAnswersInItsOwnTime) {
  FakeRecorder recorder;
  RobotOptions options;
  options.server.record_control = &recorder;
  options.server.limits.patience = 300ms;
  Robot robot(options);
  robot.start();
  auto client = robot.client();
  const Json started = ask(*client, "record.start", {{"id", 3}});
  EXPECT_EQ(started, (Json{{"ok", true}, {"id", 3}, {"path", "here"}}));
  EXPECT_EQ(recorder.asked.load(), static_cast<int>(RecordControl::Command::start));
  const Json stopped = ask(*client, "record.stop");
  EXPECT_EQ(stopped["ok"], false);
  EXPECT_EQ(stopped["error"]["code"], "not_found");
  EXPECT_EQ(stopped["error"]["why"], "nothing is recorded");
  ask(*client, "record.status");
  EXPECT_EQ(recorder.asked.load(), static_cast<int>(RecordControl::Command::status));
  ask(*client, "record.snapshot");
  EXPECT_EQ(recorder.asked.load(), static_cast<int>(RecordControl::Command::snapshot));
  recorder.silent = true;
  EXPECT_EQ(ask(*client, "record.snapshot")["error"]["code"], "timeout");
  EXPECT_EQ(ask(*client, "hello")["ok"], true) << "and the connection lives";
}

TEST(Server, WithoutARecorderNothingIsRecorded) {
  Robot robot;
  robot.start();
  EXPECT_EQ(ask(*robot.client(), "record.start")["error"]["code"], "not_supported");
}

TEST(Server, StopAsksTheProgram) {
  std::atomic<int> stops{0};
  RobotOptions options;
  options.server.stop = [&] { ++stops; };
  Robot robot(options);
  robot.start();
  EXPECT_EQ(ask(*robot.client(), "stop")["ok"], true);
  EXPECT_EQ(stops, 1);
}

TEST(Server, RunWithoutSharedMemoryAnswersAllTheSame) {
  Robot robot({.shared_memory = false});
  robot.start();
  auto client = robot.client();
  EXPECT_EQ(ask(*client, "hello")["memory"], false);
  EXPECT_EQ(ask(*client, "status")["ok"], true);
  EXPECT_EQ(client->reader().error().code, hal::Errc::not_supported);
  EXPECT_EQ(ask(*client, "subscribe", {{"topics", {"eye.image"}}})["error"]["code"], "not_supported");
}

TEST(Server, DoorbellWakesForNewMessages) {
  Robot robot;
  robot.start();
  auto client = robot.client();
  auto reader = client->reader();
  ASSERT_TRUE(reader);
  const auto topic = *(*reader)->find("eye.image");
  const std::uint32_t silent = client->bell(topic);
  std::this_thread::sleep_for(20ms);
  EXPECT_EQ(client->bell(topic), silent) << "rings for nobody";
  ASSERT_TRUE(client->subscribe(std::vector<std::string>{"eye.image"}));
  Cursor cursor;
  std::vector<std::byte> copy((*reader)->bytes(topic));
  std::uint32_t before = 0;
  for (int got = 0; got < 20;) {
    const std::uint32_t seen = client->bell(topic);
    while (const auto message = (*reader)->next(topic, cursor)) {
      if (!(*reader)->copy(*message, copy)) continue;
      msg::Image image;
      std::memcpy(static_cast<void*>(&image), copy.data() + sizeof(rt::SlotHeader), sizeof image);
      EXPECT_GT(image.frame_number, before);
      before = image.frame_number;
      ++got;
    }
    client->wait(topic, seen, robot.os.now() + 10s);
  }
}

TEST(Server, DoorbellsRingWhenTheRobotEnds) {
  auto robot = std::make_unique<Robot>();
  robot->prepare(1s);  // nothing is ever published
  auto client = robot->client();
  ASSERT_TRUE(client->reader());
  const std::uint32_t seen = client->bell(0);
  std::thread end([&] {
    std::this_thread::sleep_for(20ms);
    robot->server.reset();
  });
  while (client->bell(0) == seen) client->wait(0, seen, hal::kNever);
  end.join();
  EXPECT_EQ(client->request("hello").error().code, hal::Errc::closed);
}

TEST(Server, GarbageIsAnsweredCountedAndAtLastClosed) {
  Robot robot;
  robot.start();
  RawClient client(robot);
  const std::string deep(100, '[');
  const std::string bad[] = {"{", "[]", "{\"request\":7}", deep, "\xFF", "null", "{\"request\":\"hello\"", "7"};
  for (const std::string& text : bad) {
    ASSERT_TRUE(client.send_frame(text));
    const auto reply = client.reply();
    ASSERT_TRUE(reply) << text;
    EXPECT_EQ((*reply)["error"]["code"], code_name(hal::Errc::bad_data)) << text;
  }
  ASSERT_TRUE(client.send_frame("{\"request\":\"hello\"}"));
  EXPECT_TRUE(client.reply()) << "eight may be mistakes";
  ASSERT_TRUE(client.send_frame("{"));
  static_cast<void>(client.reply());
  EXPECT_FALSE(client.reply()) << "the ninth is not";
  EXPECT_EQ(robot.server->stats().garbage.value(), 9U);
  auto next = robot.client();
  EXPECT_EQ(ask(*next, "status")["outsiders"]["closed_for_garbage"], 1);
}

TEST(Server, WhoAsksTooOftenIsAnsweredLaterAndCounted) {
  RobotOptions options;
  options.server.limits.requests_per_s = 2;
  Robot robot(options);
  robot.start();
  RawClient client(robot);
  // More at once than a second allows: they wait in the socket, and none is lost.
  for (int i = 0; i < 6; ++i) ASSERT_TRUE(client.send_frame("{\"request\":\"hello\"}"));
  for (int i = 0; i < 6; ++i) {
    const auto reply = client.reply();
    ASSERT_TRUE(reply) << i;
    EXPECT_EQ((*reply)["ok"], true) << i;
  }
  EXPECT_GT(robot.server->stats().throttled.value(), 0U);
}

TEST(Server, LongRepliesThatNobodyTakesLeaveRoomForShortOnes) {
  RobotOptions options;
  options.server.limits.patience = 60s;
  options.server.limits.long_reply_bytes = 2 << 20;
  options.graph.period = 250us;
  Robot robot(options);
  robot.prepare(2s);
  ASSERT_TRUE(robot.discrete->run());
  const std::string timeline = R"({"request":"timeline","last_ms":60000,"id":5})";
  RawClient first(robot), second(robot);
  ASSERT_TRUE(first.send_frame(timeline));
  while (robot.server->stats().requests.value() < 1) std::this_thread::sleep_for(1ms);
  ASSERT_TRUE(second.send_frame(timeline));
  const auto busy = second.reply();
  ASSERT_TRUE(busy);
  ASSERT_EQ((*busy)["ok"], false);
  EXPECT_EQ((*busy)["error"]["code"], code_name(hal::Errc::busy));
  EXPECT_EQ((*busy)["id"], 5);
  ASSERT_TRUE(second.send_frame(R"({"request":"status"})"));
  EXPECT_EQ((*second.reply())["ok"], true);
  EXPECT_EQ(robot.server->stats().refused_replies.value(), 1U);  // counted by the time of the next reply
  const auto whole = first.reply();
  ASSERT_TRUE(whole);
  EXPECT_EQ((*whole)["ok"], true);
  EXPECT_GT(whole->dump().size(), options.server.limits.long_reply_bytes / 2) << "or both would have had room";
  ASSERT_TRUE(second.send_frame(timeline));
  EXPECT_EQ((*second.reply())["ok"], true) << "taken, so there is room again";
}

TEST(Server, LengthThatCannotBeEndsTheConnection) {
  Robot robot;
  robot.start();
  for (const std::string_view head : {std::string_view("\0\0\0\0", 4), std::string_view("\1\0\1\0", 4)}) {
    RawClient client(robot);
    ASSERT_TRUE(client.send(head));
    EXPECT_FALSE(client.reply());
  }
}

TEST(Server, RequestInPiecesIsARequest) {
  Robot robot;
  robot.start();
  RawClient client(robot);
  const std::string text = R"({"request":"hello"})";
  std::string all = std::string("\x13\0\0\0", 4) + text;
  for (const char& c : all) ASSERT_TRUE(client.send({&c, 1}));
  EXPECT_EQ((*client.reply())["ok"], true);
}

TEST(Server, LongestRequestIsReadAndALongerOneIsNot) {
  Robot robot;
  robot.start();
  RawClient client(robot);
  std::string text = R"({"request":"hello","x":")";
  text += std::string(kMaxRequestBytes - text.size() - 2, 'a') + "\"}";
  ASSERT_EQ(text.size(), kMaxRequestBytes);
  ASSERT_TRUE(client.send_frame(text));
  EXPECT_EQ((*client.reply())["ok"], true);
  static_cast<void>(client.send_frame(text + " "));
  EXPECT_FALSE(client.reply());
}

TEST(Names, SecondRobotOfANameIsRefusedAndToldWhoHoldsIt) {
  std::string why;
  auto first = Name::take("twin", why);
  ASSERT_TRUE(first) << why;
  auto second = Name::take("twin", why);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, hal::Errc::busy);
  EXPECT_EQ(why, "robot \"twin\" runs already, as process " + std::to_string(::getpid()));
  first->reset();
  EXPECT_TRUE(Name::take("twin", why)) << why;
}

TEST(Names, AreChecked) {
  std::string why;
  for (const char* name : {"", "a/b", "..", "a b", "12345678901234567890123456789012345678901"})
    EXPECT_EQ(Name::take(name, why).error().code, hal::Errc::bad_argument) << name;
  EXPECT_EQ(why, "robot name \"12345678901234567890123456789012345678901\": letters, digits, _ and -, at most 40");
}

TEST(Names, RunningRobotsAreListedAndOneIsFound) {
  std::string why;
  EXPECT_EQ(find_running("", why).error().code, hal::Errc::not_found);
  EXPECT_EQ(why, "no robot runs");
  auto b = Name::take("b", why);
  EXPECT_EQ(find_running("", why)->robot, "b");
  auto a = Name::take("a", why);
  const auto all = running(why);
  ASSERT_EQ(all->size(), 2U);
  EXPECT_EQ((*all)[0].robot, "a");
  EXPECT_EQ((*all)[1].pid, ::getpid());
  EXPECT_EQ(find_running("", why).error().code, hal::Errc::bad_argument);
  EXPECT_EQ(why, "several robots run; name one of a, b");
  EXPECT_EQ(find_running("c", why).error().code, hal::Errc::not_found);
  EXPECT_EQ(why, "no robot \"c\" runs; there is a, b");
}

TEST(Names, FolderOpenToOthersIsRefused) {
  const std::string path = g_run_dir.path() + "/open";
  std::filesystem::create_directory(path);
  ::chmod(path.c_str(), 0755);
  ::setenv("SINEW_RUN_DIR", path.c_str(), 1);
  std::string why;
  EXPECT_EQ(Name::take("x", why).error().code, hal::Errc::denied);
  EXPECT_NE(why.find("others may enter it"), std::string::npos) << why;
  const std::string link = g_run_dir.path() + "/link";
  ::chmod(path.c_str(), 0700);
  std::filesystem::create_directory_symlink(path, link);
  ::setenv("SINEW_RUN_DIR", link.c_str(), 1);
  EXPECT_EQ(Name::take("x", why).error().code, hal::Errc::denied);
  ::setenv("SINEW_RUN_DIR", (path + "/new").c_str(), 1);
  EXPECT_TRUE(Name::take("x", why)) << why;
  struct stat info {};
  ASSERT_EQ(::stat((path + "/new").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0700u);
  ::setenv("SINEW_RUN_DIR", g_run_dir.path().c_str(), 1);
}

TEST(Names, TwoRobotsDoNotMeet) {
  Robot a({.name = "left", .first_sequence = 1000}), b({.name = "right", .first_sequence = 900'000});
  a.start(), b.start();
  auto to_a = a.client(), to_b = b.client();
  ASSERT_TRUE(ask(*to_a, "param.set", {{"module", "counter"}, {"param", "gain"}, {"value", 5}})["step"].is_number());
  EXPECT_EQ(ask(*to_b, "params", {{"module", "counter"}})["params"][0]["value"], 1.0);
  const auto newest = [](Client& c) {
    auto reader = c.reader();
    for (;;)
      if (const auto message = (*reader)->newest(*(*reader)->find("counter.range"))) return message->sequence;
  };
  EXPECT_LT(newest(*to_a), 900'000U);
  EXPECT_GE(newest(*to_b), 900'000U);
}

}  // namespace
}  // namespace sinew::tap::server_test
