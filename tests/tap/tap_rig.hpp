#pragma once
// A small robot of three modules in two threads, with its socket: in real time at ordinary priority, or in virtual
// time.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "hal/linux/os.hpp"
#include "msg/image.hpp"
#include "msg/sensors.hpp"
#include "rt/discrete_executor.hpp"
#include "rt/real_time_executor.hpp"
#include "tap/client.hpp"
#include "tap/server.hpp"

namespace sinew::tap {

using namespace std::chrono_literals;
using Json = nlohmann::json;

/// A run dir of this program's own, removed at its end.
class OwnRunDir {
 public:
  OwnRunDir() {
    std::string pattern = (std::filesystem::temp_directory_path() / "sinew-tap-XXXXXX").string();
    path_ = ::mkdtemp(pattern.data());
    ::setenv("SINEW_RUN_DIR", path_.c_str(), 1);
  }
  ~OwnRunDir() { std::filesystem::remove_all(path_); }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

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
  rt::Status step(const rt::Step& step) noexcept override {
    msg::RangeSample& r = out_.loan();
    r.stamp = step.now;
    r.range_m = gain_ * static_cast<double>(++count_) + static_cast<double>(offset_);
    return rt::Status::ok;
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
  rt::Status step(const rt::Step& step) noexcept override {
    msg::Image& image = out_.loan();
    if (!in_.get() || !image.format_as(msg::PixelFormat::mono8, kWidth, kHeight)) return rt::Status::stale;
    image.stamp = step.now;
    image.frame_number = ++frame_;
    std::fill_n(image.pixels(), kWidth * kHeight, static_cast<std::uint8_t>(frame_));
    return rt::Status::ok;
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
  rt::Status step(const rt::Step& step) noexcept override {
    if (in_.empty()) return rt::Status::stale;
    msg::BaroSample& b = out_.loan();
    b.stamp = step.now;
    b.pressure_pa = in_.back().range_m + height_m_ + step.random.uniform();
    return rt::Status::ok;
  }

 private:
  rt::InQueue<msg::RangeSample> in_;
  rt::Out<msg::BaroSample> out_;
  double height_m_ = 0;
};

struct RobotOptions {
  std::string name = "robot";
  bool shared_memory = true;
  std::uint32_t first_sequence = 0xFFFFFF00;
  hal::Duration period = 2ms, eye_period = 5ms;
  int priority = 0;  // of the fast thread; 0: ordinary for all
  ServerOptions server{};
};

class Robot {
 public:
  explicit Robot(const RobotOptions& options = {}) : options_(options), graph(spec(options), types()) {
    for (const auto& p : graph.check({.virtual_time = true})) ADD_FAILURE() << rt::to_string(p, "robot");
    rt::ConfigureOptions configure;
    configure.os = options.shared_memory ? &os : nullptr;
    configure.first_sequence = options.first_sequence;
    if (!graph.configure(board_, configure)) ADD_FAILURE() << "configure";
  }
  ~Robot() {
    server.reset();
    if (real) real->stop();
  }

  void start() {
    rt::RealTimeOptions o;
    o.lock_memory = false;
    o.fixed_priority = options_.priority > 0;
    real = std::make_unique<rt::RealTimeExecutor>(graph, os, o);
    ASSERT_TRUE(real->start());
    open(real->runner());
  }
  /// Virtual time, as far as it is asked to run().
  void prepare(rt::Duration duration) {
    grants_ = std::make_unique<hal::FixedGrant>(hal::Time{} + duration);
    rt::DiscreteOptions o;
    o.duration = duration;
    o.hash_topics = true;
    discrete = std::make_unique<rt::DiscreteExecutor>(graph, clock_, *grants_, o);
    open(discrete->runner());
  }
  void open(rt::Runner& runner) {
    std::string why;
    auto taken = Name::take(options_.name, why);
    ASSERT_TRUE(taken) << why;
    name = std::move(*taken);
    auto opened = Server::open(*name, graph, runner, os, options_.server);
    ASSERT_TRUE(opened) << opened.error().where;
    server = std::move(*opened);
  }
  std::unique_ptr<Client> client() {
    std::string why;
    auto c = Client::connect(options_.name, why);
    if (!c) ADD_FAILURE() << why;
    return c ? std::move(*c) : nullptr;
  }

 private:
  RobotOptions options_;

 public:
  hal::Os& os = hal::linux_os();
  rt::Graph graph;
  std::unique_ptr<rt::RealTimeExecutor> real;
  std::unique_ptr<rt::DiscreteExecutor> discrete;
  std::unique_ptr<Name> name;
  std::unique_ptr<Server> server;

 private:
  static rt::ModuleTypes types() {
    rt::ModuleTypes t;
    t.add<Counter>("test::Counter");
    t.add<Eye>("test::Eye");
    t.add<Follower>("test::Follower");
    return t;
  }
  static rt::ModuleSpec module(const char* name, const char* type) {
    rt::ModuleSpec m;
    m.name = name, m.type = type;
    m.exec = {rt::ExecModel::Kind::constant, 100us, {}, 1.0};
    return m;
  }
  static rt::GraphSpec spec(const RobotOptions& o) {
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
    g.threads = {fast, slow};
    rt::TopicSpec image;
    image.name = "eye.image", image.image_bytes = Eye::kWidth * Eye::kHeight;
    g.topics = {image};
    return g;
  }

  hal::EmptyBoard board_;
  hal::ManualClock clock_;
  std::unique_ptr<hal::GrantSource> grants_;
};

inline Json ask(Client& client, std::string_view name, const Json& arguments = Json::object()) {
  const auto reply = client.request(name, arguments.is_object() ? arguments.dump() : "{}");
  if (!reply) return {{"failed", hal::to_string(reply.error().code)}};
  return Json::parse(*reply, nullptr, false);
}

}  // namespace sinew::tap
