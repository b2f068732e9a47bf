#include "record/run/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "msg/text.hpp"

namespace sinew::record {
namespace {

constexpr std::size_t kStretches = 600;

using What = Quantity::What;

bool is_output_of(const rt::Graph& graph, const rt::GraphTopic& topic, const std::vector<std::string>& modules) {
  if (topic.writer == rt::kNone) return false;
  const rt::GraphModule& m = graph.modules()[topic.writer];
  if (m.declaration.ports[topic.port].kind != rt::Declaration::PortKind::output) return false;
  return modules.empty() || std::find(modules.begin(), modules.end(), m.spec.name) != modules.end();
}

/// Standard deviation of values that come one by one.
class Spread {
 public:
  void add(double value) {
    const double before = value - mean_;
    mean_ += before / static_cast<double>(++count_);
    squares_ += before * (value - mean_);
  }
  double value() const { return count_ == 0 ? 0 : std::sqrt(squares_ / static_cast<double>(count_)); }

 private:
  std::uint64_t count_ = 0;
  double mean_ = 0, squares_ = 0;
};

}  // namespace

void Deviation::add(double difference, rt::Time at) {
  ++count;
  sum_of_squares += difference * difference;
  if (std::abs(difference) <= max) return;
  max = std::abs(difference);
  max_at = at;
}

double Deviation::rms() const { return count == 0 ? 0 : std::sqrt(sum_of_squares / static_cast<double>(count)); }

Curve::Curve(const RecordedTime& record)
    : start_(record.start),
      per_stretch_s_(std::max(1e-9, msg::seconds(record.length) / kStretches)),
      stretches_(kStretches) {}

void Curve::add(rt::Time at, double value) {
  const double place = msg::seconds(at - start_) / per_stretch_s_;
  Stretch& s = stretches_[static_cast<std::size_t>(std::clamp(place, 0.0, kStretches - 1.0))];
  if (!std::isfinite(value)) return;
  if (!s.any || value < s.low) s.low = value, s.low_at = at;
  if (!s.any || value > s.high) s.high = value, s.high_at = at;
  s.any = true;
}

std::vector<std::pair<double, double>> Curve::points() const {
  std::vector<std::pair<double, double>> all;
  for (const Stretch& s : stretches_) {
    if (!s.any) continue;
    const std::pair low(msg::seconds(s.low_at - start_), s.low), high(msg::seconds(s.high_at - start_), s.high);
    all.push_back(std::min(low, high));
    if (s.low_at != s.high_at) all.push_back(std::max(low, high));
  }
  return all;
}

double ComparedQuantity::relative() const {
  if (now.rms() == 0) return one_sided == 0 ? 0 : std::numeric_limits<double>::infinity();
  return spread > 0 ? now.rms() / spread : std::numeric_limits<double>::infinity();
}

struct Comparison::One {
  Quantity what;
  std::optional<Quantity> true_one;  // where the truth has it
  ComparedQuantity result;
  Spread spread;         // of numbers
  Deviation from_first;  // of angles
  std::optional<Curve> recorded, now, truth;

