#pragma once
// Definitions of ROS 2 messages ("ros2msg") as a recording holds them.
// Source:  "ROS 2 interface definition" (docs.ros.org, Concepts, Interfaces); MCAP's registry, "ros2msg": the types
// inside follow, each after a line of 80 '=' and a line "MSG: package/Name".
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::record {

struct Ros2Field {
  enum class Kind : std::uint8_t { boolean, i8, u8, i16, u16, i32, u32, i64, u64, f32, f64, text, nested };
  enum class Shape : std::uint8_t { one, array, sequence };
  std::string name;
  Kind kind = Kind::u8;
  Shape shape = Shape::one;
  std::uint32_t count = 1;   // of an array
  std::uint32_t nested = 0;  // index of its type
  std::string remark{};      // the comment on its line, e.g. "[m] world"
};

/// One message and the types inside it. No type contains itself.
class Ros2Schema {
 public:
  struct Type {
    std::string name;
    std::vector<Ros2Field> fields;
  };
  /// Nothing, with `why`, for text that is no definition, or uses a type that it does not define. Constants and
  /// defaults are skipped.
  static std::optional<Ros2Schema> parse(std::string_view name, std::string_view text, std::string& why);

  const Type& root() const { return types_.front(); }
  const Type& type(const Ros2Field& field) const { return types_[field.nested]; }

 private:
  std::vector<Type> types_;
};

/// Whether two definitions have the same types and fields, in the same order; what their remarks say does not matter.
bool same_definition(std::string_view a, std::string_view b);

}  // namespace sinew::record
