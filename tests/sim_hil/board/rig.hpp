#pragma once
// A small plant in a thread and the board that talks to it, over a pair of connected sockets.
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hal/linux/shared_memory.hpp"
#include "hal/linux/socket.hpp"
#include "hal/platform.hpp"
#include "hal/wake_counter.hpp"
#include "sim_hil/board/sim_board.hpp"
#include "sim_hil/server/plant_link.hpp"

namespace sinew::sim_hil {

using namespace std::chrono_literals;

inline constexpr std::uint16_t kImu = 0, kRange = 1, kBaro = 2, kCamera = 3, kMotors = 4;  // places in the Welcome
inline constexpr Time at(Duration since_start) { return Time{} + since_start; }

inline PlantDescription small_plant() {
  PlantDescription p;
  p.name = "small";
  p.step = 250us;
  p.devices.resize(5);
  p.devices[kImu].kind = DeviceKind::imu, p.devices[kImu].name = "imu", p.devices[kImu].period = 1ms;
  p.devices[kRange].kind = DeviceKind::range, p.devices[kRange].name = "range", p.devices[kRange].period = 20ms;
  p.devices[kBaro].kind = DeviceKind::baro, p.devices[kBaro].name = "baro", p.devices[kBaro].period = 20ms;
  DeviceInfo& camera = p.devices[kCamera];
  camera.kind = DeviceKind::camera, camera.name = "camera", camera.period = 33ms, camera.latency = 20ms;
  camera.width = 16, camera.height = 8, camera.format = msg::PixelFormat::yuyv;
  p.devices[kMotors].kind = DeviceKind::actuators, p.devices[kMotors].name = "motors", p.devices[kMotors].channels = 4;
  return p;
}

inline constexpr std::uint16_t kRadio = 5;
/// The same with a radio.
inline PlantDescription plant_with_radio() {
  PlantDescription p = small_plant();
  DeviceInfo& radio = p.devices.emplace_back();
  radio.kind = DeviceKind::radio, radio.name = "radio";
  return p;
}

inline msg::ImuSample imu_sample(Duration stamp, double gyro_x = 0) {
  msg::ImuSample s;
  s.stamp = at(stamp);
  s.gyro_radps.x = gyro_x;
  return s;
}

inline msg::ActuatorCommand hover(double value, Duration stamp = {}) {
  msg::ActuatorCommand c;
  c.stamp = at(stamp);
  c.count = 4;
  c.armed = 1;
  for (std::size_t i = 0; i < 4; ++i) c.value[i] = value;
  return c;
}

inline constexpr Duration kLong = 20s;  // an upper bound for what happens at once on a working machine

/// Runs `plant` in a thread against the board under test.
class Rig {
 public:
  using Body = std::function<void(PlantLink&)>;
  explicit Rig(Body plant, SimBoardOptions options = {}, PlantDescription description = small_plant()) {
    auto ends = hal::stream_pair();
    EXPECT_TRUE(ends);
    plant_stream_ = std::move(ends->second);
    frames_ = std::move(*hal::create_shared_memory("frames", PlantLink::frame_memory_bytes(description)));
    thread_ = std::move(*hal::system_os().start_thread({"plant", 0, {}, 256 * 1024}, [this, plant, description] {
      auto link = PlantLink::accept(std::move(plant_stream_), description, frames_.get(), plant_why);
      if (!link) return;
      if ((*link)->wait_start()) plant(**link);
      plant_reason = (*link)->reason();
      plant_stats = (*link)->stats();
    }));
    if (!options.clock) options.clock = &clock;
    auto opened = SimBoard::open(std::move(ends->first), options, why);
    EXPECT_TRUE(opened) << why;
    if (opened) board = std::move(*opened);
  }
  ~Rig() { finish(); }
  /// Hangs up and waits for the plant; its reason and statistics are there afterwards.
  void finish() {
    board.reset();
    if (thread_) thread_->join();
  }

  hal::ManualClock clock;
  hal::WakeCounter wakes;  // outlives the board
  std::unique_ptr<SimBoard> board;
  std::string why, plant_why, plant_reason;
  PlantLink::Stats plant_stats;

 private:
  std::unique_ptr<hal::Stream> plant_stream_;
  std::unique_ptr<hal::SharedMemory> frames_;
  std::unique_ptr<hal::Thread> thread_;
};

/// An image message with room for `bytes` of pixels behind it.
class ImageBox {
 public:
  explicit ImageBox(std::uint32_t bytes) : memory_(sizeof(msg::Image) + bytes) {
    image_ = new (memory_.data()) msg::Image;
    image_->set_bulk_capacity(bytes);
  }
  msg::Image& operator*() { return *image_; }
  msg::Image* operator->() { return image_; }
  std::vector<std::uint8_t> pixels() const { return {image_->pixels(), image_->pixels() + image_->bulk_used()}; }

 private:
  std::vector<std::uint8_t> memory_;
  msg::Image* image_;
};

}  // namespace sinew::sim_hil
