#pragma once
#include <vector>

#include "rt/module.hpp"

namespace sinew::app {

/// Keeps all messages of one topic for the report at the end of a run. Belongs into a thread of ordinary priority.
/// Thread:  executor; messages() once the run has ended.
/// RT:      yes: room is made in configure().
/// Errors:  none; what does not fit any more is counted.
template <msg::Described M>
class RunLog final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override {
    d.in("log", in_, {.depth = 64});
    d.param("capacity", capacity_, {.min = 1, .max = 10e6, .doc = "messages kept"});
  }
  hal::Status configure(rt::Setup&) override {
    kept_.reserve(static_cast<std::size_t>(capacity_));
    return {};
  }
  rt::StepStatus step(const rt::Step&) noexcept override {
    lost_ += in_.dropped();
    for (const M& m : in_) {
      if (kept_.size() < kept_.capacity())
        kept_.push_back(m);
      else
        ++lost_;
    }
    return rt::StepStatus::ok;
  }

  const std::vector<M>& messages() const { return kept_; }
  std::uint64_t lost() const { return lost_; }

 private:
  rt::InQueue<M> in_;
  std::int64_t capacity_ = 100'000;
  std::vector<M> kept_;
  std::uint64_t lost_ = 0;
};

}  // namespace sinew::app
