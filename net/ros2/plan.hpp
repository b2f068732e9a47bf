#pragma once
// How one pair of types is translated. Inside of the room only.
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "net/ros2/convert.hpp"

namespace sinew::ros2::detail {

enum class What : std::uint8_t { number, constant, time, vector, quaternion, frame, child_frame };

/// One line of a translation: a field of the ROS type, and the own field (or the constant) that it is.
struct Row {
  What what;
  std::string_view ros, own{};
  double value = 0;  // of a constant
};

/// A field of an own message.
struct Member {
  std::uint32_t offset = 0;
  msg::Kind kind = msg::Kind::f64;
};
/// "gyro_radps.x", "value[2]"; none: no such number.
std::optional<Member> find_member(const msg::TypeInfo& type, std::string_view path);
double number_at(const void* message, const Member& member);
void set_number_at(void* message, const Member& member, double value);

struct Context {
  const MapOptions& options;
  const msg::TypeInfo& own;
  Message& ros;
  std::int64_t to_ros_ns = 0;
  std::span<const std::uint8_t> picture{};    // out
  std::uint32_t bulk_capacity = 0;            // in
  const ReadPicture* read_picture = nullptr;  // in
};

/// What rows cannot say, after them. False: nothing to send.
using WriteRest = bool (*)(const Context&, const void* own);
/// Null: done; kNothing: nothing to tell; else the reason of a refusal.
using ReadRest = const char* (*)(const Context&, void* own);
inline constexpr const char* kNothing = "";

struct Pair {
  std::string_view ros, own;
  bool out, in;
  std::vector<std::string_view> needs;
  std::string_view remark;
  std::vector<Row> rows;
  WriteRest write = nullptr;
  ReadRest read = nullptr;
  std::vector<std::pair<std::string_view, std::string_view>> by_code{};  // what write and read do, for the table
};
const std::vector<Pair>& pairs();

// ---- for the functions of pairs

void put_time(Value& time, std::int64_t ns);
/// None when it is 0 or no time.
std::optional<std::int64_t> time_of(const Value& time);
std::optional<double> finite(const Value& value);

}  // namespace sinew::ros2::detail
