#pragma once
// The text files of a recorded dataset in the EuRoC/ASL form: bytes in, values out. Nothing here opens a file.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "msg/sensors.hpp"

namespace sinew::dataset {

/// One line of an image list; the stamp is the dataset's own.
struct ImageEntry {
  std::int64_t stamp_ns = 0;
  std::string file;  // a name without folders
};

/// Where the vehicle really was. Frames: that of the file's world and of its IMU.
struct GroundTruthSample {
  std::int64_t stamp_ns = 0;
  msg::Vec3 p_world_m, v_world_mps;
  msg::Quat q_world_base;  // unit length
  msg::Vec3 gyro_bias_radps, accel_bias_mps2;
};

// Comma-separated values, one header line or more starting with '#', columns as the ASL format has them; further
// columns are ignored. Stamps are whole nanoseconds, not negative, below 2^62 and strictly increasing.
// Errors:  false; `why` is "file:line: what is wrong". `out` then holds the lines before.
// Source:  M. Burri et al., "The EuRoC micro aerial vehicle datasets", IJRR 2016, section 4 (file formats).

/// stamp, gyro x y z (rad/s), accelerometer x y z (m/s^2); stamps go to ImuSample::stamp as they are.
bool parse_imu_csv(std::string_view text, std::string_view file, std::vector<msg::ImuSample>& out, std::string& why);
/// stamp, file name.
bool parse_image_list(std::string_view text, std::string_view file, std::vector<ImageEntry>& out, std::string& why);
/// stamp, p x y z, q w x y z, v x y z, gyro bias x y z, accelerometer bias x y z.
bool parse_ground_truth_csv(std::string_view text, std::string_view file, std::vector<GroundTruthSample>& out,
                            std::string& why);
/// "1403715273262142976.png" to its stamp; false for other names.
bool stamp_of_image_name(std::string_view name, std::int64_t& stamp_ns);

}  // namespace sinew::dataset
