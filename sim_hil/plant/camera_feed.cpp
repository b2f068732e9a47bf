#include "sim_hil/plant/camera_feed.hpp"

#include <vector>

namespace sinew::plant {

namespace {
constexpr std::size_t kStackBytes = 4 * 1024 * 1024;  // the shader compiler needs much
constexpr msg::Quat kDown{0, 0.70710678118654752, -0.70710678118654752, 0};
}  // namespace

hal::Result<std::unique_ptr<CameraFeed>> CameraFeed::start(hal::Os& os, const CameraOptions& options,
                                                           std::string& why) {
  std::unique_ptr<CameraFeed> feed(new CameraFeed(os, options));
  if (hal::Status s = feed->open(why); !s) return s.error();
  return feed;
}

hal::Status CameraFeed::open(std::string& why) {
  set_seed(0);
  if (options_.room_xml.empty() && !options_.painter) return {};
  requested_ = 1;  // the first request starts the renderer
  hal::ThreadOptions thread;
  thread.name = "plant_camera";
  thread.stack_bytes = kStackBytes;
  auto started = os_.start_thread(thread, [this] { work(); });
  if (!started) {
    requested_ = 0;
    why = "no thread for the camera";
    return started.error();
  }
  thread_ = std::move(*started);
  wait();
  why = why_;
  return opened_;
}

CameraFeed::~CameraFeed() {
  if (!thread_) return;
  wait();
  stop_ = true;
  requested_.fetch_add(1, std::memory_order_release);
  os_.wake(requested_);
}

void CameraFeed::set_seed(std::uint64_t seed) { noise_ = std::make_unique<PixelNoise>(options_.noise, seed); }

void CameraFeed::request(const Scene& scene, std::uint32_t number, std::uint8_t* pixels) {
  scene_ = scene;
  if (msg::Quat& q = scene_.camera.q_world_optical; options_.turned_rad != math::Vec3{})
    q = (math::Quat(q) * math::Quat::exp(options_.turned_rad)).normalized().to<msg::Quat>();
  number_ = number;
  pixels_ = pixels;
  requested_.fetch_add(1, std::memory_order_release);
  os_.wake(requested_);
}

void CameraFeed::wait() {
  for (;;) {
    const std::uint32_t seen = finished_.load(std::memory_order_acquire);
    if (seen == requested_.load(std::memory_order_relaxed)) return;
    os_.wait(finished_, seen, hal::kNever);
  }
}

void CameraFeed::finished(std::uint32_t done) {
  finished_.store(done, std::memory_order_release);
  os_.wake(finished_);
}

template <class Draw>
void CameraFeed::draw_requests(Draw&& draw) {
  for (std::uint32_t done = 1;;) {
    finished(done);
    std::uint32_t wanted;
    while ((wanted = requested_.load(std::memory_order_acquire)) == done) os_.wait(requested_, done, hal::kNever);
    if (stop_) return;
    draw(scene_, pixels_);
    if (noise_->on())
      noise_->add(pixels_, options_.width * msg::bytes_per_pixel(options_.format), options_.height, number_);
    done = wanted;
  }
}

void CameraFeed::work() {
  if (options_.painter) {
    const std::unique_ptr<Painter> painter = options_.painter();
    backend_ = "triangles, without OpenGL";
    return draw_requests([&](const Scene& scene, std::uint8_t* pixels) {
      const auto* drawn = reinterpret_cast<const std::uint8_t*>(painter->draw(scene).data());
      convert_image(drawn, options_.width, options_.height, options_.format, pixels, FirstRow::top);
    });
  }
  auto renderer = Renderer::create({options_.width, options_.height, false, options_.room_xml, options_.robots}, why_);
  if (!renderer) {
    opened_ = renderer.error();
    return finished(1);
  }
  backend_ = (*renderer)->backend();
  // The first frame compiles the shaders; no flight should wait for that.
  std::vector<std::uint8_t> scratch(std::size_t{options_.width} * options_.height *
                                    msg::bytes_per_pixel(options_.format));
  (*renderer)->camera_view({{0, 0, 1}, kDown}, options_.format, scratch.data());
  draw_requests([&](const Scene& scene, std::uint8_t* pixels) {
    (*renderer)->place(scene);
    (*renderer)->camera_view(scene.camera, options_.format, pixels);
  });
}

}  // namespace sinew::plant
