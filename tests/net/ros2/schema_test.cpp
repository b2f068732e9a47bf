#include "net/ros2/schema.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "msg/all.hpp"
#include "msg/ros2msg.hpp"
#include "net/ros2/definitions.hpp"

namespace sinew::ros2 {
namespace {

using testing::HasSubstr;

std::string refusal(std::string_view text) {
  Types types;
  std::string why;
  EXPECT_FALSE(types.add("p/T", text, why));
  return why;
}

TEST(Ros2Schema, FieldsHaveTheirKindsAndShapes) {
  Types types;
  std::string why;
  ASSERT_TRUE(types.add("p/Inner", "float64 x\n", why)) << why;
  ASSERT_TRUE(
      types.add("p/T",
                "# a remark\nuint8 ONE=1\nstring NAME = \"x\"\nbyte level 3\nstring<=256 name\nInner[2] pair # two\n"
                "p/Inner[] any\nint32[<=5] few\n",
                why))
      << why;
  const Type& type = *types.find("p/msg/T");
  ASSERT_EQ(type.fields.size(), 5U);
  EXPECT_EQ(type.find("level")->kind, Kind::u8);
  EXPECT_EQ(type.find("name")->longest_text, 256U);
  EXPECT_EQ(type.find("pair")->shape, Shape::fixed);
  EXPECT_EQ(type.find("pair")->nested, types.find("p/Inner"));
  EXPECT_EQ(type.find("any")->count, 0U);
  EXPECT_EQ(type.find("few")->shape, Shape::sequence);
  EXPECT_EQ(type.find("few")->count, 5U);
  EXPECT_EQ(type.least_bytes, 1U + 4 + 16 + 4 + 4);
}

TEST(Ros2Schema, WhatIsNoDefinitionIsRefusedWithItsLine) {
  EXPECT_EQ(refusal("int32 a\nfloat65 b\n"), "p/msg/T, line 2: type p/float65 is not known");
  EXPECT_THAT(refusal("int32"), HasSubstr("a line is TYPE NAME"));
  EXPECT_THAT(refusal("int32 a\nint8 a"), HasSubstr("line 2: a is there twice"));
  EXPECT_THAT(refusal("int32[0] a"), HasSubstr("an array is"));
  EXPECT_THAT(refusal("int32[99999999999] a"), HasSubstr("an array is"));
  EXPECT_THAT(refusal("int32<=3 a"), HasSubstr("a bound is string<=N"));
  EXPECT_THAT(refusal("float64[1000000] a\nfloat64[1000000] b"), HasSubstr("larger than a message may be"));
}

TEST(Ros2Schema, NamesOnTheWireAreThoseOfRos) {
  EXPECT_EQ(dds_type_name("sensor_msgs/msg/Imu"), "sensor_msgs::msg::dds_::Imu_");
  EXPECT_EQ(dds_type_name("rcl_interfaces/srv/GetParameters_Request"),
            "rcl_interfaces::srv::dds_::GetParameters_Request_");
  EXPECT_EQ(long_name("std_msgs/Header"), "std_msgs/msg/Header");
}

TEST(Ros2Schema, ADefinitionWithItsNestedTypesReadsBack) {
  for (const Distro distro : {Distro::humble, Distro::jazzy})
    for (const Type& type : known_types(distro).all()) {
      Types again;
      std::string why;
      ASSERT_TRUE(again.add_with_nested(type.name, with_nested(type), why)) << why;
      EXPECT_EQ(idl_of(*again.find(type.name)), idl_of(type));
    }
}

TEST(Ros2Schema, EveryOwnMessageIsAKnownType) {
  for (const msg::TypeInfo* type : msg::all_types())
    EXPECT_NE(known_types(Distro::humble).find(msg::ros2_name(*type)), nullptr) << type->name;
}

TEST(Ros2Schema, DistributionsDifferWhereTheirTypesDo) {
  EXPECT_EQ(known_types(Distro::humble).find("rmw_dds_common/msg/Gid")->fields[0].count, 24U);
  EXPECT_EQ(known_types(Distro::jazzy).find("rmw_dds_common/msg/Gid")->fields[0].count, 16U);
  EXPECT_EQ(known_types(Distro::humble).find("sensor_msgs/msg/Range")->find("variance"), nullptr);
  EXPECT_NE(known_types(Distro::jazzy).find("sensor_msgs/msg/Range")->find("variance"), nullptr);
  EXPECT_NE(known_types(Distro::jazzy).find("rmw_dds_common/msg/ParticipantEntitiesInfo"), nullptr);
}

TEST(Ros2Schema, IdlIsWhatRosidlWrites) {
  EXPECT_EQ(idl_of(*known_types(Distro::humble).find("std_msgs/Header")),
            "module builtin_interfaces { module msg {\n  struct Time {\n    long sec;\n    unsigned long nanosec;\n  "
            "};\n}; };\n"
            "module std_msgs { module msg {\n  struct Header {\n    builtin_interfaces::msg::Time stamp;\n    string "
            "frame_id;\n"
            "  };\n}; };\n");
}

}  // namespace
}  // namespace sinew::ros2
