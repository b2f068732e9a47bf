#include <gtest/gtest.h>

#include <bit>

#include "fake_robot.hpp"

namespace sinew::foxglove::session_test {
namespace {

struct Fixture : testing::Test {
  void begin(Session::Options options = {}) {
    rig = std::make_unique<Rig>(std::move(options));
    rig->session->follow({robot});
    first = rig->all();
  }
  void subscribe(std::uint32_t id, std::uint32_t channel) {
    EXPECT_TRUE(rig->json({{"op", "subscribe"}, {"subscriptions", {{{"id", id}, {"channelId", channel}}}}}));
  }
  std::shared_ptr<FakeRobot> robot = std::make_shared<FakeRobot>("quad");
  std::unique_ptr<Rig> rig;
  std::vector<Received> first;
};
using SessionTest = Fixture;

TEST_F(SessionTest, BeginsWithServerInfoThenChannelsThenServices) {
  begin();
  ASSERT_EQ(first.size(), 3u);
  EXPECT_EQ(first[0].json()["op"], "serverInfo");
  EXPECT_EQ(first[0].json()["capabilities"],
            Json::array({"parameters", "parametersSubscribe", "services", "connectionGraph"}));
  EXPECT_EQ(first[0].json()["metadata"]["robot"], "quad");
  const Json channels = first[1].json()["channels"];
  ASSERT_EQ(channels.size(), 4u);
  EXPECT_EQ(channels[0], Json({{"id", 1},
                               {"topic", "/imu.raw"},
                               {"encoding", "cdr"},
                               {"schemaName", "sinew_msgs/msg/ImuSample"},
                               {"schema", "int64 stamp\n"},
                               {"schemaEncoding", "ros2msg"}}));
  EXPECT_EQ(first[2].json()["services"][0]["name"], "/sinew/arm");
}

TEST_F(SessionTest, OfAllRobotsHasNamesThatBeginWithTheRobots) {
  begin({.all_robots = true});
  EXPECT_EQ(first[1].json()["channels"][0]["topic"], "/quad/imu.raw");
  EXPECT_EQ(first[2].json()["services"][0]["name"], "/quad/sinew/arm");
}

TEST_F(SessionTest, ASubscribedMessageComesWithItsSubscriptionAndTime) {
  begin();
  subscribe(9, 1);
  robot->publish(0, "payload", 0x0102030405060708);
  const auto message = rig->next();
  ASSERT_TRUE(message && message->binary);
  EXPECT_EQ(message->number(0, 1), 1u);
  EXPECT_EQ(message->number(1, 4), 9u);
  EXPECT_EQ(message->number(5, 8), 0x0102030405060708u);
  EXPECT_EQ(message->bytes.substr(13), "payload");
}

TEST_F(SessionTest, AfterUnsubscribeNothingComesAndTheRobotIsLetGo) {
  begin();
  subscribe(9, 1);
  EXPECT_EQ(robot->inboxes[0].size(), 1u);
  rig->json({{"op", "unsubscribe"}, {"subscriptionIds", {9}}});
  EXPECT_TRUE(robot->inboxes[0].empty());
  subscribe(9, 1);
  EXPECT_EQ(robot->inboxes[0].size(), 1u) << "the number is free again";
}

TEST_F(SessionTest, OfALargeTopicOnlyTheNewestMessageWaits) {
  begin();
  subscribe(1, 2);
  for (const char* text : {"a", "b", "c"}) robot->publish(1, text);
  EXPECT_EQ(rig->next()->bytes.substr(13), "c");
  EXPECT_FALSE(rig->next());
}

TEST_F(SessionTest, OfASmallTopicTheLast2000WaitOldestFirst) {
  begin();
  subscribe(1, 1);
  for (int i = 0; i < 2500; ++i) robot->publish(0, std::to_string(i));
  const auto all = rig->all();
  ASSERT_EQ(all.size(), 2000u);
  EXPECT_EQ(all.front().bytes.substr(13), "500");
  EXPECT_EQ(all.back().bytes.substr(13), "2499");
}

TEST_F(SessionTest, SmallMessagesGoFirstButLargeOnesAreNotStarved) {
  begin();
  subscribe(1, 1);
  subscribe(2, 2);
  robot->publish(1, "large");
  for (int i = 0; i < 200; ++i) robot->publish(0, "small");
  EXPECT_EQ(rig->next()->number(1, 4), 1u);
  int place = 1;
  while (rig->next()->number(1, 4) != 2) ++place;
  EXPECT_LE(place, 64);
}

TEST_F(SessionTest, ARobotThatRestartsComesBackWithNewChannels) {
  begin();
  subscribe(5, 1);
  rig->session->follow({});
  auto gone = rig->all();
  ASSERT_EQ(gone.size(), 2u);
  EXPECT_EQ(gone[0].json()["channelIds"], Json::array({1, 2, 3, 4}));
  EXPECT_EQ(gone[1].json()["serviceIds"], Json::array({1, 2}));
  EXPECT_TRUE(robot->inboxes[0].empty());
  const auto again = std::make_shared<FakeRobot>("quad");
  rig->session->follow({again});
  EXPECT_EQ(rig->of("advertise")["channels"][0]["id"], 5);
  subscribe(5, 5);
  again->publish(0, "x");
  EXPECT_EQ(rig->next()->number(1, 4), 5u);
}

TEST_F(SessionTest, WrongSubscriptionsAreToldAndHarmNothing) {
  begin();
  subscribe(1, 77);
  EXPECT_EQ(rig->complaint(), "subscribe: no channel 77");
  subscribe(1, 1);
  subscribe(1, 2);
  EXPECT_EQ(rig->complaint(), "subscribe: subscription 1 is there already");
  subscribe(2, 1);
  EXPECT_EQ(rig->complaint(), "subscribe: channel 1 is subscribed to already");
}

TEST_F(SessionTest, EightMessagesThatAreNoneEndIt) {
  begin();
  for (int i = 0; i < 7; ++i) EXPECT_TRUE(rig->text("{\"op\": 3}"));
  EXPECT_FALSE(rig->binary("\x09"));
}

TEST_F(SessionTest, AClientThatOnlyAsksAndReadsNothingIsEnded) {
  begin();
  robot->replies["params"] =
      R"({"ok":true,"params":[{"module":"m","param":"p","type":"text","value":")" + std::string(60000, 'x') + "\"}]}";
  bool open = true;
  for (int i = 0; i < 200 && open; ++i) {
    open = rig->json({{"op", "getParameters"}, {"parameterNames", Json::array()}, {"id", "a"}});
    rig->run_posted();
  }
  EXPECT_FALSE(open);
}

TEST_F(SessionTest, ParametersAreThoseOfModulesTheirSwitchesAndThePeriodsOfThreads) {
  begin();
  robot->replies["params"] = R"({"ok":true,"params":[{"module":"rate","param":"kp","type":"number","value":2}]})";
  robot->replies["status"] =
      R"({"ok":true,"modules":[{"name":"rate","running":false}],"threads":[{"name":"fast","period_ns":2500000}]})";
  rig->json({{"op", "getParameters"}, {"parameterNames", Json::array()}, {"id", "a"}});
  const Json values = rig->of("parameterValues");
  EXPECT_EQ(values["id"], "a");
  EXPECT_EQ(values["parameters"], Json::array({{{"name", "rate.kp"}, {"value", 2}, {"type", "float64"}},
                                               {{"name", "rate.enabled"}, {"value", false}},
                                               {{"name", "fast.period_us"}, {"value", 2500.0}, {"type", "float64"}}}));
  rig->json({{"op", "getParameters"}, {"parameterNames", {"rate.kp"}}});
  EXPECT_EQ(rig->of("parameterValues")["parameters"].size(), 1u);
}

TEST_F(SessionTest, ParametersAreWrittenOneAfterTheOtherByTheirRequests) {
  begin({.may_command = true});
  rig->json({{"op", "setParameters"},
             {"parameters",
              {{{"name", "rate.kp"}, {"value", 3}},
               {{"name", "rate.enabled"}, {"value", false}},
               {{"name", "fast.period_us"}, {"value", 5000}}}},
             {"id", "b"}});
  EXPECT_EQ(rig->of("parameterValues")["id"], "b");
  ASSERT_GE(robot->asked.size(), 3u);
  EXPECT_EQ(robot->asked[0],
            std::pair(std::string("param.set"), std::string(R"({"module":"rate","param":"kp","value":3})")));
  EXPECT_EQ(robot->asked[1], std::pair(std::string("module.disable"), std::string(R"({"module":"rate"})")));
  EXPECT_EQ(robot->asked[2],
            std::pair(std::string("thread.period"), std::string(R"({"thread":"fast","period_us":5000})")));
}

TEST_F(SessionTest, WhatTheRobotRefusesIsToldWithItsReason) {
  begin({.may_command = true});
  robot->replies["param.set"] =
      R"({"ok":false,"error":{"code":"bad_argument","why":"rate.kp: 7.5: a number from 0 to 2"}})";
  rig->json({{"op", "setParameters"}, {"parameters", {{{"name", "rate.kp"}, {"value", 7.5}}}}});
  EXPECT_EQ(rig->complaint(), "rate.kp: rate.kp: 7.5: a number from 0 to 2");
}

TEST_F(SessionTest, WithoutTokenNothingIsWrittenCalledOrPublished) {
  begin();
  rig->json({{"op", "setParameters"}, {"parameters", {{{"name", "rate.kp"}, {"value", 1}}}}});
  EXPECT_EQ(rig->complaint(), "rate.kp: needs the token: connect with ?token=TOKEN");
  rig->binary("\x02" + little(1, 4) + little(1, 4) + little(4, 4) + "json{}");
  EXPECT_EQ(rig->of("serviceCallFailure")["message"], "needs the token: connect with ?token=TOKEN");
  rig->json({{"op", "advertise"},
             {"channels", {{{"id", 1}, {"topic", "/operator.setpoint"}, {"encoding", "json"}, {"schemaName", ""}}}}});
  EXPECT_EQ(rig->complaint(), "advertise: /operator.setpoint: needs the token: connect with ?token=TOKEN");
  EXPECT_TRUE(robot->asked.empty());
}

TEST_F(SessionTest, ARequestThatOnlyLooksNeedsNoToken) {
  begin();
  robot->replies["record.status"] = R"({"ok":true,"recording":false})";
  rig->binary("\x02" + little(2, 4) + little(44, 4) + little(4, 4) + "json");
  const auto reply = rig->next();
  ASSERT_TRUE(reply && reply->binary);
  EXPECT_EQ(reply->number(0, 1), 3u);
  EXPECT_EQ(reply->number(1, 4), 2u);
  EXPECT_EQ(reply->number(5, 4), 44u);
  EXPECT_EQ(reply->bytes.substr(13), R"(json{"ok":true,"recording":false})");
}

TEST_F(SessionTest, WhileSomebodyElseHasControlCommandsAreRefused) {
  begin({.may_command = true});
  rig->refusal = "anna has control of quad";
  rig->binary("\x02" + little(1, 4) + little(1, 4) + little(4, 4) + "json{}");
  EXPECT_EQ(rig->of("serviceCallFailure")["message"], "anna has control of quad");
}

TEST_F(SessionTest, AMessageOfTheClientGoesToItsExternalTopic) {
  begin({.may_command = true});
  rig->json({{"op", "advertise"},
             {"channels", {{{"id", 4}, {"topic", "/operator.setpoint"}, {"encoding", "json"}, {"schemaName", ""}}}}});
  rig->binary("\x01" + little(4, 4) + R"({"x": 1})");
  rig->run_posted();
  ASSERT_EQ(robot->asked.size(), 1u);
  EXPECT_EQ(robot->asked[0],
            std::pair(std::string("publish"), std::string(R"({"topic":"operator.setpoint","message":{"x":1}})")));
  rig->json({{"op", "advertise"},
             {"channels", {{{"id", 5}, {"topic", "/imu.raw"}, {"encoding", "json"}, {"schemaName", ""}}}}});
  EXPECT_EQ(rig->complaint(),
            "advertise: /imu.raw: is no topic that is written from outside; these are: operator.setpoint");
}

TEST_F(SessionTest, FollowedParametersComeWhenTheyChange) {
  begin();
  robot->replies["params"] = R"({"ok":true,"params":[{"module":"rate","param":"kp","type":"number","value":2}]})";
  rig->json({{"op", "subscribeParameterUpdates"}, {"parameterNames", {"rate.kp"}}});
  rig->session->tick();
  EXPECT_EQ(rig->of("parameterValues")["parameters"][0]["value"], 2);
  for (int i = 0; i < 10; ++i) rig->session->tick();
  EXPECT_TRUE(rig->of("parameterValues").is_null()) << "no change";
  robot->replies["params"] = R"({"ok":true,"params":[{"module":"rate","param":"kp","type":"number","value":2.5}]})";
  for (int i = 0; i < 10; ++i) rig->session->tick();
  EXPECT_EQ(rig->of("parameterValues")["parameters"][0]["value"], 2.5);
}

TEST_F(SessionTest, TheGraphHasModulesAndIsTakenBackWithItsRobot) {
  begin();
  rig->json({{"op", "subscribeConnectionGraph"}});
  const Json graph = rig->of("connectionGraphUpdate");
  EXPECT_EQ(graph["publishedTopics"][0], Json({{"name", "/imu.raw"}, {"publisherIds", {"imu"}}}));
  EXPECT_EQ(graph["subscribedTopics"][0], Json({{"name", "/imu.raw"}, {"subscriberIds", {"filter", "log"}}}));
  EXPECT_EQ(graph["advertisedServices"][0], Json({{"name", "/sinew/arm"}, {"providerIds", {"quad"}}}));
  rig->session->follow({});
  EXPECT_EQ(rig->of("connectionGraphUpdate")["removedTopics"], Json::array({"/imu.raw", "/camera.raw"}));
}

TEST_F(SessionTest, ARobotWithAClockOfItsOwnGivesTheTime) {
  robot->facts_.own_clock = true;
  begin();
  EXPECT_EQ(first[0].json()["capabilities"].back(), "time");
  robot->now_ns = 5'000'000'000;
  rig->session->tick();
  const auto time = rig->next();
  ASSERT_TRUE(time && time->binary);
  EXPECT_EQ(time->number(0, 1), 2u);
  EXPECT_EQ(time->number(1, 8), 5'000'000'000u);
  rig->session->tick();
  EXPECT_FALSE(rig->next()) << "it stands still";
}

TEST_F(SessionTest, APictureIsAskedForWhenTheLastOneIsDelivered) {
  begin();
  subscribe(3, 3);
  rig->link.shortest_round_trip_us = 200;
  EXPECT_FALSE(rig->next());
  ASSERT_EQ(robot->wanted.size(), 1u);
  robot->picture(1000);
  ASSERT_TRUE(rig->next());
  rig->link.outstanding = 1013;
  EXPECT_FALSE(rig->next());
  EXPECT_EQ(robot->wanted.size(), 2u) << "one is on its way, one is being made";
  robot->picture(1000);
  ASSERT_TRUE(rig->next());
  rig->link.outstanding = 2026;
  EXPECT_FALSE(rig->next());
  EXPECT_EQ(robot->wanted.size(), 2u);
  EXPECT_GT(rig->woken_later, 0) << "it looks again soon";
  rig->link.acknowledged = 1013, rig->link.outstanding = 1013;
  EXPECT_FALSE(rig->next());
  EXPECT_EQ(robot->wanted.size(), 3u);
}

TEST_F(SessionTest, PlaybackOfARecordedRunIsControlledBySdkV1) {
  robot->facts_.recorded_ns = {1'500'000'000, 9'000'000'000};
  robot->facts_.own_clock = true;
  begin({.sdk = true});
  EXPECT_EQ(first[0].json()["capabilities"].back(), "playbackControl");
  EXPECT_EQ(first[0].json()["dataStartTime"], Json({{"sec", 1}, {"nsec", 500'000'000}}));
  EXPECT_EQ(first[0].json()["dataEndTime"], Json({{"sec", 9}, {"nsec", 0}}));
  robot->replies["playback"] = R"({"ok":true,"state":"playing","time_ns":4000000000,"speed":2.0})";
  rig->binary("\x03" + little(0, 1) + little(std::bit_cast<std::uint32_t>(2.0F), 4) + little(1, 1) +
              little(4'000'000'000, 8) + little(3, 4) + "abc");
  const auto state = rig->next();
  ASSERT_TRUE(state && state->binary);
  EXPECT_EQ(state->bytes, "\x05" + little(0, 1) + little(4'000'000'000, 8) +
                              little(std::bit_cast<std::uint32_t>(2.0F), 4) + little(1, 1) + little(3, 4) + "abc");
  std::vector<std::string> requests;
  for (const auto& [request, arguments] : robot->asked) requests.push_back(request + arguments);
  EXPECT_EQ(requests,
            (std::vector<std::string>{R"(playback.speed{"speed":2.0})", R"(playback.seek{"time_ns":4000000000})",
                                      "playback.play{}", "playback{}"}));
}

TEST_F(SessionTest, AReplyThatComesAfterTheEndIsDropped) {
  begin();
  robot->hold = true;
  rig->json({{"op", "getParameters"}, {"parameterNames", Json::array()}});
  rig->session.reset();
  for (const auto& done : robot->held) done(R"({"ok":true})");
  rig->run_posted();
}

}  // namespace
}  // namespace sinew::foxglove::session_test
