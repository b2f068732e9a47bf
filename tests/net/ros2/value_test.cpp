#include "net/ros2/value.hpp"

#include <gtest/gtest.h>

#include "math/random.hpp"
#include "net/ros2/definitions.hpp"

namespace sinew::ros2 {
namespace {

const Type& known(std::string_view name) { return *known_types(Distro::humble).find(name); }

Bytes encoded(const Message& message) {
  Bytes out;
  encode(message.type(), message.root(), out);
  return out;
}

const char* refusal(const Type& type, const Bytes& bytes) {
  Message message(type);
  return decode(type, bytes, message.root()).error;
}

TEST(Ros2Value, BytesAreThoseOfXcdr1) {
  Message header(known("std_msgs/Header"));
  header.find("stamp.sec")->set_integer(258);
  header.find("stamp.nanosec")->set_integer(7);
  header.find("frame_id")->text = "ab";
  EXPECT_EQ(encoded(header), (Bytes{0, 1, 0, 0, 2, 1, 0, 0, 7, 0, 0, 0, 3, 0, 0, 0, 'a', 'b', 0}));
}

TEST(Ros2Value, NumbersAreAlignedFromBehindTheHead) {
  Message value(known("rcl_interfaces/ParameterValue"));
  value.find("type")->set_integer(3);
  value.find("bool_value")->set_integer(1);
  value.find("integer_value")->set_integer(-2);
  const Bytes bytes = encoded(value);
  EXPECT_EQ(Bytes(bytes.begin(), bytes.begin() + 20),
            (Bytes{0, 1, 0, 0, 3, 1, 0, 0, 0, 0, 0, 0, 254, 255, 255, 255, 255, 255, 255, 255}));
}

TEST(Ros2Value, BigEndianPeersAreUnderstood) {
  Message time(known("builtin_interfaces/Time"));
  ASSERT_TRUE(decode(time.type(), Bytes{0, 0, 0, 0, 255, 255, 255, 254, 0, 0, 1, 2}, time.root()));
  EXPECT_EQ(time.find("sec")->integer(), -2);
  EXPECT_EQ(time.find("nanosec")->integer(), 258);
}

TEST(Ros2Value, BytesThatAreNoMessageAreRefused) {
  const Type& time = known("builtin_interfaces/Time");
  EXPECT_STREQ(refusal(time, {0, 1, 0}), "not XCDR1 (00 00 or 00 01)");
  EXPECT_STREQ(refusal(time, {0, 7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}), "not XCDR1 (00 00 or 00 01)");
  EXPECT_STREQ(refusal(time, {0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0}), "input ends inside the message");
  EXPECT_STREQ(refusal(time, {0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}), "bytes left over behind the message");
  EXPECT_EQ(refusal(time, {0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}), nullptr) << "padding";
  const Type& text = known("std_msgs/String");
  EXPECT_STREQ(refusal(text, {0, 1, 0, 0, 2, 0, 0, 0, 'a', 'b'}), "a text without its 0");
  EXPECT_STREQ(refusal(text, {0, 1, 0, 0, 3, 0, 0, 0, 'a', 0, 0}), "a text with a 0 inside");
  EXPECT_EQ(refusal(text, {0, 1, 0, 0, 0, 0, 0, 0}), nullptr) << "an empty text of some peers";
  EXPECT_STREQ(refusal(known("std_msgs/Bool"), {0, 1, 0, 0, 2}), "a bool other than 0 and 1");
}

TEST(Ros2Value, HostileLengthsAreRefusedBeforeMemoryIsTaken) {
  EXPECT_STREQ(refusal(known("std_msgs/String"), {0, 1, 0, 0, 255, 255, 255, 255, 0}), "input ends inside the message");
  EXPECT_STREQ(refusal(known("tf2_msgs/TFMessage"), {0, 1, 0, 0, 255, 255, 255, 255}), "input ends inside the message");
  EXPECT_STREQ(refusal(known("trajectory_msgs/JointTrajectory"),
                       {0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 255, 255, 255, 127, 0, 0, 0, 0}),
               "input ends inside the message");
  Bytes many(4 + 4 + 8 * (kMostValues + 1));
  many[1] = 1;
  const std::size_t count = kMostValues + 1;
  Types types;
  std::string why;
  ASSERT_TRUE(types.add("p/T", "float32[] a\n", why));
  for (int i = 0; i < 4; ++i) many[4 + static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(count >> (8 * i));
  EXPECT_STREQ(refusal(*types.find("p/T"), many), "more elements than a message may have");
  ASSERT_TRUE(types.add("p/U", "int32[<=2] a\nstring<=2 b\n", why));
  EXPECT_STREQ(refusal(*types.find("p/U"), {0, 1, 0, 0, 3, 0, 0, 0}), "a sequence longer than its bound");
  EXPECT_STREQ(refusal(*types.find("p/U"), {0, 1, 0, 0, 0, 0, 0, 0, 4, 0, 0, 0, 'a', 'b', 'c', 0}),
               "a text longer than its bound");
}

/// Any value of a type, with sequences of up to three elements.
void fill(const Type& type, Value& value, math::Random& random, std::vector<Bytes>& store);
void fill_element(const Field& f, Value& value, math::Random& random, std::vector<Bytes>& store) {
  if (f.kind == Kind::nested) return fill(*f.nested, value, random, store);
  if (f.kind == Kind::text)
    value.text = std::string(random.below(4), 'x');
  else if (f.kind == Kind::f32 || f.kind == Kind::f64)
    value.set(static_cast<double>(random.below(1000)) * 0.25);
  else if (f.kind == Kind::boolean)
    value.set_integer(random.below(2));
  else
    value.set_integer(random.below(100));
}
void fill(const Type& type, Value& value, math::Random& random, std::vector<Bytes>& store) {
  Message::make_default(type, value);
  for (std::size_t i = 0; i < type.fields.size(); ++i) {
    const Field& f = type.fields[i];
    Value& v = value.items[i];
    if (f.shape == Shape::one) {
      fill_element(f, v, random, store);
      continue;
    }
    std::size_t count = f.shape == Shape::fixed ? f.count : random.below(4);
    if (f.shape == Shape::sequence && f.count != 0) count = std::min<std::size_t>(count, f.count);
    if (f.kind == Kind::u8 || f.kind == Kind::i8) {
      store.emplace_back(count, static_cast<std::uint8_t>(random.below(256)));
      v.bytes = store.back();
      continue;
    }
    v.items.resize(count);
    for (Value& item : v.items) fill_element(f, item, random, store);
  }
}

TEST(Ros2Value, EveryKnownTypeReadsBackWhatWasWritten) {
  math::Random random(7);
  for (const Distro distro : {Distro::humble, Distro::jazzy})
    for (const Type& type : known_types(distro).all())
      for (int round = 0; round < 3; ++round) {
        std::vector<Bytes> store;
        store.reserve(10000);
        Message message(type), again(type);
        fill(type, message.root(), random, store);
        const Bytes bytes = encoded(message);
        EXPECT_GE(bytes.size(), 4 + type.least_bytes) << type.name;
        const Decoded decoded = decode(type, bytes, again.root());
        ASSERT_TRUE(decoded) << type.name << ": " << decoded.error;
        EXPECT_EQ(encoded(again), bytes) << type.name;
        for (std::size_t cut = 0; cut + 4 < bytes.size(); cut += 1 + bytes.size() / 50) {
          Message part(type);
          EXPECT_FALSE(decode(type, {bytes.data(), cut}, part.root())) << type.name << " cut at " << cut;
        }
      }
}

}  // namespace
}  // namespace sinew::ros2
