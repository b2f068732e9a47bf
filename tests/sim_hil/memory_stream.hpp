#pragma once
#include <algorithm>
#include <cstring>
#include <vector>

#include "hal/stream.hpp"

namespace sinew::sim_hil {

/// A peer that sends what the test prepared, `chunk` bytes at a time, then hangs up. Bytes written to it stay in
/// `written`.
class MemoryStream final : public hal::Stream {
 public:
  explicit MemoryStream(std::vector<std::byte> script, std::size_t chunk = SIZE_MAX)
      : script_(std::move(script)), chunk_(chunk) {}
  hal::Result<std::size_t> read(std::span<std::byte> into) noexcept override {
    const std::size_t n = std::min({into.size(), script_.size() - at_, chunk_});
    if (n == 0) return hal::Error{hal::Errc::closed, "end of script"};
    std::memcpy(into.data(), script_.data() + at_, n);
    at_ += n;
    return n;
  }
  hal::Result<std::size_t> read_now(std::span<std::byte> into) noexcept override { return read(into); }
  hal::Status write(std::span<const std::byte> head, std::span<const std::byte> tail) noexcept override {
    written.insert(written.end(), head.begin(), head.end());
    written.insert(written.end(), tail.begin(), tail.end());
    return {};
  }
  hal::Result<std::size_t> write_now(std::span<const std::byte> bytes) noexcept override {
    const std::size_t n = std::min(bytes.size(), accepts);
    static_cast<void>(write(bytes.first(n), {}));
    return n;
  }
  void set_patience(hal::Duration) noexcept override {}
  bool local() const noexcept override { return true; }
  hal::Status write_with_memory(std::span<const std::byte> bytes, const hal::SharedMemory&) noexcept override {
    return write(bytes, {});
  }
  hal::Result<std::unique_ptr<hal::SharedMemory>> take_memory(MemoryAccess) override {
    return hal::Error{hal::Errc::not_found, "no memory in a script"};
  }
  void shutdown() noexcept override {}

  std::vector<std::byte> written;
  std::size_t accepts = SIZE_MAX;  // of each write_now()

 private:
  std::vector<std::byte> script_;
  std::size_t at_ = 0, chunk_;
};

}  // namespace sinew::sim_hil
