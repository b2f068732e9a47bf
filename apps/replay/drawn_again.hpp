#pragma once
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "hal/linux/process.hpp"
#include "record/run/replay.hpp"

namespace sinew::app {

/// Pixels of a robot's pictures from the scenes of its run, drawn by `sinew-sim --redraw` in a process beside this one,
/// no faster than they are taken.
/// Thread:  owner.
class DrawnAgain final : public record::PictureSource {
 public:
  /// `scenes`: file of sinew-sim --scenes. The topics are those of the graph's camera drivers.
  /// Errors:  null, with `why`: no sinew-sim, the file cannot be read.
  static std::unique_ptr<DrawnAgain> start(const std::string& scenes, const std::string& robot, const rt::Graph& graph,
                                           std::string& why);
  std::span<const std::byte> pixels(std::uint32_t topic, const record::ImageHead& head) override;

 private:
  struct Picture {
    std::uint32_t number = 0;
    std::string bytes{};
  };
  DrawnAgain() = default;
  /// Reads one more picture. False: there is none.
  bool read();

  std::unique_ptr<hal::ChildProcess> child_;
  std::string output_, errors_;
  std::map<std::uint32_t, std::string> device_;  // by topic
  std::map<std::string, std::deque<Picture>, std::less<>> waiting_;
  Picture taken_;
};

}  // namespace sinew::app
