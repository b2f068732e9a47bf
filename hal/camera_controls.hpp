#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/clock.hpp"
#include "hal/result.hpp"

namespace sinew::hal {

/// One setting of a camera, as the device names it.
struct CameraControl {
  std::string name;  // "exposure_time_absolute", "gain"; libcamera: "ExposureTime"
  double min = 0, max = 0, step = 0, value = 0;
  bool read_only = false;
};

/// "gain 0 to 100 in steps of 1, is 20", for people.
std::string to_text(const CameraControl& control);

/// The controls of a camera that can be set while it runs. A camera with controls implements this beside hal::Camera:
/// ask with dynamic_cast. Only request() may be called while the graph runs.
class CameraControls {
 public:
  virtual ~CameraControls() = default;
  /// The controls at the opening of the camera, in the device's order; unchanged when it comes back with other ranges.
  virtual const std::vector<CameraControl>& controls() const = 0;
  /// Asks for a value; the camera's own thread sets it. Of several requests at once the last one counts. When the
  /// device refuses a value, the state text says so; a camera that comes back gets the value again.
  /// Thread:  any.   RT: yes.   Errors: bad_argument: no such control, out of its range, read only, not a number.
  virtual Status request(std::size_t control, double value) noexcept = 0;
  /// The exposure control, its unit, and the setting that stops the camera from choosing the exposure itself:
  /// `automatic` (where there is one) is to be `manual`.
  struct Exposure {
    std::size_t control = 0;
    Duration unit{0};
    std::optional<std::size_t> automatic;
    double manual = 0;
  };
  virtual std::optional<Exposure> exposure() const = 0;
  /// The control that is the gain of the sensor, in the device's own units.
  virtual std::optional<std::size_t> gain() const = 0;
  /// Index of `name` in controls(). Nothing: unknown.
  std::optional<std::size_t> find(std::string_view name) const;
  /// All controls in words, one after the other: for the error about an unknown one.
  std::string list() const;
};

}  // namespace sinew::hal
