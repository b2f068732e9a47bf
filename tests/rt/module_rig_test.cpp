#include "rt/exec/module_rig.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "msg/all.hpp"
#include "topic_fixture.hpp"
#include "trap.hpp"

namespace sinew::rt::module_rig_test {
namespace {

using namespace std::chrono_literals;
using hal::Errc;

/// Adds its input to its gain; one output for each number, and the newest as state.
class Adder final : public Module {
 public:
  void declare(Declaration& d) override {
    d.in("state", state_, {.max_age = 10ms});
    d.in("events", events_, {.depth = 4});
    d.in("extra", extra_, {.optional = true});
    d.out("sums", sums_, {.burst = 4});
    d.param("gain", gain_, {.unit = "1", .min = 0.0, .max = 2.0});
    d.param("count_max", count_max_, {.min = 0, .max = 10});
    d.param("label", label_);
  }
  hal::Status configure(Setup& setup) override {
    configured_with = gain_;
    if (label_ != "refuse") return {};
    setup.explain("label says so");
    return hal::Error{Errc::denied, "label"};
  }
  void reset() override { total_ = 0; }
  StepStatus step(const Step& step) noexcept override {
    const Pair* state = state_.fresh(step.now);
    dropped = events_.dropped();
    first_random = step.random.next_u32();
    number = step.number;
    if (!state) {
      sums_.loan().number = 99;  // must never be seen
      return StepStatus::stale;
    }
    for (const Pair& p : events_) {
      total_ += p.number;
      Pair& out = sums_.loan();
      out.number = total_;
      out.value[0] = gain_ * p.number;
      out.stamp = state->stamp;
    }
    return StepStatus::ok;
  }
  std::uint32_t dropped = 0, first_random = 0, number = 0;
  double configured_with = 0;

