#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "hal/camera_controls.hpp"
#include "hal/linux/camera/v4l2_port.hpp"

namespace sinew::hal {

/// The controls of a V4L2 device, by the names that v4l2-ctl prints: small letters, digits, '_' for the rest.
/// Thread:  owner.   RT: no (a USB camera answers in milliseconds).
/// Source:  Linux Media Infrastructure userspace API, part I: VIDIOC_QUERY_EXT_CTRL, VIDIOC_G_EXT_CTRLS, Camera Control
///          Reference (V4L2_CID_EXPOSURE_ABSOLUTE: units of 100 us; V4L2_CID_EXPOSURE_AUTO: 1 is manual).
class V4l2Controls {
 public:
  using Wanted = std::map<std::string, double, std::less<>>;

  /// Integers, switches and menus; buttons, texts and tables are left out. A device without controls has an empty list.
  static V4l2Controls enumerate(V4l2Port& port, int fd);
  const std::vector<CameraControl>& list() const { return list_; }
  /// Checks that every name is known and every value within its range and steps. Errors: bad_argument; `why` has each.
  Status check(const Wanted& wanted, std::string& why) const;
  /// Sets them: first switches and menus, because `auto_exposure` decides whether `exposure_time_absolute` counts.
  /// Errors:  denied, busy, io, closed: the device refused one; the others are set all the same. `why` names each
  ///          refused one; `taken` gets the accepted ones.
  Status set(V4l2Port& port, int fd, const Wanted& wanted, std::string& why, Wanted* taken = nullptr) const;
  /// In units of the control. Nothing: write only, or the device is gone.
  std::optional<std::int64_t> get(V4l2Port& port, int fd, std::size_t control) const;

  /// The present exposure time of the sensor; 0: the device does not say, or decides by itself.
  std::int64_t exposure_ns(V4l2Port& port, int fd) const;

 private:
  struct Code {
    std::uint32_t id = 0;
    bool number = false;          // neither switch nor menu
    bool wide = false;            // 64 bits
    bool volatile_value = false;  // read from the device each time
  };
  std::vector<CameraControl> list_;
  std::vector<Code> codes_;  // same order
  std::optional<std::size_t> exposure_, auto_exposure_;
};

}  // namespace sinew::hal
