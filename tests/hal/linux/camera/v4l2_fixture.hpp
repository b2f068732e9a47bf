#pragma once
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "hal/linux/camera/v4l2_camera.hpp"
#include "hal/linux/camera/v4l2_sim.hpp"
#include "hal/platform.hpp"
#include "hal/wake_counter.hpp"
#include "msg/image_buffer.hpp"

namespace sinew::hal {

using namespace std::chrono_literals;

/// Looks again and again. False: not within ten seconds.
inline bool eventually(const std::function<bool()>& holds) {
  const Time deadline = system_os().now() + 10s;
  while (!holds()) {
    if (system_os().now() >= deadline) return false;
    system_os().sleep_until(system_os().now() + 1ms);
  }
  return true;
}

inline ThreadOptions named(const char* name) {
  ThreadOptions options;
  options.name = name;
  return options;
}

/// A simulated camera, the real code that opens it, and pictures that can be told apart.
class V4l2Test : public ::testing::Test {
 protected:
  V4l2Test() {
    auto watch = FdWatch::start(system_os(), named("watch"));
    EXPECT_TRUE(watch);
    if (watch) watch_ = *watch;
    spec_.path = "/dev/video0";
    spec_.width = 320, spec_.height = 240;
    options_.first_retry = 1ms, options_.longest_retry = 5ms;
    options_.restart_after = 1h;
    options_.look_every = 5ms;
  }
  void TearDown() override {
    camera_.reset();
    EXPECT_EQ(sim_.descriptors(), 0u) << "a descriptor was left open";
    EXPECT_EQ(sim_.mapped(), 0u) << "a buffer was left mapped";
  }
  /// The error's code, or nothing when it opened.
  std::optional<Errc> open() {
    camera_.reset();
    why_.clear();
    auto opened = V4l2Camera::open(sim_, spec_, system_os(), watch_, options_, why_);
    if (!opened) return opened.error().code;
    camera_ = std::move(*opened);
    return std::nullopt;
  }
  msg::ImageBuffer picture(std::uint32_t number) const {
    msg::ImageBuffer image(spec_.format, spec_.width, spec_.height);
    for (std::uint32_t y = 0; y < image->height; ++y)
      for (std::uint32_t x = 0; x < image->stride; ++x)
        image->row(y)[x] = static_cast<std::uint8_t>(x * 7 + y * 13 + number);
    return image;
  }
  /// Frame `number` of a camera with 30 frames/s.
  bool deliver(std::uint32_t number) { return sim_.deliver(*picture(number), stamp(number)); }
  static Time stamp(std::uint32_t number) { return Time{1'000'000'000} + number * 33'333us; }
  /// True: a frame came. Errors count as none.
  bool read() {
    const auto got = camera_->read(*image_);
    return got && *got;
  }
  bool same_pixels(std::uint32_t number) const {
    const auto expected = picture(number);
    return image_->bulk_used() == expected->bulk_used() &&
           std::equal(expected->pixels(), expected->pixels() + expected->bulk_used(), image_->pixels());
  }

  V4l2Sim sim_;
  CameraSpec spec_;
  V4l2CameraOptions options_;
  std::shared_ptr<FdWatch> watch_;
  std::unique_ptr<V4l2Camera> camera_;
  std::string why_;
  msg::ImageBuffer image_;
};

}  // namespace sinew::hal
