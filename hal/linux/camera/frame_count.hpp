#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "hal/clock.hpp"
#include "hal/wide.hpp"

namespace sinew::hal {

/// Counts of a camera's frames since it was opened.
struct CameraStats {
  std::uint64_t frames = 0;     // handed on
  std::uint64_t lost = 0;       // missing between two sequence numbers of the driver
  std::uint64_t corrupted = 0;  // marked as faulty by the driver, or too short
  std::uint64_t repeated = 0;   // no newer than the one before
  std::uint64_t too_large = 0;  // did not fit the topic's capacity
  std::uint64_t unstamped = 0;  // handed on with the time of reading: the driver gave no stamp, or one of the future
  std::uint64_t reopens = 0;    // streams begun anew
  std::uint64_t tries = 0;      // tries to open it again since it was last there
};

/// A camera's count of its frames: the number of each, missing frames, the rate.
/// Thread:  one writes (the reader; between two streams the thread that begins the next, which also calls reopened()),
///          any asks.
/// RT: yes, but for text().
class FrameCount {
 public:
  /// Counts a frame as the driver delivered it. False: no newer than the last one, do not hand it on.
  /// `stamp`: none when the driver gives none.
  bool arrived(std::uint32_t sequence, std::optional<Time> stamp) noexcept;
  /// Number of the frame that arrived last: the driver's, and continued in later streams.
  std::uint32_t number() const noexcept { return number_; }
  void handed_on() noexcept { frames_.add(); }
  void corrupted() noexcept { corrupted_.add(); }
  void too_large() noexcept { too_large_.add(); }
  void unstamped() noexcept { unstamped_.add(); }
  /// A stream begins. True: not the first stream, so the next frame's number leaves a gap; call reopened() once the
  /// reader can have frames: a rising count of reopenings means that reading works.
  [[nodiscard]] bool stream_begins() noexcept;
  void reopened() noexcept { reopens_.add(); }
  void tried() noexcept { tries_.add(); }

  CameraStats stats() const noexcept;
  /// Recent frames per second, by their stamps; 0: not known yet.
  double rate_hz() const noexcept;
  /// "; 2 frames lost; 1 corrupted": the counts that are not 0, for people.
  std::string text() const;

 private:
  struct Counter {  // one writer
    Wide<std::uint64_t> n;
    void add(std::uint64_t more = 1) noexcept { n.store(n.load() + more); }
    std::uint64_t get() const noexcept { return n.load(); }
  };
  Counter frames_, lost_, corrupted_, repeated_, too_large_, unstamped_, reopens_, tries_;
  Wide<std::int64_t> interval_ns_;
  std::uint32_t streams_ = 0;  // begun
  bool first_ = true;          // of its stream: the frame to come
  std::uint32_t last_sequence_ = 0, number_ = 0;
  std::optional<Time> last_stamp_;
};

}  // namespace sinew::hal
