#include <gtest/gtest.h>

#include <cctype>
#include <cstring>
#include <set>
#include <vector>

#include "msg/all.hpp"
#include "msg/flight.hpp"
#include "msg/image.hpp"
#include "msg/ros2msg.hpp"
#include "msg/sensors.hpp"
#include "msg/team.hpp"
#include "msg/text.hpp"

namespace {

using namespace sinew::msg;

void mark_bytes(const TypeInfo& type, std::uint32_t base, std::vector<int>& covered) {
  for (const FieldInfo& f : type.fields)
    for (std::uint32_t i = 0; i < f.count; ++i) {
      const std::uint32_t size = f.kind == Kind::nested ? f.nested->size : size_of(f.kind);
      const std::uint32_t at = base + f.offset + i * size;
      if (f.kind == Kind::nested) {
        mark_bytes(*f.nested, at, covered);
      } else {
        EXPECT_EQ(at % size, 0U) << f.name << " is not aligned to its size";
        for (std::uint32_t b = 0; b < size; ++b) ++covered.at(at + b);
      }
    }
}

TEST(Describe, EveryByteOfEveryMessageBelongsToExactlyOneNumber) {
  for (const TypeInfo* type : all_types()) {
    std::vector<int> covered(type->size);
    mark_bytes(*type, 0, covered);
    for (std::size_t i = 0; i < covered.size(); ++i) ASSERT_EQ(covered[i], 1) << type->name << " byte " << i;
  }
}

TEST(Describe, FieldsAreInOrderOfTheirOffsets) {
  for (const TypeInfo* type : all_types())
    for (std::size_t i = 1; i < type->fields.size(); ++i)
      EXPECT_LT(type->fields[i - 1].offset, type->fields[i].offset) << type->name << "." << type->fields[i].name;
}

TEST(Describe, NamesAreWhatRos2ToolsAccept) {
  for (const TypeInfo* type : all_types()) {
    EXPECT_TRUE(std::isupper(static_cast<unsigned char>(type->name.front()))) << type->name;
    EXPECT_FALSE(type->doc.empty()) << type->name;
    for (const FieldInfo& f : type->fields) {
      EXPECT_TRUE(std::islower(static_cast<unsigned char>(f.name.front()))) << type->name << "." << f.name;
      for (const char c : f.name)
        EXPECT_TRUE(std::islower(static_cast<unsigned char>(c)) || std::isdigit(static_cast<unsigned char>(c)) ||
                    c == '_')
            << type->name << "." << f.name;
      EXPECT_EQ(f.name.find("__"), f.name.npos) << f.name;
    }
  }
}

TEST(Describe, AllTypesAreListedOnceInOrderOfNameAndFound) {
  std::set<std::string_view> names;
  for (const TypeInfo* type : all_types()) {
    EXPECT_TRUE(names.empty() || *names.rbegin() < type->name) << type->name;
    names.insert(type->name);
    EXPECT_EQ(find_type(type->name), type);
  }
  EXPECT_EQ(names.size(), 53U);
  EXPECT_EQ(find_type("imusample"), nullptr);
  EXPECT_EQ(find_type(""), nullptr);
}

TEST(Describe, AMatesMessageIsNamedAfterItsOwnAndHoldsItBehindAHeadOf32Bytes) {
  const TypeInfo& mate = type_info<FromMate<ImuSample>>();
  EXPECT_EQ(mate.name, "ImuSampleFromMate");
  EXPECT_EQ(mate.size, 32 + sizeof(ImuSample));
  EXPECT_EQ(mate.fields.back().nested, &type_info<ImuSample>());
  EXPECT_EQ(mate.fields.back().offset, 32u);
  EXPECT_TRUE(mate.fields[0].is_time);
  EXPECT_FALSE(mate.fields[2].is_time) << "a length of time is no instant";
}

TEST(Describe, AMatesMessageIsFoundByNameAsTheCompilerMakesIt) {
  EXPECT_EQ(find_type("FromMate"), nullptr);
  EXPECT_EQ(find_type("ImageFromMate"), nullptr);
  EXPECT_EQ(find_type("NobodyFromMate"), nullptr);
  const auto same = [](const TypeInfo& made) {
    const TypeInfo* found = find_type(made.name);
    ASSERT_NE(found, nullptr) << made.name;
    EXPECT_EQ(ros2msg_schema(*found), ros2msg_schema(made));
    EXPECT_EQ(found->size, made.size);
    EXPECT_EQ(found->align, made.align);
    ASSERT_EQ(found->floats.size(), made.floats.size());
    for (std::size_t i = 0; i < made.floats.size(); ++i) {
      EXPECT_EQ(found->floats[i].offset, made.floats[i].offset);
      EXPECT_EQ(found->floats[i].count, made.floats[i].count);
    }
    std::vector<std::max_align_t> a(made.size / sizeof(std::max_align_t) + 1), b = a;
    std::memset(a.data(), 0xAA, made.size);
    std::memset(b.data(), 0x55, made.size);
    found->reset(a.data());
    made.reset(b.data());
    EXPECT_EQ(std::memcmp(a.data(), b.data(), made.size), 0);
  };
  same(type_info<FromMate<ImuSample>>());
  same(type_info<FromMate<NavState>>());
  same(type_info<FromMate<TeamState>>());
}

TEST(Describe, KnowsNamesUnitsKindsAndShapes) {
  const TypeInfo& imu = type_info<ImuSample>();
  ASSERT_EQ(imu.fields.size(), 3U);
  EXPECT_EQ(imu.name, "ImuSample");
  EXPECT_EQ(imu.size, 56U);
  EXPECT_EQ(imu.fields[0].name, "stamp");
  EXPECT_EQ(imu.fields[0].kind, Kind::i64);
  EXPECT_EQ(imu.fields[1].name, "gyro_radps");
  EXPECT_EQ(imu.fields[1].unit, "rad/s");
  EXPECT_EQ(imu.fields[1].kind, Kind::nested);
  EXPECT_EQ(imu.fields[1].nested, &type_info<Vec3>());
  EXPECT_EQ(imu.fields[2].offset, 32U);
  const FieldInfo& x = type_info<MotionField>().fields[7];
  EXPECT_EQ(x.name, "x");
  EXPECT_EQ(x.kind, Kind::f32);
  EXPECT_TRUE(x.is_array);
  EXPECT_EQ(x.count, kMotionColumns * kMotionRows);
}

TEST(Describe, NeighbouringFloatsAreOneRunAlsoThroughNestedStructs) {
  const auto imu = type_info<ImuSample>().floats;
  ASSERT_EQ(imu.size(), 1U);
  EXPECT_EQ(imu[0].offset, 8U);
  EXPECT_EQ(imu[0].count, 6U);
  EXPECT_TRUE(imu[0].is_f64);
  const auto motion = type_info<MotionField>().floats;
  ASSERT_EQ(motion.size(), 2U);
  EXPECT_EQ(motion[0].count, 5U);
  EXPECT_TRUE(motion[0].is_f64);
  EXPECT_EQ(motion[1].offset, motion[0].offset + 5 * 8);
  EXPECT_EQ(motion[1].count, 2 * kMotionColumns * kMotionRows);
  EXPECT_FALSE(motion[1].is_f64);
  EXPECT_TRUE(type_info<Image>().floats.empty());
}

TEST(Describe, ResetGivesTheDefaultsOfTheStruct) {
  NavState nav;
  std::memset(static_cast<void*>(&nav), 0xAA, sizeof nav);
  type_info<NavState>().reset(&nav);
  EXPECT_EQ(nav.q_world_base, (Quat{1, 0, 0, 0}));
  EXPECT_EQ(nav.height_m, 0);
  EXPECT_EQ(nav.position_valid, 0U);
}

}  // namespace
