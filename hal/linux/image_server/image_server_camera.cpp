#include "hal/linux/image_server/image_server_camera.hpp"

#include <algorithm>
#include <cstring>

#include "hal/platform.hpp"

namespace sinew::hal {
namespace {

using namespace std::chrono_literals;

constexpr Duration kFirstServerPause = 100ms, kLongServerPause = 2s;
constexpr Duration kServerPatience = 50ms;  // of one read or write: whether it should stop is looked at so often

bool swaps(const ImageServerSpec& spec) { return (spec.format == msg::PixelFormat::bgr8) != spec.raw_is_bgr; }

void copy_row(const std::uint8_t* from, std::uint8_t* to, std::uint32_t pixels, bool swap) {
  if (!swap) {
    std::memcpy(to, from, std::size_t{3} * pixels);
    return;
  }
  for (std::uint32_t i = 0; i < pixels; ++i, from += 3, to += 3) to[0] = from[2], to[1] = from[1], to[2] = from[0];
}

std::string size_words(std::uint32_t width, std::uint32_t height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

}  // namespace

ImageServerCamera::ImageServerCamera(const ImageServerSpec& spec, Os& os)
    : spec_(spec),
      os_(os),
      decoder_(spec.format, spec.width, spec.height),
      picture_(spec.format, spec.width, spec.height),
      pause_(kFirstServerPause) {}

Result<std::unique_ptr<Camera>> ImageServerCamera::open(const ImageServerSpec& spec, Os& os, std::string& why) {
  if (spec.format != msg::PixelFormat::rgb8 && spec.format != msg::PixelFormat::bgr8) {
    why = "pictures of an image server are rgb8 or bgr8";
    return Error{Errc::bad_argument, "image server: format"};
  }
  std::unique_ptr<ImageServerCamera> camera(new ImageServerCamera(spec, os));
  ThreadOptions options;
  options.name = "image_server", options.stack_bytes = std::size_t{128} * 1024;
  auto thread = os.start_thread(options, [c = camera.get()] { c->run(); });
  if (!thread) {
    why = "no thread for the camera could be started";
    return thread.error();
  }
  camera->thread_ = std::move(*thread);
  return std::unique_ptr<Camera>(std::move(camera));
}

ImageServerCamera::~ImageServerCamera() {
  stop_.store(1, std::memory_order_release);
  full_.store(0, std::memory_order_release);
  os_.wake(full_);
  os_.wake(stop_);
  if (thread_) thread_->join();
}

// ---- the robot's thread

Result<bool> ImageServerCamera::read(msg::Image& out) noexcept {
  if (full_.load(std::memory_order_acquire) == 0) {
    if (!there_.load(std::memory_order_acquire)) return Error{Errc::closed, "image server"};
    return false;
  }
  const bool fits = msg::ImageBuffer::copy(*picture_, out);
  full_.store(0, std::memory_order_release);
  os_.wake(full_);
  if (!fits) {
    refused_.add();
    return Error{Errc::bad_argument, "camera: the topic's images are too small", out.capacity_bytes};
  }
  pictures_.add();
  return true;
}

ImageServerStats ImageServerCamera::stats() const {
  return {pictures_.value(), refused_.value(), broken_.value(), connections_.value()};
}

// ---- its own thread

void ImageServerCamera::tell(const std::string& what) {
  const std::string all = what.empty() ? std::string() : "image server " + spec_.endpoint + ": " + what;
  if (all != trouble_.get()) trouble_.set(all);
}

void ImageServerCamera::run() noexcept {
  while (!stopping()) {
    if (!stream_ && !connect()) {
      os_.wait(stop_, 0, os_.now() + pause_);
      pause_ = std::min<Duration>(2 * pause_, kLongServerPause);
      continue;
    }
    wait_for_turn();
    if (!stopping()) fetch();
  }
}

bool ImageServerCamera::connect() {
  auto made = connect_stream(spec_.endpoint, kServerPatience);
  if (!made) {
    tell(std::string("no connection: ") + to_string(made.error().code));
    return false;
  }
  stream_ = std::move(*made);
  stream_->set_patience(kServerPatience);
  connections_.add();
  due_ = os_.now();
  return true;
}

void ImageServerCamera::lose(const std::string& why) {
  tell(why);
  there_.store(false, std::memory_order_release);  // pairs with read()'s: who reads `closed` finds the words
  stream_->shutdown();
  stream_.reset();
  os_.wait(stop_, 0, os_.now() + pause_);
  pause_ = std::min<Duration>(2 * pause_, kLongServerPause);
}

/// Until the next picture is due, and the last one was taken.
void ImageServerCamera::wait_for_turn() {
  while (!stopping() && full_.load(std::memory_order_acquire) != 0) os_.wait(full_, 1, kNever);
  while (!stopping() && os_.now() < due_) os_.wait(stop_, 0, due_);
  const Duration period{spec_.rate_hz > 0 ? static_cast<std::int64_t>(1e9 / spec_.rate_hz) : 0};
  due_ = std::max(due_ + period, os_.now());
}

bool ImageServerCamera::receive(std::span<std::uint8_t> into, Time& first) {
  const Time begun = os_.now();
  for (std::size_t have = 0; have < into.size();) {
    const auto got = stream_->read(std::as_writable_bytes(into.subspan(have)));
    if (stopping()) return false;
    if (!got && got.error().code != Errc::timeout) {
      lose("the connection was lost");
      return false;
    }
    if (!got) {
      if (os_.now() - begun < spec_.silent) continue;
      lose("it sends no pictures");
      return false;
    }
    if (first.ns == 0) first = os_.now();
    have += *got;
  }
  return true;
}

bool ImageServerCamera::fetch() {
  std::array<std::uint8_t, wire::kUsarImageRequest> request;
  const std::size_t size =
      wire::write_usarsim_image_request({spec_.x, spec_.y, spec_.region_width, spec_.region_height}, request);
  const Time asked = os_.now();
  if (!stream_->write(std::as_bytes(std::span(request).first(size)))) {
    lose("the connection was lost");
    return false;
  }
  std::array<std::uint8_t, wire::kUsarImageHead> head;
  Time first;
  if (!receive(head, first)) return false;
  wire::UsarImageHead what;
  if (wire::parse_usarsim_image_head(head, what) != wire::UsarImageError::none) {
    broken_.add();
    lose("what it sends is no picture");
    return false;
  }
  bytes_.resize(what.size);
  if (!receive(bytes_, first)) return false;
  there_.store(true, std::memory_order_relaxed);
  if (!(what.jpeg ? take_jpeg() : take_raw())) {
    refused_.add();
    os_.wait(stop_, 0, os_.now() + kFirstServerPause);
    return true;  // the stream is whole
  }
  pause_ = kFirstServerPause;
  tell({});
  picture_->stamp = asked + (first - asked) / 2;
  picture_->exposure_ns = 0;
  picture_->frame_number = number_++;
  full_.store(1, std::memory_order_release);
  wake_.ring();
  return true;
}

bool ImageServerCamera::take_raw() {
  wire::UsarRawImage raw;
  if (wire::parse_usarsim_raw_image(bytes_, raw) != wire::UsarImageError::none) {
    tell("a raw picture has other bytes than its size needs");
    return false;
  }
  if (raw.width != spec_.width || raw.height != spec_.height) {
    tell("its pictures are " + size_words(raw.width, raw.height) + ", and the device's " +
         size_words(spec_.width, spec_.height));
    return false;
  }
  for (std::uint32_t y = 0; y < raw.height; ++y) copy_row(raw.row(y), picture_->row(y), raw.width, swaps(spec_));
  return true;
}

bool ImageServerCamera::take_jpeg() {
  if (!JpegDecoder::built()) {
    tell("it sends JPEG, and this build cannot decode it (Debian's libturbojpeg0-dev)");
    return false;
  }
  const auto shape = JpegDecoder::shape_of(bytes_);
  if (shape && (shape->width != spec_.width || shape->height != spec_.height)) {
    tell("its pictures are " + size_words(shape->width, shape->height) + ", and the device's " +
         size_words(spec_.width, spec_.height));
    return false;
  }
  if (!shape || !decoder_.decode(bytes_, *picture_)) {
    tell("a JPEG picture cannot be decoded");
    return false;
  }
  return true;
}

}  // namespace sinew::hal
