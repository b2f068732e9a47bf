#pragma once
#include <array>
#include <string>

#include "msg/flight.hpp"
#include "msg/ground_motion.hpp"
#include "rt/module.hpp"
#include "vision/ground_shift.hpp"
#include "vision/luma.hpp"

namespace sinew::vision {

/// How a camera turned between two instants, by the rates of its vehicle.
/// Shape:   a ring of the last 256 rates: a quarter of a second at 1 kHz.
/// Thread:  owner.   RT: yes.
class TurnHistory {
 public:
  void clear() { count_ = 0; }
  /// A rate that held since the one before. Stamps that do not rise are left out.
  void add(msg::Time stamp, const math::Vec3& gyro_radps);
  /// Rotation vector in base axes; the parts of the interval that are not known count as no turn.
  math::Vec3 between(msg::Time from, msg::Time to) const;

 private:
  static constexpr std::size_t kMost = 256;
  struct Rate {
    msg::Time stamp;
    math::Vec3 gyro_radps;
  };
  const Rate& entry(std::size_t i) const { return ring_[(first_ + i) % kMost]; }

  std::array<Rate, kMost> ring_{};
  std::uint32_t first_ = 0, count_ = 0;
};

/// How fast the ground passes under a camera that looks down (top of its picture forward): the mean shift of the whole
/// picture by elementary motion detection, in bins of pixels, less what the vehicle's own turning made of it. See
/// ground_shift.hpp for the three detectors. `picture` shows the motion of every bin, the direction as a colour and the
/// magnitude (equation 3) as brightness, for people.
/// Bins: a detector sees about one pixel a frame, and beyond its peak a lower flight looks slower. `bin` 0 takes the
/// least of 1, 2, 4, 8 at which `wanted_motion_radps` is at most `most_shift_px` bins a frame.
/// Frames:  base: forward x, left y; the camera's optical frame has x to the right (-y) and y to the rear (-x).
/// Thread:  executor, woken by the camera.   RT: yes.
/// Errors:  stale when there is no new image, for the first one, and when the size changed; fault when the image's
///          header or format cannot be used, it does not fit, or its stamp is not after the last one.
/// `detector` and `bin` are read in configure().
class GroundMotion final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  hal::Status configure(rt::Setup& setup) override;
  void reset() override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  void paint(msg::Image& out, msg::Time stamp);
  std::uint32_t bin_of(const msg::Image& image) const;

  rt::In<msg::Image> image_;
  rt::InQueue<msg::NavState> state_;
  rt::Out<msg::GroundMotion> motion_;
  rt::Out<msg::Image> picture_;
  std::string detector_ = "gradient";
  ShiftBy by_ = ShiftBy::gradient;
  std::int64_t bin_ = 0;
  bool derotate_ = true, show_ = true;
  double wanted_motion_radps_ = 0.75, most_shift_px_ = 0.7, frame_s_ = 1.0 / 30, fov_y_rad_ = 1.0382921838;
  double gain_ = 1, noise_grey_ = 1.5;
  std::uint32_t picture_bytes_ = 0, picture_number_ = 0;
  TurnHistory turns_;
  Luma older_, newer_;
  msg::Time older_stamp_;
  std::vector<std::uint8_t> scratch_;
  std::vector<float> magnitude_, direction_rad_;
};

}  // namespace sinew::vision
