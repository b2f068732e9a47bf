#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace sinew::app {

/// What happened in a run, for the time line at its end.
/// Thread:  owner.
class Story {
 public:
  /// How much an event says about the outcome: what says less is left out first.
  enum class Weight : std::uint8_t { detail, phase, result };
  struct Event {
    double at_s = 0;  // since the first cycle
    Weight weight = Weight::detail;
    std::string text{};
  };

  void add(double at_s, Weight weight, std::string text);
  /// All that is kept, in the order of time: of a run with more than kMost events those in the middle are left out.
  std::vector<Event> events() const;
  /// "    8.5 s  climbing", in the order of time. Where there are more than `most` lines, the events of the least
  /// weight are left out, from the middle of the run first, and the last line says how many.
  std::vector<std::string> lines(std::size_t most) const;

  static constexpr std::size_t kMost = 1000;

 private:
  std::vector<Event> events_;
  std::size_t left_out_ = 0;  // beyond kMost
};

}  // namespace sinew::app
