#pragma once
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "policy/onnx/kernels.hpp"

namespace sinew::onnx {

/// Zeros at first, at the beginning of a cache line, with kBehind more behind the end.
class AlignedFloats {
 public:
  AlignedFloats() = default;
  explicit AlignedFloats(std::size_t count) : memory_(count + kBehind + kLine), size_(count) {
    const auto address = reinterpret_cast<std::uintptr_t>(memory_.data()) / sizeof(float);
    shift_ = (kLine - address % kLine) % kLine;
  }
  // A copy could lie elsewhere in its cache line.
  AlignedFloats(const AlignedFloats&) = delete;
  AlignedFloats& operator=(const AlignedFloats&) = delete;
  AlignedFloats(AlignedFloats&& other) noexcept { *this = std::move(other); }
  AlignedFloats& operator=(AlignedFloats&& other) noexcept {
    memory_ = std::move(other.memory_);
    shift_ = std::exchange(other.shift_, 0);
    size_ = std::exchange(other.size_, 0);
    return *this;
  }

  float* data() { return memory_.data() + shift_; }
  const float* data() const { return memory_.data() + shift_; }
  std::size_t size() const { return size_; }
  std::size_t bytes() const { return memory_.size() * sizeof(float); }

 private:
  static constexpr std::size_t kLine = 64 / sizeof(float);
  std::vector<float> memory_;
  std::size_t shift_ = 0, size_ = 0;
};

}  // namespace sinew::onnx
