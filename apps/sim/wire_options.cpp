#include "apps/sim/wire_options.hpp"

#include <cstdio>

namespace sinew::plant {
namespace {

/// "5+3": from second 5 for 3 s; an empty text when it is such a time.
std::string check_stretch(const std::string& text) {
  double from = 0, length = 0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf+%lf%c", &from, &length, &rest) == 2 && from >= 0 && length > 0) return "";
  return "'" + text + "' is not FROM+LENGTH in seconds, e.g. 5+3";
}

bool three(const std::string& text, double& x, double& y, double& z) {
  char rest = 0;
  return std::sscanf(text.c_str(), "%lf,%lf,%lf%c", &x, &y, &z, &rest) == 3;
}

std::string check_three(const std::string& text) {
  double x = 0, y = 0, z = 0;
  return three(text, x, y, z) && x * x + y * y + z * z <= 1e4 ? "" : "'" + text + "' is not X,Y,Z";
}

/// "1.5,-2,0"; an empty text when it is one.
std::string check_turn(const std::string& text) {
  double x = 0, y = 0, z = 0;
  if (three(text, x, y, z) && x * x + y * y + z * z <= 900) return "";
  return "'" + text + "' is not RIGHT,DOWN,FORWARD in degrees, at most 30 together";
}

}  // namespace

void WireOptions::describe(CLI::App& app) {
  app.add_option("--can", can,
                 "real time: drives on this CAN bus move the joints: TRANSPORT:ADDRESS, e.g. udp:7; "
                 "socketcand-server:[HOST:]PORT is one that others open as HOST:PORT/can0");
  app.add_option("--servo", servos,
                 "the drive of the next joint: on --can cia402:ID, cybergear:ID, dronecan:ID or mit:ID:MOTOR; on a "
                 "--serial MODEL:ID or MODEL:ID:LINE, e.g. xm430_w350:1; with @RAD behind it for a zero that is off; "
                 "none: the joint has no drive")
      ->allow_extra_args(false);
  app.add_option("--serial", serial,
                 "real time: a half-duplex line with servos, as a pseudo terminal with the name PATH; behind it, with "
                 "commas, bit_rate=N, echo, latency_ms=N, lost=SHARE, delay_us=N, reboot=ID@SECOND, off=ID@SECOND, "
                 "overload=ID@SECOND, hot=ID@SECOND, gone@SECOND; may be repeated")
      ->allow_extra_args(false)
      ->type_name("PATH[,KEY=VALUE...]");
  app.add_option("--iio", iio, "real time: the IMU also as the kernel's IIO would show it, under this folder");
  app.add_option("--gyro-bias", gyro_bias, "on top of the --iio IMU's own errors: X,Y,Z in rad/s")
      ->check(check_three)
      ->needs("--iio");
  auto* video = app.add_option(
      "--v4l2", v4l2,
      "real time: the camera also as the V4L2 device /dev/video0 under this folder (a robot's key root)");
  app.add_option("--unplug-camera", unplug, "the plug of the --v4l2 camera is out: FROM+LENGTH in s of plant time")
      ->check(check_stretch)
      ->needs(video);
  app.add_option("--camera-late", camera_late_ms, "the stamps of the --v4l2 camera are late by so many ms")
      ->check(CLI::Range(-100.0, 20.0))  // a frame arrives after 25 ms, and the driver believes no stamp of the future
      ->needs(video);
  app.add_option("--camera-turned", camera_turned,
                 "how the camera is mounted off its place: deg about its right, down and forward axis, e.g. 1.5,-2,0")
      ->check(check_turn);
}

math::Vec3 WireOptions::camera_turned_rad() const {
  math::Vec3 turned;
  return three(camera_turned, turned.x, turned.y, turned.z) ? turned * (math::kPi / 180) : math::Vec3{};
}

msg::Vec3 WireOptions::gyro_bias_radps() const {
  msg::Vec3 bias;
  static_cast<void>(three(gyro_bias, bias.x, bias.y, bias.z));  // empty: none
  return bias;
}

bool WireOptions::unplugged(double& from_s, double& until_s) const {
  double length_s = 0;
  if (std::sscanf(unplug.c_str(), "%lf+%lf", &from_s, &length_s) != 2) return false;
  until_s = from_s + length_s;
  return true;
}

}  // namespace sinew::plant
