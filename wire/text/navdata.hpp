#pragma once
// AR.Drone's navigation data: datagrams of options behind a header, with a sum of all bytes at their end. Little
// endian. Decoded are the header, the option "demo" (always there) and the voltage of "raw measures" (only without
// navdata_demo). Others are skipped by their size.
// Source:  Parrot, AR.Drone Developer Guide 2.0 sections 7.1 and 7.3, and navdata_common.h of its SDK 2.0 as
// node-ar-drone reproduces it.
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace sinew::wire {

struct Navdata {
  std::uint32_t state = 0;     // bits: kNavdataStates
  std::uint32_t sequence = 0;  // counts up; begins anew with the drone and when its watchdog was reset
  std::uint32_t vision = 0;
  bool has_demo = false;
  std::uint32_t fly_state = 0, control_state = 0;  // control: 2 landed, 3 flying, 4 hovering, 6 taking off, 8 landing
  std::uint32_t battery_percent = 0;
  float pitch_deg = 0, roll_deg = 0, yaw_deg = 0;  // of the drone: nose down, left side down and clockwise are
                                                   // negative, positive and positive in its own words (theta, phi, psi)
  float altitude_m = 0;
  float vx_mps = 0, vy_mps = 0, vz_mps = 0;  // forward, right, down, in the drone's own axes
  bool has_raw = false;
  float battery_v = 0;
};

/// The bits of Navdata::state, from bit 0 on; empty: not used.
inline constexpr std::array<std::string_view, 32> kNavdataStates{
    "flying",        "video",        "vision",       "control",  "altitude_hold", "user_start",    "command_ack",
    "camera",        "travelling",   "usb",          "demo",     "bootstrap",     "motor_problem", "com_lost",
    "software",      "low_battery",  "user_stop",    "timer",    "magneto",       "angles",        "wind",
    "ultrasound",    "cutout",       "pic_version",  "atcodec",  "navdata_run",   "video_run",     "acquisition",
    "ctrl_watchdog", "adc_watchdog", "com_watchdog", "emergency"};

enum class NavdataError : std::uint8_t { none, header, size, checksum };

/// RT: yes.   Errors: `out` is unspecified then.
NavdataError decode_navdata(std::span<const std::uint8_t> datagram, Navdata& out) noexcept;

/// One number of it: message "state" with a key of kNavdataStates, "sequence" or "bits"; message "demo" with
/// "fly_state", "control_state", "battery" (%), "pitch", "roll", "yaw" (deg), "altitude" (m), "velocity" (index 0..2,
/// m/s); message "raw" with "voltage" (V). Nothing: this datagram has no such one.   RT: yes.
std::optional<double> navdata_value(const Navdata& data, std::string_view message, std::string_view key,
                                    std::size_t index) noexcept;
/// Whether there is such a number at all.
bool is_navdata_value(std::string_view message, std::string_view key, std::size_t index) noexcept;

/// As a drone sends it: header, demo, and the raw measures with has_raw. Returns the bytes written; 0: no room.
std::size_t encode_navdata(const Navdata& data, std::span<std::uint8_t> out) noexcept;

}  // namespace sinew::wire