  bool is_number() const { return what.what == What::number; }
};

struct Comparison::Topic {
  std::vector<One> ones;
  std::size_t bytes = 0;
  std::vector<std::byte> first;  // of the record
};

void Comparison::make_curves(One& one, const ComparisonOptions& options) {
  const Curve none(options.record);
  one.now = none;
  if (one.is_number() || one.true_one) one.recorded = none;
  if (one.is_number() && one.true_one) one.truth = none;
}

Comparison::Comparison(const rt::Graph& graph, const ComparisonOptions& options) : options_(options) {
  if (options.from_s) from_ = options.record.after_start(*options.from_s);
  if (options.until_s) until_ = options.record.after_start(*options.until_s);
  std::vector<Quantity> true_ones;
  if (options.truth) {
    true_ones = quantities(options.truth->type());
    truth_.resize(options.truth->type().size);
  }
  const auto true_one = [&](const Quantity& q) -> std::optional<Quantity> {
    if (q.what == What::number && !msg::is_float(q.kind)) return std::nullopt;
    for (const Quantity& t : true_ones)
      if (t.path == q.path && t.what == q.what && (t.what != What::number || msg::is_float(t.kind))) return t;
    return std::nullopt;
  };
  topics_.resize(graph.topics().size());
  for (std::size_t t = 0; t < topics_.size(); ++t) {
    const rt::GraphTopic& topic = graph.topics()[t];
    if (!is_output_of(graph, topic, options.modules)) continue;
    topics_[t].bytes = topic.type->size;
    for (Quantity& q : quantities(*topic.type)) {
      const std::string name = topic.name + "." + q.path;
      const auto& some = options.quantities;
      if (!some.empty() && std::none_of(some.begin(), some.end(), [&](const auto& s) { return means(s, name); }))
        continue;
      One one;
      one.true_one = true_one(q);
      one.result.name = name;
      one.result.unit = q.unit;
      one.result.has_truth = one.true_one.has_value();
      one.what = std::move(q);
      if (options.curves) make_curves(one, options);
      topics_[t].ones.push_back(std::move(one));
    }
  }
}

Comparison::~Comparison() = default;

void Comparison::compared(const ReplayedMessage& message) {
  Topic& topic = topics_[message.topic];
  if (topic.ones.empty() || message.now < from_ || message.now > until_) return;
  const bool is_true = options_.truth && options_.truth->at(message.again.stamp, truth_.data());
  if (topic.first.empty()) {
    const auto* first = static_cast<const std::byte*>(message.recorded.message());
    topic.first.assign(first, first + topic.bytes);
  }
  for (One& one : topic.ones) {
    compare(one, topic, message);
    if (is_true && one.true_one) compare_with_truth(one, message, truth_.data());
  }
}

void Comparison::compare(One& one, const Topic& topic, const ReplayedMessage& message) {
  const void *recorded = message.recorded.message(), *again = message.again.message();
  const double d = difference(one.what, recorded, one.what, again);
  if (!one.is_number()) {
    const double way = difference(one.what, topic.first.data(), one.what, recorded);
    if (std::isfinite(d))
      one.result.now.add(d, message.now);
    else if (std::isfinite(way))
      ++one.result.not_a_number;
    if (std::isfinite(way)) one.from_first.add(way, message.now);
    if (one.now && !one.true_one) one.now->add(message.now, d);
    return;
  }
  const double was = one.what.value(recorded), is = one.what.value(again);
  if (std::isfinite(d))
    one.result.now.add(d, message.now);
  else if (was != is && !(std::isnan(was) && std::isnan(is)))
    ++one.result.one_sided, one.result.not_a_number += std::isfinite(was);
  if (std::isfinite(was)) one.spread.add(was);
  if (one.recorded) one.recorded->add(message.now, was);
  if (one.now) one.now->add(message.now, is);
}

void Comparison::compare_with_truth(One& one, const ReplayedMessage& message, const void* truth) {
  const double was = difference(*one.true_one, truth, one.what, message.recorded.message()),
               is = difference(*one.true_one, truth, one.what, message.again.message());
  if (std::isfinite(was)) one.result.recorded_from_truth.add(was, message.now);
  if (std::isfinite(is)) one.result.now_from_truth.add(is, message.now);
  if (!one.now) return;
  if (one.is_number()) return one.truth->add(message.now, one.true_one->value(truth));
  one.recorded->add(message.now, was);
  one.now->add(message.now, is);
}

std::vector<ComparedQuantity> Comparison::result() const {
  std::vector<ComparedQuantity> all;
  for (const Topic& topic : topics_)
    for (const One& one : topic.ones) {
      ComparedQuantity& q = all.emplace_back(one.result);
      q.spread = one.is_number() ? one.spread.value() : one.from_first.rms();
      const auto keep = [&q](const char* name, const std::optional<Curve>& curve) {
        if (curve) q.curves.emplace_back(name, *curve);
      };
      const bool between = !one.is_number();
      keep(between ? "recorded from truth" : "recorded", one.recorded);
      keep(!between ? "now" : one.true_one ? "now from truth" : "now from recorded", one.now);
      keep("truth", one.truth);
    }
  return all;
}

std::vector<std::string> quantity_names(const rt::Graph& graph, const std::vector<std::string>& modules) {
  std::vector<std::string> names;
  for (const rt::GraphTopic& topic : graph.topics())
    if (is_output_of(graph, topic, modules))
      for (const Quantity& q : quantities(*topic.type)) names.push_back(topic.name + "." + q.path);
  return names;
}

}  // namespace sinew::record
