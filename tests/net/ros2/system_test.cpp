#include "net/ros2/system.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sinew::ros2 {
namespace {

using testing::ElementsAre;

constexpr Guid kGuid{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};

TEST(Ros2System, AGidHas24BytesInHumbleAnd16InJazzy) {
  const NodeInfo node{"quad", "/", {}, {kGuid}};
  for (const auto& [distro, size] : {std::pair{Distro::humble, 24U}, std::pair{Distro::jazzy, 16U}}) {
    const Bytes bytes = discovery_info(distro, kGuid, {&node, 1});
    Message message(*known_types(distro).find("rmw_dds_common/msg/ParticipantEntitiesInfo"));
    ASSERT_TRUE(decode(message.type(), bytes, message.root()));
    EXPECT_EQ(message.find("gid.data")->bytes.size(), size);
    EXPECT_EQ(message.find("gid.data")->bytes[15], 16);
    EXPECT_EQ(message.find("node_entities_info_seq[0].node_name")->text, "quad");
    EXPECT_EQ(message.find("node_entities_info_seq[0].writer_gid_seq[0].data")->bytes[0], 1);
    // head, gid, number of nodes, "/" with its length, "quad" with its length, readers, writers, gid
    EXPECT_EQ(bytes.size(), 4 + size + 4 + (4 + 2 + 2) + (4 + 5 + 3) + 4 + 4 + size);
  }
}

TEST(Ros2System, ClocksReadBack) {
  EXPECT_EQ(clock_message(1'500'000'000), (Bytes{0, 1, 0, 0, 1, 0, 0, 0, 0x00, 0x65, 0xcd, 0x1d}));
  EXPECT_EQ(read_clock(clock_message(-1)), -1) << "sec -1, nanosec 999999999";
  EXPECT_FALSE(read_clock(Bytes{0, 1, 0, 0}));
}

TEST(Ros2System, ParametersReadBackWithTheirTypes) {
  const Parameter all[] = {{"a.b", true}, {"a.i", std::int64_t{-3}}, {"a.d", 0.25}, {"a.s", std::string("x")}};
  const auto event = read_parameter_event(parameter_event(5, "/quad", {all, 1}, {all + 1, 3}));
  ASSERT_TRUE(event);
  EXPECT_EQ(event->node, "/quad");
  ASSERT_EQ(event->set.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(event->set[i].name, all[i].name);
    EXPECT_EQ(event->set[i].value, all[i].value);
  }
  EXPECT_FALSE(read_parameter_event(Bytes{0, 1, 0, 0, 1}));
}

/// A request as Cyclone's RMW sends it.
Bytes request_bytes(std::string_view type, const std::function<void(Message&)>& fill) {
  Message message(*known_types(Distro::humble).find(type));
  fill(message);
  Bytes bytes;
  encode(message.type(), message.root(), bytes);
  Bytes head;
  for (std::uint8_t i = 1; i <= 16; ++i) head.push_back(i);
  bytes.insert(bytes.begin() + 4, head.begin(), head.end());
  return bytes;
}

/// The reply without its head, which is checked.
void read_reply(const Bytes& bytes, Message& message) {
  ASSERT_GT(bytes.size(), 20U);
  for (std::uint8_t i = 1; i <= 16; ++i) EXPECT_EQ(bytes[3 + i], i);
  Bytes body(bytes.begin(), bytes.begin() + 4);
  body.insert(body.end(), bytes.begin() + 20, bytes.end());
  ASSERT_TRUE(decode(message.type(), body, message.root()));
}

TEST(Ros2System, ParameterServicesAnswerWithTheHeadOfTheirRequest) {
  const ParameterInfo known[] = {{{"rate.kp", 0.5}, "gain", 0.0, 2.0}, {{"rate.on", true}, "", {}, {}}};
  const Bytes asked = request_bytes("rcl_interfaces/srv/GetParameters_Request", [](Message& m) {
    m.find("names")->items.resize(2);
    m.find("names[0]")->text = "rate.kp";
    m.find("names[1]")->text = "nothing";
  });
  const auto request = read_request(ParameterService::get, asked);
  ASSERT_TRUE(request);
  EXPECT_THAT(request->names, ElementsAre("rate.kp", "nothing"));
  Message got(*known_types(Distro::humble).find("rcl_interfaces/srv/GetParameters_Response"));
  read_reply(service_reply(ParameterService::get, *request, known), got);
  EXPECT_EQ(got.find("values[0].double_value")->number(), 0.5);
  EXPECT_EQ(got.find("values[1].type")->integer(), 0) << "not set";

  Message described(*known_types(Distro::humble).find("rcl_interfaces/srv/DescribeParameters_Response"));
  read_reply(service_reply(ParameterService::describe, *request, known), described);
  EXPECT_EQ(described.find("descriptors[0].floating_point_range[0].to_value")->number(), 2.0);

  Message listed(*known_types(Distro::humble).find("rcl_interfaces/srv/ListParameters_Response"));
  read_reply(service_reply(ParameterService::list, {request->head, {}, {}}, known), listed);
  EXPECT_EQ(listed.find("result.names")->items.size(), 2U);
}

TEST(Ros2System, WhatCannotBeSetIsSaidForEachParameter) {
  const Bytes asked = request_bytes("rcl_interfaces/srv/SetParameters_Request", [](Message& m) {
    Value& list = *m.find("parameters");
    list.items.resize(2);
    for (Value& p : list.items) Message::make_default(*m.type().fields[0].nested, p);
    m.find("parameters[0].name")->text = "rate.kp";
    m.find("parameters[0].value.type")->set_integer(3);
    m.find("parameters[0].value.double_value")->set(7);
  });
  const auto request = read_request(ParameterService::set, asked);
  ASSERT_TRUE(request);
  EXPECT_EQ(std::get<double>(request->set[0].value), 7);
  const std::string refused[] = {"a number from 0 to 2", ""};
  Message reply(*known_types(Distro::humble).find("rcl_interfaces/srv/SetParameters_Response"));
  read_reply(set_reply(*request, refused), reply);
  EXPECT_EQ(reply.find("results[0].successful")->integer(), 0);
  EXPECT_EQ(reply.find("results[0].reason")->text, "a number from 0 to 2");
  EXPECT_EQ(reply.find("results[1].successful")->integer(), 1);
}

}  // namespace
}  // namespace sinew::ros2
