#pragma once
// A module around a real one that breaks its outputs from some instant on. It replaces the real type in ModuleTypes, so
// no part of the product knows of it.
#include <bit>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "rt/module_types.hpp"

namespace sinew::app::test {

enum class Fault {
  disabled,      // not stepped any more, from outside
  stalled,       // the step that begins then never ends
  failing,       // every step is a fault
  silent,        // one output stays unpublished
  not_a_number,  // every real number of one output is NaN
  out_of_range,  // ... 1e30
  too_fast,      // ... swings between 0 and 1 in every step; of a driver: as many samples at once as it may
  bit_flipped,   // one bit of one number, another one in each step; of an image: of a pixel
};
inline constexpr Fault kModuleFaults[] = {Fault::disabled, Fault::stalled, Fault::failing};
inline constexpr Fault kOutputFaults[] = {Fault::silent, Fault::not_a_number, Fault::out_of_range, Fault::too_fast,
                                          Fault::bit_flipped};

struct PoisonPlan {
  Fault fault = Fault::silent;
  std::string output{};  // of the module; empty: the fault is the module's
  rt::Time from{}, until{INT64_MAX};
};

class Poisoner final : public rt::DriverModule {
 public:
  Poisoner(std::unique_ptr<rt::Module> inner, const PoisonPlan& plan)
      : inner_(std::move(inner)), driver_(dynamic_cast<rt::DriverModule*>(inner_.get())), plan_(plan) {}

  void declare(rt::Declaration& d) override {
    inner_->declare(d);
    for (const auto& p : d.ports)
      if (p.output && p.name == plan_.output) target_ = p;
    if (target_.type) last_.resize(target_.type->size);
  }
  hal::Status configure(rt::Setup& setup) override { return inner_->configure(setup); }
  void reset() override { inner_->reset(); }
  hal::Device* device() override { return driver_ ? driver_->device() : nullptr; }
  void emit(rt::Time now) noexcept override {
    if (driver_) driver_->emit(now);
  }
  void collect(rt::Time now) noexcept override {
    const bool raw = target_.output && target_.input;
    if (!driver_ || (raw && acts(now) && plan_.fault == Fault::silent)) return;
    driver_->collect(now);
    if (raw && acts(now) && plan_.fault == Fault::too_fast) flood(now);
  }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    const bool acting = acts(step.now);
    if (acting && plan_.fault == Fault::failing) return rt::StepStatus::fault;
    if (acting && target_.input) spoil_raw(step);
    if (target_.input && target_.input->size() && !target_.type->has_bulk())
      std::memcpy(last_.data(), target_.input->header(0)->message(), last_.size());
    const rt::StepStatus status = inner_->step(step);
    if (acting && target_.output && !target_.input && status == rt::StepStatus::ok) spoil_output(step);
    return status;
  }

 private:
  /// The protected part of an output, for a module with types that are only known at run time.
  struct Access : rt::OutputBase {
    static void cancel_loan(rt::OutputBase& o) { (o.*&Access::cancel_newest)(); }
    static void* reclaim(rt::OutputBase& o) { return (o.*&Access::claim)(); }
    static void* claim_more(rt::OutputBase& o) { return (o.*&Access::try_claim)(); }
  };

  bool acts(rt::Time now) const { return now >= plan_.from && now < plan_.until; }

  /// Whether the module has written it in this step: what is left of the burst tells.
  bool has_loaned() noexcept {
    std::uint32_t left = 0;
    while (Access::claim_more(*target_.output)) ++left;
    for (std::uint32_t i = 0; i < left; ++i) Access::cancel_loan(*target_.output);
    return left < target_.burst;
  }
  /// A cancelled loan is the next to be claimed, with its content.
  void spoil_output(const rt::Step& step) noexcept {
    if (!has_loaned()) return;
    Access::cancel_loan(*target_.output);
    if (plan_.fault == Fault::silent) return;
    spoil(Access::reclaim(*target_.output), step);
  }
  /// Breaks what collect() committed a moment ago; in virtual time no reader has looked at it yet.
  void spoil_raw(const rt::Step& step) noexcept {
    if (plan_.fault == Fault::too_fast) return;
    for (std::size_t i = 0; i < target_.input->size(); ++i)
      spoil(const_cast<void*>(target_.input->header(i)->message()), step);
  }
  /// Publishes the last sample as often as there is room, each copy a nanosecond after the one before.
  void flood(rt::Time now) noexcept {
    if (target_.type->has_bulk()) return;
    for (std::int64_t i = 0; void* m = Access::claim_more(*target_.output); ++i) {
      std::memcpy(m, last_.data(), last_.size());
      const rt::Time stamp{now.ns + i};
      std::memcpy(m, &stamp, sizeof stamp);
    }
  }
  void spoil(void* message, const rt::Step& step) noexcept {
    if (target_.type->has_bulk()) return spoil_image(*static_cast<msg::Image*>(message), step);
    const std::span<const msg::FloatRun> runs = target_.type->floats;
    if (plan_.fault == Fault::bit_flipped) {
      const auto& run = runs[static_cast<std::size_t>(step.random.next_u64() % runs.size())];
      const std::uint32_t size = run.is_f64 ? 8 : 4;
      auto* bytes = static_cast<std::uint8_t*>(message) + run.offset;
      bytes[step.random.next_u64() % (run.count * size)] ^= static_cast<std::uint8_t>(1u << step.random.next_u64() % 8);
      return;
    }
    const double v = plan_.fault == Fault::not_a_number   ? math::kNan
                     : plan_.fault == Fault::out_of_range ? 1e30
                                                          : step.number % 2;
    for (const auto& run : runs)
      for (std::uint32_t i = 0; i < run.count; ++i)
        write(static_cast<std::byte*>(message) + run.offset, run.is_f64, i, v);
  }
  void spoil_image(msg::Image& image, const rt::Step& step) noexcept {
    if (plan_.fault == Fault::bit_flipped) {
      image.pixels()[step.random.next_u64() % image.bulk_used()] ^= 0x40;
    } else if (plan_.fault == Fault::out_of_range) {
      image.width = image.height = image.stride = 0xFFFFFFFF;
      image.format = static_cast<msg::PixelFormat>(77);
    }
  }
  static void write(std::byte* run, bool is_f64, std::uint32_t i, double v) {
    const auto f = static_cast<float>(v);
    if (is_f64)
      std::memcpy(run + 8 * i, &v, 8);
    else
      std::memcpy(run + 4 * i, &f, 4);
  }

  std::unique_ptr<rt::Module> inner_;
  rt::DriverModule* driver_;
  PoisonPlan plan_;
  rt::Declaration::Port target_{};
  std::vector<std::byte> last_;  // message of a driver
};

}  // namespace sinew::app::test
