#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/clock.hpp"
#include "hal/result.hpp"

namespace sinew::hal {

/// One thing about a camera that can be set, as the device names it.
struct CameraControl {
  std::string name;  // "exposure_time_absolute", "gain"; libcamera: "ExposureTime"
  double min = 0, max = 0, step = 0, value = 0;
  bool read_only = false;
};

/// "gain 0 to 100 in steps of 1, is 20", for people.
std::string to_text(const CameraControl& control);

/// What a camera lets be set while it runs. A camera that has such implements this beside hal::Camera: ask with
/// dynamic_cast. Only request() may be called while the graph runs.
class CameraControls {
 public:
  virtual ~CameraControls() = default;
  /// What was there when the camera was opened, in the device's order; stays so when it comes back with other ranges.
  virtual const std::vector<CameraControl>& controls() const = 0;
  /// Asks for a value, which the camera's own thread then sets; of several at once the last one counts. A device that
  /// refuses it says so in its state text, and a camera that comes back gets it again.
  /// Thread:  any.   RT: yes.   Errors: bad_argument: no such control, out of its range, read only, not a number.
  virtual Status request(std::size_t control, double value) noexcept = 0;
  /// The control that is the exposure time, what one of its units is, and how the camera is told not to choose it
  /// itself: `automatic` (where there is one) is to be `manual`.
  struct Exposure {
    std::size_t control = 0;
    Duration unit{0};
    std::optional<std::size_t> automatic;
    double manual = 0;
  };
  virtual std::optional<Exposure> exposure() const = 0;
  /// The control that is the gain of the sensor, in the device's own units.
  virtual std::optional<std::size_t> gain() const = 0;
  /// Where `name` is among the controls(). Nothing: unknown.
  std::optional<std::size_t> find(std::string_view name) const;
  /// All of them in words, one after the other: for the error about an unknown one.
  std::string list() const;
};

}  // namespace sinew::hal
