#pragma once
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "hal/os.hpp"
#include "math/linear.hpp"
#include "sim_hil/plant/pixels.hpp"
#include "sim_hil/plant/renderer.hpp"

namespace sinew::plant {

struct CameraOptions {
  std::uint32_t width = 320, height = 240;
  msg::PixelFormat format = msg::PixelFormat::yuyv;
  double noise = 1.5;           // sigma of the pixels, grey levels
  std::string_view room_xml{};  // what is drawn; empty, and no painter: there is no camera, and a feed without requests
  std::function<std::unique_ptr<Painter>()> painter = nullptr;  // of pictures of this size, instead
  std::size_t robots = 1;                                       // in the room
  math::Vec3 turned_rad;  // rotation vector about its right, down and forward axis: how far its mounting is off
};

/// The camera's own thread: it draws from a copy of the moving things, so that physics never waits for pixels.
/// One frame is in work at a time.
/// Thread:  owner; the drawing happens on a thread of ordinary priority.
class CameraFeed {
 public:
  /// Returns when OpenGL is ready. Errors: not_supported, bad_data; `why` has it in words.
  static hal::Result<std::unique_ptr<CameraFeed>> start(hal::Os& os, const CameraOptions& options, std::string& why);
  ~CameraFeed();

  /// Fixes the seed of the noise. Before the first request.
  void set_seed(std::uint64_t seed);

  /// Begins a frame into `pixels`, which stay untouched until done(). Not while busy().
  /// RT: yes.
  void request(const Scene& scene, std::uint32_t number, std::uint8_t* pixels);
  /// A request is being worked on.
  bool busy() const { return finished_.load(std::memory_order_acquire) != requested_.load(std::memory_order_relaxed); }
  /// Waits until the last request is done.
  void wait();

  const CameraOptions& options() const { return options_; }
  /// OpenGL's name of the renderer.
  const std::string& backend() const { return backend_; }

 private:
  CameraFeed(hal::Os& os, const CameraOptions& options) : os_(os), options_(options) {}
  hal::Status open(std::string& why);
  void work();
  /// Draws what is asked for until the end; `draw(scene, pixels)` puts one picture into them.
  template <class Draw>
  void draw_requests(Draw&& draw);
  void finished(std::uint32_t done);

  hal::Os& os_;
  CameraOptions options_;
  std::string backend_;
  std::unique_ptr<PixelNoise> noise_;
  // The request; written by the owner before requested_ is raised (release), read by the worker after (acquire).
  Scene scene_;
  std::uint32_t number_ = 0;
  std::uint8_t* pixels_ = nullptr;
  bool stop_ = false;
  hal::WakeWord requested_{0};
  hal::WakeWord finished_{0};  // raised by the worker after its pixels (release)
  hal::Status opened_;
  std::string why_;
  std::unique_ptr<hal::Thread> thread_;
};

}  // namespace sinew::plant