 private:
  In<Pair> state_, extra_;
  InQueue<Pair> events_;
  Out<Pair> sums_;
  double gain_ = 1.0;
  std::int64_t count_max_ = 3;
  std::string label_;
  std::uint32_t total_ = 0;
};

Pair pair(std::uint32_t number, Time stamp = {}) {
  Pair p;
  p.stamp = stamp;
  p.number = number;
  return p;
}

TEST(ModuleRig, RunsAStepOnRealPortsAndGivesWhatItPublished) {
  Adder adder;
  ModuleRig rig(adder);
  rig.set("gain", 2.0);
  rig.put("state", pair(0, Time{500}));
  for (const std::uint32_t n : {1, 2, 3}) rig.put("events", pair(n));
  EXPECT_EQ(rig.step(Time{1000}, 1ms), StepStatus::ok);
  const auto sums = rig.all<Pair>("sums");
  ASSERT_EQ(sums.size(), 3u);
  EXPECT_EQ(sums[0]->number, 1u);
  EXPECT_EQ(sums[2]->number, 6u);
  EXPECT_EQ(rig.get<Pair>("sums"), sums[2]);
  EXPECT_EQ(rig.get<Pair>("sums")->value[0], 6.0);
  EXPECT_EQ(rig.headers("sums")[0]->sequence, 0xFFFFFF00u);
  EXPECT_EQ(rig.headers("sums")[0]->published, Time{1000});
}

TEST(ModuleRig, AStepWithoutNewsHasAnEmptyQueueAndPublishesNothing) {
  Adder adder;
  ModuleRig rig(adder);
  rig.put("state", pair(0));
  rig.put("events", pair(1));
  EXPECT_EQ(rig.step(Time{1000}, 1ms), StepStatus::ok);
  EXPECT_EQ(rig.step(Time{2000}, 1ms), StepStatus::ok);
  EXPECT_EQ(rig.get<Pair>("sums"), nullptr);
  EXPECT_TRUE(rig.all<Pair>("sums").empty());
}

TEST(ModuleRig, AStaleStepPublishesNothing) {
  Adder adder;
  ModuleRig rig(adder);
  EXPECT_EQ(rig.step(Time{0}, 1ms), StepStatus::stale);
  EXPECT_EQ(rig.get<Pair>("sums"), nullptr);
  rig.put("state", pair(0, Time{0}));
  EXPECT_EQ(rig.step(Time{10'000'000}, 1ms), StepStatus::ok);
  EXPECT_EQ(rig.step(Time{10'000'001}, 1ms), StepStatus::stale) << "older than max_age";
  EXPECT_EQ(rig.stats().stale.value(), 2u);
}

TEST(ModuleRig, AFullQueueDropsAsDeclaredAndCounts) {
  Adder adder;
  ModuleRig rig(adder);
  rig.put("state", pair(0));
  for (std::uint32_t n = 1; n <= 7; ++n) rig.put("events", pair(n));
  EXPECT_EQ(rig.step(Time{1}, 1ms), StepStatus::ok);
  EXPECT_EQ(adder.dropped, 3u);
  EXPECT_EQ(rig.all<Pair>("sums").front()->number, 4u) << "the oldest were dropped";
}

TEST(ModuleRig, ManyStepsGoOverTheSequenceWrap) {
  Adder adder;
  ModuleRig rig(adder);
  rig.put("state", pair(0));
  std::uint32_t expected = 0;
  for (std::uint32_t n = 0; n < 600; ++n) {
    rig.put("events", pair(n));
    ASSERT_EQ(rig.step(Time{n}, 1ns), StepStatus::ok);
    ASSERT_EQ(rig.get<Pair>("sums")->number, expected += n);
  }
}

TEST(ModuleRig, ParametersHaveTheirValuesAtConfigureAndRefuseOthersInWords) {
  Adder adder;
  ModuleRig rig(adder);
  EXPECT_EQ(rig.refusal("gain", 2.5), "a number from 0 to 2");
  EXPECT_EQ(rig.refusal("gain", 1), "");
  EXPECT_EQ(rig.refusal("count_max", 1.5), "an integer from 0 to 10");
  EXPECT_EQ(rig.refusal("label", "x"), "");
  rig.set("gain", 0.25);
  ASSERT_TRUE(rig.configure());
  EXPECT_EQ(adder.configured_with, 0.25);
}

TEST(ModuleRig, AnswersWhatConfigureSays) {
  Adder adder;
  ModuleRig rig(adder);
  rig.set("label", "refuse");
  const auto configured = rig.configure();
  ASSERT_FALSE(configured);
  EXPECT_EQ(configured.error().code, Errc::denied);
  ASSERT_EQ(rig.problems().size(), 1u);
  EXPECT_EQ(rig.problems()[0].allowed, "label says so");
}

TEST(ModuleRig, ResetStartsTheModuleAnew) {
  Adder adder;
  ModuleRig rig(adder);
  rig.put("state", pair(0));
  rig.put("events", pair(5));
  EXPECT_EQ(rig.step(Time{1}, 1ms), StepStatus::ok);
  const std::uint32_t random = adder.first_random;
  EXPECT_EQ(rig.step(Time{2}, 1ms), StepStatus::ok);
  EXPECT_EQ(adder.number, 1u);
  EXPECT_NE(adder.first_random, random);
  rig.reset();
  rig.put("events", pair(7));
  EXPECT_EQ(rig.step(Time{3}, 1ms), StepStatus::ok);
  EXPECT_EQ(adder.number, 0u);
  EXPECT_EQ(adder.first_random, random) << "the same step draws the same numbers";
  EXPECT_EQ(rig.get<Pair>("sums")->number, 7u);
}

TEST(ModuleRig, AnOptionalInputMayStayUnbound) {
  Adder adder;
  ModuleRig rig(adder);
  rig.leave_unbound("extra");
  rig.put("state", pair(0));
  EXPECT_EQ(rig.step(Time{1}, 1ms), StepStatus::ok);
}

class Negative final : public Module {
 public:
  void declare(Declaration& d) override {
    d.in("camera", camera_);
    d.out("negative", negative_);
  }
  StepStatus step(const Step&) noexcept override {
    const msg::Image* from = camera_.get();
    msg::Image& to = negative_.loan();
    if (!from || !to.format_as(from->format, from->width, from->height)) return StepStatus::fault;
    for (std::uint32_t y = 0; y < from->height; ++y)
      for (std::uint32_t x = 0; x < from->stride; ++x) to.row(y)[x] = static_cast<std::uint8_t>(255 - from->row(y)[x]);
    return StepStatus::ok;
  }

 private:
  In<msg::Image> camera_;
  Out<msg::Image> negative_;
};

TEST(ModuleRig, ImagesPassWithTheirPixels) {
  Negative negative;
  ModuleRig rig(negative);
  rig.image_capacity("camera", 6);
  rig.image_capacity("negative", 6);
  msg::ImageBuffer image(msg::PixelFormat::mono8, 3, 2);
  image->row(1)[2] = 200;
  rig.put_image("camera", image);
  EXPECT_EQ(rig.step(Time{1}, 1ms), StepStatus::ok);
  const auto* out = rig.get<msg::Image>("negative");
  ASSERT_NE(out, nullptr);
  EXPECT_EQ(out->row(1)[2], 55);
  EXPECT_EQ(out->row(0)[0], 255);
}

TEST(ModuleRig, AnOutputThatIsTooSmallForTheImageIsSeenByTheModule) {
  Negative negative;
  ModuleRig rig(negative);
  rig.image_capacity("negative", 5);
  rig.put_image("camera", msg::ImageBuffer(msg::PixelFormat::mono8, 3, 2));
  EXPECT_EQ(rig.step(Time{1}, 1ms), StepStatus::fault);
}

class RangeDevice final : public hal::Range {
 public:
  Time ready_at() const noexcept override { return Time{0}; }
  void set_wake(hal::Wake*) noexcept override {}
  hal::Result<bool> read(msg::RangeSample& out) noexcept override {
    if (left == 0) return false;
    out.range_m = left--;
    return true;
  }
  int left = 0;
};

class OneRange final : public hal::Board {
 public:
  hal::Result<hal::Device*> open_sensor(hal::SensorKind kind, std::string_view) override {
    if (kind != hal::SensorKind::range) return none();
    return &device;
  }
  hal::Result<hal::Camera*> camera(std::string_view) override { return none(); }
  hal::Result<hal::Radio*> radio(std::string_view) override { return none(); }
  hal::Result<hal::Actuators*> actuators(std::string_view) override { return none(); }
  RangeDevice device;

