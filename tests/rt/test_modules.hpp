#pragma once
// Modules that several tests use.
#include <vector>

#include "rt/module.hpp"
#include "topic_fixture.hpp"

namespace sinew::rt {

/// Publishes its step number, stamped with now.
class Numbers final : public Module {
 public:
  void declare(Declaration& d) override { d.out("out", out_); }
  StepStatus step(const Step& step) noexcept override {
    Pair& p = out_.loan();
    p.stamp = step.now;
    p.number = step.number;
    address = &p;
    return status;
  }
  StepStatus status = StepStatus::ok;
  const Pair* address = nullptr;

 private:
  Out<Pair> out_;
};

/// Passes on the number that it read, and remembers it.
class Relay final : public Module {
 public:
  explicit Relay(bool previous = false) : previous_(previous) { seen.reserve(10'000); }
  void declare(Declaration& d) override {
    d.in("in", in_, {.previous = previous_});
    d.out("out", out_);
  }
  StepStatus step(const Step&) noexcept override {
    address = in_.get();
    if (seen.size() < seen.capacity()) seen.push_back(address ? static_cast<std::int64_t>(address->number) : -1);
    if (!address) return StepStatus::stale;
    Pair& p = out_.loan();
    p.stamp = address->stamp;
    p.number = address->number;
    return StepStatus::ok;
  }
  std::vector<std::int64_t> seen;  // -1: none
  const Pair* address = nullptr;

 private:
  const bool previous_;
  In<Pair> in_;
  Out<Pair> out_;
};

/// Reads a queue and remembers it.
class Logger final : public Module {
 public:
  explicit Logger(QueueOptions options = {}) : options_(options) { seen.reserve(10'000); }
  void declare(Declaration& d) override { d.in("in", in_, options_); }
  StepStatus step(const Step&) noexcept override {
    for (const Pair& p : in_)
      if (seen.size() < seen.capacity()) seen.push_back(p.number);
    dropped += in_.dropped();
    return StepStatus::ok;
  }
  std::vector<std::uint32_t> seen;
  std::uint64_t dropped = 0;

 private:
  const QueueOptions options_;
  InQueue<Pair> in_;
};

/// Two outputs of one number, in one commit.
class Twin final : public Module {
 public:
  void declare(Declaration& d) override {
    d.out("a", a_);
    d.out("b", b_);
  }
  StepStatus step(const Step& step) noexcept override {
    a_.loan().number = step.number;
    b_.loan().number = step.number;
    return step.number % 3 == 2 ? StepStatus::stale : StepStatus::ok;
  }

 private:
  Out<Pair> a_, b_;
};

class TwinReader final : public Module {
 public:
  TwinReader() { a_seen.reserve(10'000), b_seen.reserve(10'000); }
  void declare(Declaration& d) override {
    d.in("a", a_);
    d.in("b", b_);
  }
  StepStatus step(const Step&) noexcept override {
    if (!a_.get() || !b_.get()) return StepStatus::stale;
    a_seen.push_back(a_.get()->number);
    b_seen.push_back(b_.get()->number);
    return StepStatus::ok;
  }
  std::vector<std::uint32_t> a_seen, b_seen;

 private:
  In<Pair> a_, b_;
};

class Dice final : public Module {
 public:
  Dice() { thrown.reserve(1000); }
  void declare(Declaration& d) override { d.out("out", out_); }
  StepStatus step(const Step& step) noexcept override {
    const auto n = step.random.next_u32();
    thrown.push_back(n);
    out_.loan().number = n;
    return StepStatus::ok;
  }
  std::vector<std::uint32_t> thrown;

 private:
  Out<Pair> out_;
};

}  // namespace sinew::rt
