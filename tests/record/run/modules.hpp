#pragma once
// Small modules whose runs are recorded.
#include "../../rt/topic_fixture.hpp"
#include "msg/image.hpp"
#include "rt/module.hpp"

namespace sinew::record {

/// Counts, with random noise and a parameter.
class Numbers final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override {
    d.out("out", out_);
    d.param("gain", gain_);
    d.state(count_);
  }
  void reset() override { count_ = 0; }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    rt::Pair& pair = out_.loan();
    pair.stamp = step.now;
    pair.number = count_++;
    pair.value = {gain_, step.random.uniform(), 0, static_cast<double>(step.dt.count())};
    return rt::StepStatus::ok;
  }

 private:
  rt::Out<rt::Pair> out_;
  double gain_ = 1;
  std::uint32_t count_ = 0;
};

/// Reads the newest message and all messages; publishes what it saw.
class Sums final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override {
    d.in("latest", latest_, {.optional = true});
    d.in("all", all_, {.depth = 4, .overflow = rt::Overflow::drop_newest, .optional = true});
    d.out("out", out_);
  }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    if (!latest_.get()) return rt::StepStatus::stale;
    rt::Pair& pair = out_.loan();
    pair.stamp = step.now;
    pair.number = all_.dropped();
    for (const rt::Pair& p : all_) pair.value[0] += p.value[1];
    pair.value[1] = latest_.get()->value[1];
    pair.value[2] = latest_.updated();
    return rt::StepStatus::ok;
  }

 private:
  rt::In<rt::Pair> latest_;
  rt::InQueue<rt::Pair> all_;
  rt::Out<rt::Pair> out_;
};

/// Pictures of 64 x 48 that move.
class Pictures final : public rt::Module {
 public:
  static constexpr std::uint32_t kBytes = 64 * 48;
  void declare(rt::Declaration& d) override { d.out("image", out_); }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    msg::Image& image = out_.loan();
    if (!image.format_as(msg::PixelFormat::mono8, 64, 48)) return rt::StepStatus::fault;
    image.stamp = step.now;
    image.frame_number = step.number;
    for (std::uint32_t i = 0; i < kBytes; ++i) image.pixels()[i] = static_cast<std::uint8_t>(i + step.number);
    return rt::StepStatus::ok;
  }

 private:
  rt::Out<msg::Image> out_;
};

/// Has pictures as its input.
class Looks final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override { d.in("image", in_); }
  rt::StepStatus step(const rt::Step&) noexcept override {
    return in_.get() ? rt::StepStatus::ok : rt::StepStatus::stale;
  }

 private:
  rt::In<msg::Image> in_;
};

}  // namespace sinew::record
