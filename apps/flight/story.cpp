#include "apps/flight/story.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace sinew::app {
namespace {

/// Leaves at most `most` of these events, which are in the order of time.
void thin(std::vector<Story::Event>& events, std::size_t most) {
  using Weight = Story::Weight;
  for (const Weight weight : {Weight::detail, Weight::phase, Weight::result}) {
    const auto is = [&](const Story::Event& e) { return e.weight == weight; };
    const auto there = static_cast<std::size_t>(std::count_if(events.begin(), events.end(), is));
    if (events.size() <= most) return;
    const std::size_t goes = std::min(there, events.size() - most), first = (there - goes + 1) / 2;
    std::size_t nth = 0;
    std::erase_if(events, [&](const Story::Event& e) {
      const std::size_t n = is(e) ? nth++ : there;
      return n >= first && n < first + goes;
    });
  }
}

}  // namespace

void Story::add(double at_s, Weight weight, std::string text) {
  events_.push_back({at_s, weight, std::move(text)});
  if (events_.size() <= kMost) return;
  events_ = events();
  thin(events_, kMost / 2);
  left_out_ += kMost + 1 - events_.size();
}

std::vector<Story::Event> Story::events() const {
  std::vector<Event> all = events_;
  std::stable_sort(all.begin(), all.end(), [](const Event& a, const Event& b) { return a.at_s < b.at_s; });
  return all;
}

std::vector<std::string> Story::lines(std::size_t most) const {
  std::vector<Event> shown = events();
  std::size_t left_out = left_out_;
  if (left_out > 0 || shown.size() > most) {
    const std::size_t there = shown.size();
    thin(shown, most - 1);
    left_out += there - shown.size();
  }
  std::vector<std::string> lines;
  for (const Event& e : shown) lines.push_back(fmt::format("{:7.1f} s  {}", e.at_s, e.text));
  if (left_out > 0) lines.push_back(fmt::format("{:>9}  {} more between them: --verbose", "", left_out));
  return lines;
}

}  // namespace sinew::app
