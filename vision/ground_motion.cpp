#include "vision/ground_motion.hpp"

#include <algorithm>

#include "math/elementary.hpp"
#include "vision/elementary_motion.hpp"

namespace sinew::vision {
namespace {

/// A direction as a colour of full brightness: a wheel of red, yellow, green, cyan, blue, magenta.
struct Colour {
  float r, g, b;
};
Colour wheel(float direction_rad) {
  const float turn = (direction_rad + detail::kPi) * (3.0f / detail::kPi);  // 0..6
  const auto rise = [turn](float at) {
    float away = turn - at;
    if (away < -3) away += 6;
    if (away > 3) away -= 6;
    return std::clamp(2.0f - (away < 0 ? -away : away), 0.0f, 1.0f);
  };
  return {rise(0), rise(2), rise(4)};
}

}  // namespace

void TurnHistory::add(msg::Time stamp, const math::Vec3& gyro_radps) {
  if (count_ > 0 && stamp <= entry(count_ - 1).stamp) return;
  ring_[(first_ + count_) % kMost] = {stamp, gyro_radps};
  if (count_ < kMost)
    ++count_;
  else
    first_ = (first_ + 1) % kMost;
}

math::Vec3 TurnHistory::between(msg::Time from, msg::Time to) const {
  math::Vec3 turn;
  for (std::size_t i = 1; i < count_; ++i) {
    const msg::Time begin = std::max(entry(i - 1).stamp, from), end = std::min(entry(i).stamp, to);
    if (begin < end) turn += entry(i).gyro_radps * msg::seconds(end - begin);
  }
  return turn;
}

void GroundMotion::declare(rt::Declaration& d) {
  d.in("image", image_);
  d.in("state", state_, {.depth = 128, .optional = true});
  d.out("motion", motion_);
  d.out("picture", picture_);
  older_.declare_state(d);
  d.state(turns_, older_stamp_, picture_number_);
  d.param("detector", detector_,
          {.doc = "raw (equations as published), contrast (divided by the variance), gradient; at the start"});
  d.param("bin", bin_,
          {.unit = "px", .min = 0, .max = 8, .doc = "1, 2, 4 or 8; 0: by the wanted motion; at the start"});
  d.param("wanted_motion_radps", wanted_motion_radps_,
          {.unit = "rad/s", .min = 0.01, .max = 20, .doc = "that a controller holds: fixes the bin"});
  d.param("most_shift_px", most_shift_px_, {.unit = "px", .min = 0.1, .max = 4, .doc = "of it, a frame, in bins"});
  d.param("frame_s", frame_s_, {.unit = "s", .min = 0.001, .max = 1, .doc = "from picture to picture, for the bin"});
  d.param("fov_y_rad", fov_y_rad_, {.unit = "rad", .min = 0.05, .max = 3, .doc = "of the camera, top to bottom"});
  d.param("gain", gain_,
          {.min = 1e-6, .max = 1e9, .doc = "reading of the detector for a shift of one bin a frame; gradient: 1"});
  d.param("noise_grey", noise_grey_,
          {.min = 0, .max = 50, .doc = "deviation of a pixel between frames of a still scene, grey levels"});
  d.param("derotate", derotate_, {.doc = "takes the vehicle's own turning off"});
  d.param("show", show_, {.doc = "publishes the picture"});
}

hal::Status GroundMotion::configure(rt::Setup& setup) {
  const auto by = shift_by(detector_);
  if (!by) {
    setup.explain("detector: raw, contrast or gradient");
    return hal::Error{hal::Errc::bad_argument, "vision::GroundMotion: detector"};
  }
  by_ = *by;
  if (bin_ != 0 && bin_ != 1 && bin_ != 2 && bin_ != 4 && bin_ != 8) {
    setup.explain("bin: 0, 1, 2, 4 or 8");
    return hal::Error{hal::Errc::bad_argument, "vision::GroundMotion: bin", bin_};
  }
  const std::size_t pixels = setup.image_pixels(image_);  // a small picture may need no bins
  older_ = Luma(pixels);
  newer_ = Luma(pixels);
  scratch_.assign(2 * pixels, 0);
  magnitude_.assign(pixels, 0);
  direction_rad_.assign(pixels, 0);
  picture_bytes_ = setup.image_bytes(picture_);
  return {};
}

void GroundMotion::reset() {
  older_.clear();
  turns_.clear();
  picture_number_ = 0;
}

std::uint32_t GroundMotion::bin_of(const msg::Image& image) const {
  if (bin_ != 0) return static_cast<std::uint32_t>(bin_);
  const double focal_px = 0.5 * image.height / math::tan(0.5 * fov_y_rad_);
  return bin_for(wanted_motion_radps_, frame_s_, focal_px, most_shift_px_);
}

/// Every bin as a square of its size.
void GroundMotion::paint(msg::Image& out, msg::Time stamp) {
  const ImageView older = older_.view(), newer = newer_.view();
  correlate_polar(older, newer, magnitude_.data(), direction_rad_.data());
  double sum = 0;
  for (std::uint32_t y = 0; y + 1 < newer.height; ++y)
    for (std::uint32_t x = 0; x + 1 < newer.width; ++x) sum += magnitude_[std::size_t{y} * newer.width + x];
  const double mean = sum / ((newer.width - 1.0) * (newer.height - 1.0));
  const float full = static_cast<float>(255 / (3 * (mean > 1 ? mean : 1)));
  const std::uint32_t zoom = out.width / newer.width;
  out.stamp = stamp;
  out.frame_number = picture_number_;
  for (std::uint32_t y = 0; y < newer.height; ++y) {
    std::uint8_t* p = out.row(y * zoom);
    for (std::uint32_t x = 0; x < newer.width; ++x) {
      const std::size_t i =
          std::size_t{y < newer.height - 1 ? y : y - 1} * newer.width + (x < newer.width - 1 ? x : x - 1);
      const Colour c = wheel(direction_rad_[i]);
      const float bright = std::min(255.0f, magnitude_[i] * full);
      for (std::uint32_t k = 0; k < zoom; ++k, p += 3) {
        p[0] = static_cast<std::uint8_t>(c.r * bright);
        p[1] = static_cast<std::uint8_t>(c.g * bright);
        p[2] = static_cast<std::uint8_t>(c.b * bright);
      }
    }
    for (std::uint32_t k = 1; k < zoom; ++k) std::copy_n(out.row(y * zoom), out.stride, out.row(y * zoom + k));
  }
}

rt::StepStatus GroundMotion::step(const rt::Step&) noexcept {
  for (const msg::NavState& s : state_) turns_.add(s.stamp, math::Vec3(s.gyro_radps));
  const msg::Image* image = image_.get();
  if (image == nullptr || !image_.updated()) return rt::StepStatus::stale;
  const std::uint32_t bin = bin_of(*image);
  if (!newer_.take(view(*image), bin)) return rt::StepStatus::fault;
  const msg::Duration interval = image->stamp - older_stamp_;
  const bool first = older_.empty();
  if (!first && interval.count() <= 0) return rt::StepStatus::fault;

  // Of a bin: the mean of its pixels, rounded to a grey level.
  const double noise_grey = math::sqrt(noise_grey_ * noise_grey_ / (bin * bin) + 1.0 / 12);
  const auto reading = first ? std::nullopt : read_shift(older_.view(), newer_.view(), by_, noise_grey, scratch_);
  if (reading && show_ && picture_bytes_ > 0) {
    const ImageView now = newer_.view();
    ++picture_number_;
    msg::Image& out = picture_.loan();
    if (!out.format_as(msg::PixelFormat::rgb8, now.width * bin, now.height * bin) &&
        !out.format_as(msg::PixelFormat::rgb8, now.width, now.height))
      return rt::StepStatus::fault;
    paint(out, image->stamp);
  }
  if (reading) {
    const ImageView now = newer_.view();
    const double focal_px = 0.5 * now.height / math::tan(0.5 * fov_y_rad_);
    math::Vec3 turn = derotate_ ? turns_.between(older_stamp_, image->stamp) : math::Vec3{};
    turn = {-turn.y, -turn.x, -turn.z};  // of base to the optical frame
    const PixelShift turned = shift_of_turn(turn, now.width, now.height, focal_px);
    const double x_px = reading->x / gain_, y_px = reading->y / gain_;
    const double to_radps = 1 / (focal_px * msg::seconds(interval));
    msg::GroundMotion& out = motion_.loan();
    out.stamp = image->stamp;
    out.interval_ns = interval.count();
    // The ground goes to the rear of the picture (down) where the vehicle travels forward, and right where it goes
    // left.
    out.forward_radps = (y_px - turned.y_px) * to_radps;
    out.left_radps = (x_px - turned.x_px) * to_radps;
    out.turn_forward_px = turned.y_px, out.turn_left_px = turned.x_px;
    out.reading_x = reading->x, out.reading_y = reading->y;
    out.shift_px = math::sqrt(x_px * x_px + y_px * y_px);
    out.contrast_grey = reading->contrast_grey;
    out.bin = bin;
    out.seen = reading->seen;
  }
  older_.swap(newer_);
  older_stamp_ = image->stamp;
  return reading ? rt::StepStatus::ok : rt::StepStatus::stale;
}

}  // namespace sinew::vision
