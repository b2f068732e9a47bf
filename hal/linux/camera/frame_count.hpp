#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "hal/clock.hpp"
#include "hal/wide.hpp"

namespace sinew::hal {

/// What has happened to the frames of a camera since it was opened.
struct CameraStats {
  std::uint64_t frames = 0;     // handed on
  std::uint64_t lost = 0;       // missing between two sequence numbers of the driver
  std::uint64_t corrupted = 0;  // marked as faulty by the driver, or too short
  std::uint64_t repeated = 0;   // no newer than the one before
  std::uint64_t too_large = 0;  // did not fit the topic's capacity
  std::uint64_t unstamped = 0;  // handed on with the time of reading: the driver gave no stamp, or one of the future
  std::uint64_t reopens = 0;    // streams begun anew
  std::uint64_t tries = 0;      // to open it again since it was last there
};

/// The book that a camera keeps of its frames: which number each gets, which are missing, how often they come.
/// Thread:  one writes (the reader; between two streams whoever begins the next, who also calls reopened()), any asks.
/// RT: yes, but for text().
class FrameCount {
 public:
  /// A frame as the driver delivered it. False: no newer than the last one, not to be handed on.
  /// `stamp`: none when the driver gives none.
  bool arrived(std::uint32_t sequence, std::optional<Time> stamp) noexcept;
  /// The number of the frame that arrived last: the driver's, and going on from there in the streams that follow.
  std::uint32_t number() const noexcept { return number_; }
  void handed_on() noexcept { frames_.add(); }
  void corrupted() noexcept { corrupted_.add(); }
  void too_large() noexcept { too_large_.add(); }
  void unstamped() noexcept { unstamped_.add(); }
  /// A stream begins. True: not the first one, so that the next frame's number leaves a gap, and reopened() is to be
  /// called once the reader can have frames: who sees the count of reopenings rise can read.
  [[nodiscard]] bool stream_begins() noexcept;
  void reopened() noexcept { reopens_.add(); }
  void tried() noexcept { tries_.add(); }

  CameraStats stats() const noexcept;
  /// Frames a second by their stamps, of late; 0: not known yet.
  double rate_hz() const noexcept;
  /// "; 2 frames lost; 1 corrupted": what is not 0, for people.
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