 private:
  static hal::Error none() { return {Errc::not_found, "board of the test"}; }
};

class RangeDriver final : public DriverModule {
 public:
  void declare(Declaration& d) override {
    d.raw("raw", raw_, {.burst = 2});
    d.out("nearest", nearest_);
  }
  hal::Status configure(Setup& setup) override {
    auto opened = setup.board().sensor<msg::RangeSample>("range");
    if (!opened) return opened.error();
    device_ = *opened;
    return {};
  }
  void collect(Time) noexcept override {
    while (msg::RangeSample* s = raw_.loan())
      if (const auto got = device_->read(*s); !got || !*got) return raw_.cancel();
  }
  StepStatus step(const Step&) noexcept override {
    if (raw_.empty()) return StepStatus::stale;
    nearest_.loan().range_m = raw_.back().range_m;
    return StepStatus::ok;
  }
  void emit(Time now) noexcept override {
    emitted = nearest_.committed();
    emitted_at = now;
  }
  const msg::RangeSample* emitted = nullptr;
  Time emitted_at{};

 private:
  hal::Range* device_ = nullptr;
  Raw<msg::RangeSample> raw_;
  Out<msg::RangeSample> nearest_;
};

TEST(ModuleRig, ADriverIsCollectedBeforeAndEmittedAfterItsStep) {
  OneRange board;
  board.device.left = 3;
  RangeDriver driver;
  ModuleRig rig(driver, {.board = &board});
  EXPECT_EQ(rig.step(Time{7}, 1ms), StepStatus::ok);
  EXPECT_EQ(rig.all<msg::RangeSample>("raw").size(), 2u) << "bounded by its burst";
  EXPECT_EQ(rig.get<msg::RangeSample>("nearest")->range_m, 2.0);
  EXPECT_EQ(driver.emitted, rig.get<msg::RangeSample>("nearest")) << "the slot itself, no copy";
  EXPECT_EQ(driver.emitted_at, Time{7});
  EXPECT_EQ(rig.step(Time{8}, 1ms), StepStatus::ok);
  EXPECT_EQ(rig.all<msg::RangeSample>("raw").size(), 1u);
  EXPECT_EQ(rig.step(Time{9}, 1ms), StepStatus::stale);
}

TEST(ModuleRig, WithoutABoardThereAreNoDevices) {
  RangeDriver driver;
  ModuleRig rig(driver);
  const auto configured = rig.configure();
  ASSERT_FALSE(configured);
  EXPECT_EQ(configured.error().code, Errc::not_found);
}

class Allocates final : public Module {
 public:
  void declare(Declaration&) override {}
  StepStatus step(const Step&) noexcept override {
    void* volatile p = std::malloc(8);
    std::free(p);
    return StepStatus::ok;
  }
};

TEST(ModuleRigDeathTest, TheTrapIsSetAroundTheStep) {
  if (!sinew::trap::is_set()) GTEST_SKIP() << "no trap in this build";
  Allocates module;
  ModuleRig rig(module, {.name = "greedy"});
  EXPECT_DEATH(static_cast<void>(rig.step(Time{1}, 1ms)), "malloc called inside a step of module 'greedy'");
}

TEST(ModuleRigDeathTest, WrongUseEndsWithAText) {
  Adder adder;
  ModuleRig rig(adder);
  EXPECT_DEATH(rig.put("stat", pair(1)), "module rig: stat: no such port; there are: state events extra sums");
  EXPECT_DEATH(rig.put("state", msg::RangeSample{}), "state: takes Pair, not RangeSample");
  EXPECT_DEATH(rig.put("sums", pair(1)), "sums: is an output");
  EXPECT_DEATH(rig.set("gain", 3.0), "gain: 3: a number from 0 to 2");
  EXPECT_DEATH(rig.set("gian", 1.0), "gian: no such parameter");
  EXPECT_DEATH(static_cast<void>(rig.get<msg::RangeSample>("sums")), "sums: gives Pair, not RangeSample");
  EXPECT_DEATH(static_cast<void>(rig.step(Time{1}, 0ms)), "module: dt is not above 0");
  EXPECT_DEATH(rig.leave_unbound("state"), "state: is no optional input");
  EXPECT_DEATH(rig.image_capacity("state", 1), "state: carries Pair, which has no pixels");
  Negative negative;
  ModuleRig small(negative);
  small.image_capacity("camera", 5);
  EXPECT_DEATH(small.put_image("camera", msg::ImageBuffer(msg::PixelFormat::mono8, 3, 2)),
               "camera: the image does not fit");
}

}  // namespace
}  // namespace sinew::rt::module_rig_test
