#pragma once
// Messages of Sinew to the bytes of ROS 2 messages, and back. Which types, and how each field is translated, is a table
// (map_table()); docs/ros2.md prints it.
// Units:   both sides SI; degrees for latitude and longitude; what differs stands in the table.
// Frames:  both sides REP-103: body x forward, y left, z up; world x east, y north, z up; optical z forward, x right.
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "msg/describe.hpp"
#include "msg/image.hpp"
#include "net/ros2/definitions.hpp"
#include "net/ros2/value.hpp"

namespace sinew::ros2 {

/// What a translation needs to know besides the two types; which of it, `needs` in the table says.
struct MapOptions {
  std::string frame{}, child_frame{};                  // frame_id, and the frame of a pose or transform
  std::vector<std::string> joints{};                   // in the order of the channels
  std::string field{};                                 // "voltage_v", "gyro_radps.x", "value[2]": for single numbers
  std::string object{};                                // class_id of detections
  double field_of_view_rad = 0, min_m = 0, max_m = 0;  // of a range finder
  double geoid_m = std::numeric_limits<double>::quiet_NaN();  // height of mean sea level above the ellipsoid
  std::vector<double> camera{};                               // fx, fy, cx, cy (px)
  std::vector<double> distortion{};                           // k1, k2, p1, p2, k3
};

/// One line of the table.
struct MapLine {
  std::string_view ros, own;  // "sensor_msgs/msg/Imu", "ImuSample"; "" for any message
  bool out = false, in = false;
  std::vector<std::string_view> needs{};  // of MapOptions
  std::string_view remark{};
  std::vector<std::pair<std::string, std::string>> fields{};  // ROS field, from what
};
/// In the order of docs/ros2.md.
const std::vector<MapLine>& map_table();

/// Own types that go out as, or come in from, this ROS type; "any" for all of them.
std::vector<std::string> own_types_for(std::string_view ros, bool out);
/// All ROS types of one direction.
std::vector<std::string> ros_types(bool out);

namespace detail {
struct Plan;
}

/// A topic of the robot as a ROS 2 topic.
/// Thread:  owner.   RT: no.
class Outgoing {
 public:
  /// Null: `why` says what is wrong with these types or options.
  static std::unique_ptr<Outgoing> make(Distro distro, std::string_view ros, const msg::TypeInfo& own,
                                        const MapOptions& options, std::string& why);
  ~Outgoing();

  const Type& type() const;
  /// True for sensor_msgs/msg/CompressedImage: `picture` holds the file.
  bool wants_picture() const;
  /// `message`: struct and pixels. `to_ros_ns`: added to every instant. False: there is nothing to say (a position that
  /// is not valid, say), and `out` is not the message.
  bool encode(const void* message, std::int64_t to_ros_ns, std::vector<std::uint8_t>& out,
              std::span<const std::uint8_t> picture = {});

 private:
  explicit Outgoing(std::unique_ptr<detail::Plan> plan);
  std::unique_ptr<detail::Plan> plan_;
};

/// Fills an image, whose room is known, from a file as sensor_msgs/msg/CompressedImage has it. Null: done; else why
/// not.
using ReadPicture = std::function<const char*(std::span<const std::uint8_t> file, msg::Image& out)>;

/// A ROS 2 topic as messages of the robot.
/// Thread:  owner.   RT: no.
class Incoming {
 public:
  static std::unique_ptr<Incoming> make(Distro distro, std::string_view ros, const msg::TypeInfo& own,
                                        const MapOptions& options, std::string& why);
  ~Incoming();

  const Type& type() const;
  struct [[nodiscard]] Result {
    std::string_view error{};                // empty: `message` is filled
    std::optional<std::int64_t> stamp_ns{};  // the header's, in ROS time; none: it has none, or 0
    bool skipped = false;                    // nothing wrong: there is just nothing to tell (no echo in range)
    explicit operator bool() const { return error.empty() && !skipped; }
  };
  /// `message`: a slot with room for `bulk_capacity` bytes behind the struct. Instants in it are ROS time minus
  /// `to_ros_ns`. Numbers that are not finite are refused, as the robot would. Files of pictures are refused without
  /// `read_picture`.
  Result decode(std::span<const std::uint8_t> in, std::int64_t to_ros_ns, void* message,
                std::uint32_t bulk_capacity = 0, const ReadPicture& read_picture = {});

 private:
  explicit Incoming(std::unique_ptr<detail::Plan> plan);
  std::unique_ptr<detail::Plan> plan_;
};

/// A frame that never moves against its parent.
struct StaticFrame {
  std::string parent, child;
  double xyz_m[3]{};
  double quat_wxyz[4]{1, 0, 0, 0};
};

}  // namespace sinew::ros2
