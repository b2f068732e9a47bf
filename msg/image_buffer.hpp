#pragma once
#include <cstddef>
#include <cstring>
#include <memory>
#include <new>

#include "msg/image.hpp"

namespace sinew::msg {

/// Owns one Image with its pixels outside of slots: in tests, tools and simulators. Moves, does not copy.
/// RT:      configure only (allocates).
class ImageBuffer {
 public:
  explicit ImageBuffer(std::uint32_t capacity_bytes = kMaxImageWidth * kMaxImageHeight * 3)
      : storage_(new (std::align_val_t{alignof(Image)}) std::byte[sizeof(Image) + capacity_bytes]()),
        image_(new (storage_.get()) Image()) {
    image_->capacity_bytes = capacity_bytes;
  }
  /// Just large enough; pixels are 0. An impossible format leaves an image of format none.
  ImageBuffer(PixelFormat format, std::uint32_t width, std::uint32_t height)
      : ImageBuffer(width <= kMaxImageWidth && height <= kMaxImageHeight ? width * height * bytes_per_pixel(format)
                                                                         : 0) {
    static_cast<void>(image_->format_as(format, width, height));
  }
  ImageBuffer(ImageBuffer&& other) noexcept = default;
  ImageBuffer& operator=(ImageBuffer&& other) noexcept = default;

  Image& operator*() { return *image_; }
  const Image& operator*() const { return *image_; }
  Image* operator->() { return image_; }
  const Image* operator->() const { return image_; }

  /// Takes over header and used pixels. False, and nothing changed, when they do not fit.
  [[nodiscard]] bool assign(const Image& from) { return copy(from, *image_); }

  /// The same between any two images, e.g. from a buffer into a slot; each keeps its capacity.
  [[nodiscard]] static bool copy(const Image& from, Image& to) {
    const std::uint32_t used = from.bulk_used(), capacity = to.capacity_bytes;
    if (used > capacity) return false;
    std::memcpy(static_cast<void*>(&to), static_cast<const void*>(&from), sizeof(Image) + used);
    to.capacity_bytes = capacity;
    return true;
  }

 private:
  struct Free {
    void operator()(std::byte* p) const { ::operator delete[](p, std::align_val_t{alignof(Image)}); }
  };
  std::unique_ptr<std::byte[], Free> storage_;
  Image* image_;
};

}  // namespace sinew::msg
