#include "sim_hil/server/relink.hpp"

namespace sinew::plant {
namespace {

constexpr hal::Duration kStartPatience = std::chrono::seconds(2);  // a runtime that is configured already

}  // namespace

hal::Status Relink::look(hal::Duration patience) {
  thread_.reset();
  state_.store(State::looking, std::memory_order_relaxed);
  plant_listener_.let_go(robot_);
  hal::ThreadOptions options;
  options.name = "plant_relink";
  auto thread = os_.start_thread(options, [this, give_up = os_.now() + patience] { run(give_up); });
  if (!thread) return thread.error();
  thread_ = std::move(*thread);
  return {};
}

std::unique_ptr<sim_hil::PlantLink> Relink::take() {
  if (!thread_ || state_.load(std::memory_order_acquire) != State::found) return nullptr;  // acquire: the link
  thread_.reset();
  return std::move(link_);
}

void Relink::run(hal::Time give_up) {
  while (os_.now() < give_up) {
    auto caller = plant_listener_.wait_runtime(give_up - os_.now(), robot_);
    if (!caller) break;
    if (greet(std::move(*caller))) return state_.store(State::found, std::memory_order_release);
    plant_listener_.let_go(robot_);
  }
  state_.store(State::in_vain, std::memory_order_release);
}

bool Relink::greet(sim_hil::Caller caller) {
  const sim_hil::Hello& hello = caller.hello;
  if (hello.mode != sim_hil::Mode::free_running || hello.rate != rate_) {
    sim_hil::turn_away(*caller.stream, "the world runs already, in real time at a rate of " + std::to_string(rate_));
    return false;
  }
  caller.stream->set_patience(kStartPatience);
  std::string why;
  auto link = sim_hil::PlantLink::accept(std::move(caller), plant_, frames_, why);
  if (!link || !(*link)->wait_start()) return false;
  link_ = std::move(*link);
  return true;
}

}  // namespace sinew::plant
