#include "apps/live/topic_rate.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace sinew::app {
namespace {

// The ceil(q * n)-th smallest value, as in the runtime's histograms.
msg::Duration quantile(std::vector<std::int64_t> values, double q) {
  if (values.empty()) return {};
  const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(values.size())));
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::max<std::size_t>(rank, 1) - 1);
  std::nth_element(values.begin(), at, values.end());
  return msg::Duration{*at};
}

}  // namespace

void RateMeter::add(std::uint32_t sequence, msg::Time published) {
  if (messages_++ == 0) {
    first_ = published;
  } else {
    const std::uint32_t gap = sequence - last_sequence_;
    if (gap == 1)
      intervals_ns_.push_back((published - last_).count());
    else
      lost_ += gap - 1;
  }
  last_sequence_ = sequence;
  last_ = published;
}

TopicRate RateMeter::result() const {
  TopicRate rate;
  rate.messages = messages_;
  rate.lost = lost_;
  if (messages_ > 1 && last_ > first_)
    rate.rate_hz = static_cast<double>(messages_ + lost_ - 1) / msg::seconds(last_ - first_);
  rate.interval_p50 = quantile(intervals_ns_, 0.5);
  rate.interval_max = quantile(intervals_ns_, 1);
  std::vector<std::int64_t> off;
  for (const std::int64_t i : intervals_ns_) off.push_back(std::abs(i - rate.interval_p50.count()));
  rate.jitter_p50 = quantile(off, 0.5);
  rate.jitter_p99 = quantile(off, 0.99);
  return rate;
}

}  // namespace sinew::app
