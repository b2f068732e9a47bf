#pragma once
// ROS 2 message types as data: the text of their .msg files, read at run time.
// Source:  docs.ros.org, "About ROS 2 interfaces" (the language of .msg files); rosidl's mapping of it to OMG IDL.
#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::ros2 {

enum class Kind : std::uint8_t { boolean, i8, u8, i16, u16, i32, u32, i64, u64, f32, f64, text, nested };
enum class Shape : std::uint8_t { one, fixed, sequence };

/// Bytes of one number on the wire; 0: a text or a nested type.
std::uint32_t size_of(Kind kind);

struct Type;

struct Field {
  std::string name;
  std::string written;   // the element's type as the .msg file has it, of its own package too: "geometry_msgs/Vector3"
  Kind kind = Kind::u8;  // of one element; `byte` and `char` are u8
  Shape shape = Shape::one;
  std::uint32_t count = 1;         // elements of a fixed array; most elements of a sequence, 0: no limit
  std::uint32_t longest_text = 0;  // of `string<=N`; 0: no limit
  const Type* nested = nullptr;    // for Kind::nested
};

struct Type {
  std::string name;   // "sensor_msgs/msg/Imu"
  std::string lines;  // its own definition
  std::vector<Field> fields;
  std::uint32_t least_bytes = 0;  // that a value of it takes on the wire, without gaps

  const Field* find(std::string_view field) const;
};

/// Types that know each other.
/// RT:      configure only.
class Types {
 public:
  /// Reads the definition of `name` ("pkg/msg/Name"). Types that it names have been added before.
  /// Errors:  `why`: line and reason; nothing was added then.
  bool add(std::string_view name, std::string_view text, std::string& why);
  /// A definition with all that it names, as recordings hold it ("ros2msg"): lines of 80 '=' between, "MSG: pkg/Name".
  /// Types that are known already are left as they are.
  bool add_with_nested(std::string_view name, std::string_view text, std::string& why);
  /// Null: not known. Also by "pkg/Name".
  const Type* find(std::string_view name) const;
  const std::deque<Type>& all() const { return types_; }

 private:
  bool read_field(std::string_view line, std::string_view package, Type& type, std::string& why) const;

  std::deque<Type> types_;  // never moved: fields point to them
  std::map<std::string, const Type*, std::less<>> by_name_;
};

/// "pkg/Name" as "pkg/msg/Name"; others as they are.
std::string long_name(std::string_view name);
/// The name that DDS knows: "sensor_msgs::msg::dds_::Imu_", and of a service's half ("pkg/srv/Name_Request") likewise.
std::string dds_type_name(std::string_view ros_name);
/// The definition with those of all nested types, as add_with_nested() reads it.
std::string with_nested(const Type& type);
/// All of it as one OMG IDL file, as rosidl writes it: modules `pkg::msg`.
std::string idl_of(const Type& type);

}  // namespace sinew::ros2
