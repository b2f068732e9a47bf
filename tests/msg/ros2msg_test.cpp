#include "msg/ros2msg.hpp"

#include <gtest/gtest.h>

#include <set>

#include "math/hash.hpp"
#include "msg/actuators.hpp"
#include "msg/all.hpp"
#include "msg/image.hpp"
#include "msg/sensors.hpp"

namespace {

using namespace sinew::msg;

TEST(Ros2Msg, TextOfATypeWithNestedOnes) {
  EXPECT_EQ(ros2msg_schema(type_info<ImuSample>()),
            "# Angular rate and specific force in the base frame.\n"
            "int64 stamp  # [ns] middle of the sampling interval\n"
            "sinew_msgs/Vec3 gyro_radps  # [rad/s] base frame\n"
            "sinew_msgs/Vec3 accel_mps2  # [m/s^2] base frame, +g upward at rest\n"
            "================================================================================\n"
            "MSG: sinew_msgs/Vec3\n"
            "# Three coordinates.\n"
            "float64 x\n"
            "float64 y\n"
            "float64 z\n");
}

TEST(Ros2Msg, TextOfATypeWithBulk) {
  EXPECT_EQ(ros2msg_schema(type_info<Image>()),
            "# A camera image; pixel rows follow the header.\n"
            "int64 stamp  # [ns] mid-point of the exposure\n"
            "int64 exposure_ns  # [ns] exposure time\n"
            "uint32 frame_number  # [1] counted by the camera\n"
            "uint32 width  # [px]\n"
            "uint32 height  # [px]\n"
            "uint32 stride  # [B] bytes from row to row\n"
            "uint32 format  # [enum] 0 none, 1 mono8, 2 rgb8, 3 bgr8, 4 yuyv\n"
            "uint32 capacity_bytes  # [B] room behind the header\n"
            "uint8[] data\n");
  EXPECT_EQ(ros2_name(type_info<Image>()), "sinew_msgs/msg/Image");
}

TEST(Ros2Msg, NamesOfValuesAndBitsComeWithTheirNumbers) {
  const std::string text = ros2msg_schema(type_info<GuardianState>());
  EXPECT_NE(text.find("uint32 mode  # [enum] 0 standby, 1 armed, 2 active, 3 safe\n"), text.npos) << text;
  EXPECT_NE(text.find("uint32 faults  # [1] bits: 1 lease, 2 not finite, 4 limit, 8 rate, 16 count, 32 device, 64 "
                      "failsafe; now\n"),
            text.npos)
      << text;
}

TEST(Descriptions, EveryEnumerationNamesItsValuesAndNoNameIsThereTwice) {
  for (const TypeInfo* type : all_types())
    for (const FieldInfo& f : type->fields) {
      SCOPED_TRACE(std::string(type->name) + "." + std::string(f.name));
      EXPECT_EQ(f.unit == "enum", !f.names.empty() && !f.bits);
      std::set<std::string_view> names;
      std::set<std::uint32_t> values;
      for (const ValueName& known : f.names) {
        EXPECT_TRUE(names.insert(known.name).second && values.insert(known.value).second) << known.name;
        EXPECT_EQ(known.name.find_first_of(",;:"), known.name.npos) << "definitions part names by these";
        EXPECT_EQ(name_of(f.names, known.value), known.name);
        EXPECT_TRUE(!f.bits || (known.value != 0 && (known.value & (known.value - 1)) == 0)) << "one bit";
      }
      EXPECT_EQ(name_of(f.names, 0x40000000), "");
    }
}

TEST(Ros2Msg, EveryTypeHasItsOwnSchemaHash) {
  std::set<std::uint64_t> hashes;
  for (const TypeInfo* type : all_types()) hashes.insert(sinew::math::fnv1a64(ros2msg_schema(*type)));
  EXPECT_EQ(hashes.size(), all_types().size());
}

}  // namespace
