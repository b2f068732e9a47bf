#pragma once
// A small robot of three modules in two threads, one topic that is written from outside, and no devices.
#include <algorithm>
#include <string>

#include "msg/image.hpp"
#include "msg/sensors.hpp"
#include "rt/graph.hpp"

namespace sinew::tap {

using namespace std::chrono_literals;

/// Counts its steps: range_m is the number, times the gain.
class Counter final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override {
    d.out("range", out_);
    d.param("gain", gain_, {.unit = "1", .min = 0, .max = 10, .doc = "of the count"});
    d.param("offset", offset_, {.unit = "m", .min = -5, .max = 5});
    d.param("active", active_);
    d.param("label", label_);
  }
  void reset() override { count_ = 0; }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    msg::RangeSample& r = out_.loan();
    r.stamp = step.now;
    r.range_m = gain_ * static_cast<double>(++count_) + static_cast<double>(offset_);
    return rt::StepStatus::ok;
  }

 private:
  rt::Out<msg::RangeSample> out_;
  double gain_ = 1;
  std::int64_t offset_ = 0, count_ = 0;
  bool active_ = true;
  std::string label_ = "a \"label\"";
};

/// Every pixel of a frame is the frame's number: a torn frame shows.
class Eye final : public rt::Module {
 public:
  static constexpr std::uint32_t kWidth = 160, kHeight = 100;
  void declare(rt::Declaration& d) override {
    d.in("range", in_);
    d.out("image", out_);
  }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    msg::Image& image = out_.loan();
    if (!in_.get() || !image.format_as(msg::PixelFormat::mono8, kWidth, kHeight)) return rt::StepStatus::stale;
    image.stamp = step.now;
    image.frame_number = ++frame_;
    std::fill_n(image.pixels(), kWidth * kHeight, static_cast<std::uint8_t>(frame_));
    return rt::StepStatus::ok;
  }

 private:
  rt::In<msg::RangeSample> in_;
  rt::Out<msg::Image> out_;
  std::uint32_t frame_ = 0;
};

class Follower final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override {
    d.in("range", in_, {.depth = 16});
    d.out("baro", out_);
    d.param("height_m", height_m_, {.unit = "m"});
  }
  hal::Status configure(rt::Setup& setup) override {
    return setup.narrow("height_m", {-100, 8000, {}, "what the barometer measures"});
  }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    if (in_.empty()) return rt::StepStatus::stale;
    if (in_.dropped() > 0 || in_.back().stamp < last_) return rt::StepStatus::fault;
    last_ = in_.back().stamp;
    msg::BaroSample& b = out_.loan();
    b.stamp = step.now;
    b.pressure_pa = in_.back().range_m + height_m_ + step.random.uniform();
    return rt::StepStatus::ok;
  }

 private:
  rt::InQueue<msg::RangeSample> in_;
  rt::Out<msg::BaroSample> out_;
  double height_m_ = 0;
  rt::Time last_;
};

struct GraphOptions {
  std::string name = "robot";
  hal::Duration period = 2ms, eye_period = 5ms;
  std::uint32_t image_history = 0;  // 0: the default
  int eyes = 1;                     // eye, eye2, eye3, ...
  int priority = 0;                 // of the fast thread; 0: any, for runs without priorities
  bool camera = false;              // a second external topic, outside.image: kWidth x kHeight pixels, yuyv
  bool wake_outsiders = false;      // counter.range
};

inline rt::ModuleTypes robot_types() {
  rt::ModuleTypes t;
  t.add<Counter>("test::Counter");
  t.add<Eye>("test::Eye");
  t.add<Follower>("test::Follower");
  return t;
}

inline rt::GraphSpec robot_spec(const GraphOptions& o) {
  const auto module = [](const char* name, const char* type) {
    rt::ModuleSpec m;
    m.name = name, m.type = type;
    m.exec = {rt::ExecModel::Kind::constant, 100us, {}, 1.0, {}};
    return m;
  };
  rt::GraphSpec g;
  g.robot = o.name;
  g.modules = {module("counter", "test::Counter"), module("follower", "test::Follower"), module("eye", "test::Eye")};
  g.modules[1].in["range"] = {"counter.range", 0};
  g.modules[2].in["range"] = {"counter.range", 0};
  rt::ThreadSpec fast, slow;
  fast.name = "fast", fast.period = o.period, fast.priority = o.priority > 0 ? o.priority : 80;
  fast.order = {{"counter", 0}, {"follower", 0}};
  slow.name = "slow", slow.period = o.eye_period, slow.priority = o.priority > 0 ? o.priority - 1 : 20;
  slow.order = {{"eye", 0}};
  for (int i = 1; i <= o.eyes; ++i) {
    const std::string name = i == 1 ? "eye" : "eye" + std::to_string(i);
    rt::TopicSpec image;
    image.name = name + ".image", image.image_bytes = Eye::kWidth * Eye::kHeight, image.history = o.image_history;
    g.topics.push_back(std::move(image));
    if (i == 1) continue;
    g.modules.push_back(module(name.c_str(), "test::Eye"));
    g.modules.back().in["range"] = {"counter.range", 0};
    slow.order.push_back({name, 0});
  }
  g.threads = {fast, slow};
  rt::TopicSpec wind;
  wind.name = "operator.range";
  wind.external.emplace();
  wind.external->type = "RangeSample", wind.external->thread = "slow";
  g.topics.push_back(wind);
  if (o.camera) {
    rt::TopicSpec camera;
    camera.name = "outside.image", camera.image_bytes = 2 * Eye::kWidth * Eye::kHeight;
    camera.image_pixels = Eye::kWidth * Eye::kHeight;
    camera.external.emplace();
    camera.external->type = "Image", camera.external->thread = "slow";
    g.topics.push_back(camera);
  }
  if (o.wake_outsiders) {
    rt::TopicSpec range;
    range.name = "counter.range", range.wake_outsiders = true;
    g.topics.push_back(range);
  }
  return g;
}

}  // namespace sinew::tap
