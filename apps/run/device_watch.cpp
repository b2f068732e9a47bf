#include "apps/run/device_watch.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace sinew::app {

DeviceWatch::DeviceWatch(Ask ask, std::vector<std::string> told) : ask_(std::move(ask)), told_(std::move(told)) {}

std::vector<std::string> DeviceWatch::look(hal::Time now) {
  std::vector<std::string> news;
  for (const std::string& text : ask_()) {
    auto c = std::find_if(complaints_.begin(), complaints_.end(), [&](const Complaint& k) { return k.text == text; });
    const bool known = c != complaints_.end();
    if (!known) c = complaints_.insert(complaints_.end(), {text, now, now, false, 0, {}});
    if (!c->lasts) {
      c->lasts = true, c->came = now, ++c->times;
      if (known || std::find(told_.begin(), told_.end(), text) == told_.end()) news.push_back(text);
    }
    c->seen = now;
  }
  for (Complaint& c : complaints_) {
    if (!c.lasts || c.seen == now || now - c.seen < kCalm) continue;
    c.lasts = false, c.length += c.seen - c.came;
    news.push_back(fmt::format("over after {:.1f} s: {}", msg::seconds(c.seen - c.came), c.text));
  }
  return news;
}

std::vector<std::string> DeviceWatch::now() const {
  std::vector<std::string> texts;
  for (const Complaint& c : complaints_)
    if (c.lasts) texts.push_back(c.text);
  return texts;
}

std::vector<std::string> DeviceWatch::all() const {
  std::vector<std::string> texts;
  for (const Complaint& c : complaints_) {
    const hal::Duration length = c.length + (c.lasts ? c.seen - c.came : hal::Duration{0});
    texts.push_back(fmt::format("{} ({}{:.1f} s{})", c.text, c.times > 1 ? fmt::format("{} times, ", c.times) : "",
                                msg::seconds(length), c.lasts ? ", to the end" : ""));
  }
  return texts;
}

}  // namespace sinew::app
