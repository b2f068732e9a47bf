#pragma once
// Finds frames in a stream of bytes that may begin anywhere, lose bytes, and have other bytes between frames.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace sinew::wire {

/// What the first bytes of a buffer are.
struct FrameVerdict {
  enum Kind : std::uint8_t {
    more,     // the beginning of a frame, as far as can be seen
    foreign,  // no frame begins here
    broken,   // looked like one, but its checksum or end is wrong
    good      // a whole one of `size` bytes
  };
  Kind kind = more;
  std::size_t size = 0;
};

struct ScanStats {
  std::uint64_t frames = 0;
  std::uint64_t broken = 0;         // heads that turned out not to be frames
  std::uint64_t skipped_bytes = 0;  // in no frame
};

/// Collects bytes until `Format::check(bytes)` says what they are. After a broken frame the search goes on one byte
/// behind its head, so that no good frame behind or inside it is lost.
/// Format:  `static FrameVerdict check(std::span<const std::uint8_t>) noexcept` and `static constexpr kMaxFrame`.
/// Thread:  owner.   RT: yes; a byte costs at most kMaxFrame checks.
template <class Format>
class FrameScanner {
 public:
  /// Calls `on_frame(std::span<const std::uint8_t>)` for each whole frame that this byte completes.
  template <class OnFrame>
  void push(std::uint8_t byte, OnFrame&& on_frame) noexcept {
    buffer_[size_++] = byte;
    sort(on_frame, false);
  }
  /// The line was silent: a frame that was begun will not go on.
  void gap() noexcept {
    stats_.skipped_bytes += size_;
    size_ = 0;
  }
  /// The same, but whole frames are found behind the head of the one that was begun: its length may be wrong.
  template <class OnFrame>
  void gap(OnFrame&& on_frame) noexcept {
    sort(on_frame, true);
  }
  const ScanStats& stats() const noexcept { return stats_; }

 private:
  template <class OnFrame>
  void sort(OnFrame& on_frame, bool ended) noexcept {
    while (size_ > 0) {
      FrameVerdict v = Format::check({buffer_.data(), size_});
      if (v.kind == FrameVerdict::more) {
        if (!ended && size_ < buffer_.size()) return;
        v.kind = FrameVerdict::broken;  // longer than any frame is, or cut off
      }
      if (v.kind == FrameVerdict::good && v.size > 0 && v.size <= size_) {
        ++stats_.frames;
        on_frame(std::span<const std::uint8_t>(buffer_.data(), v.size));
        drop(v.size);
        continue;
      }
      if (v.kind == FrameVerdict::broken) ++stats_.broken;
      ++stats_.skipped_bytes;
      drop(1);
    }
  }
  void drop(std::size_t n) noexcept {
    std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(n), buffer_.begin() + static_cast<std::ptrdiff_t>(size_),
              buffer_.begin());
    size_ -= n;
  }

  std::array<std::uint8_t, Format::kMaxFrame> buffer_{};
  std::size_t size_ = 0;
  ScanStats stats_;
};

}  // namespace sinew::wire
