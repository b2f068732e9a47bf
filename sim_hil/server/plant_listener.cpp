#include "sim_hil/server/plant_listener.hpp"

#include <algorithm>

#include "sim_hil/server/side_line_server.hpp"

namespace sinew::sim_hil {
namespace {

using namespace std::chrono_literals;
using hal::Errc;
using hal::Error;
using hal::Result;

constexpr hal::Duration kHelloPatience = 2s;  // a caller that says nothing for so long is not served
constexpr hal::Duration kLookAround = 100ms;  // how long the end of the listener may take

}  // namespace

PlantListener::PlantListener(hal::Os& os, std::unique_ptr<hal::Listener> listener, PlantDescription plant,
                             const hal::ThreadOptions& thread, const std::vector<std::string>& robots)
    : os_(os), listener_(std::move(listener)), plant_(std::move(plant)), thread_options_(thread) {
  for (const std::string& robot : robots) places_.emplace_back().robot = robot;
  if (places_.empty()) places_.emplace_back();
  for (DeviceInfo& d : plant_.devices) d.slots = 0, d.slots_offset = 0, d.slot_bytes = 0;  // no frames on a side line
}

Result<std::unique_ptr<PlantListener>> PlantListener::open(hal::Os& os, std::unique_ptr<hal::Listener> listener,
                                                           PlantDescription plant, const hal::ThreadOptions& thread,
                                                           const std::vector<std::string>& robots) {
  std::unique_ptr<PlantListener> plant_listener(
      new PlantListener(os, std::move(listener), std::move(plant), thread, robots));
  auto acceptor = os.start_thread(thread, [raw = plant_listener.get()] { raw->accept_loop(); });
  if (!acceptor) return acceptor.error();
  plant_listener->acceptor_ = std::move(*acceptor);
  return plant_listener;
}

PlantListener::~PlantListener() {
  closing_.store(true, std::memory_order_relaxed);
  if (acceptor_) acceptor_->join();
  {
    const std::lock_guard lock(mutex_);
    for (auto& line : lines_)
      if (line->caller.stream) line->caller.stream->shutdown();
  }
  lines_.clear();  // joins
  for (const Place& place : places_)
    if (place.waiting) turn_away(*place.waiting->stream, "the plant has ended");
}

void PlantListener::accept_loop() {
  while (!closing_.load(std::memory_order_relaxed)) {
    auto stream = listener_->accept(kLookAround);
    if (stream) {
      admit(std::move(*stream));
    } else if (stream.error().code != Errc::timeout) {
      os_.sleep_until(os_.now() + kLookAround);  // e.g. out of handles: try again later
    }
    const std::lock_guard lock(mutex_);
    std::erase_if(lines_, [](const auto& line) { return line->over.load(std::memory_order_acquire); });
  }
}

void PlantListener::admit(std::unique_ptr<hal::Stream> stream) {
  const std::lock_guard lock(mutex_);
  if (lines_.size() >= kMaxLines) return refuse(*stream, "too many connections to this plant");
  auto line = std::make_unique<Line>();
  line->caller.stream = std::move(stream);
  auto thread = os_.start_thread(thread_options_, [this, raw = line.get()] {
    serve(raw->caller);
    raw->over.store(true, std::memory_order_release);
  });
  if (!thread) return refuse(*line->caller.stream, "the plant has no thread left");
  line->thread = std::move(*thread);
  lines_.push_back(std::move(line));
}

void PlantListener::serve(Caller& caller) {
  std::string why;
  caller.stream->set_patience(kHelloPatience);
  if (!hear_hello(caller, plant_.name, why)) {
    turned_away_.fetch_add(1, std::memory_order_relaxed);
  } else if (caller.hello.mode == Mode::side_line) {
    caller.stream->set_patience({});
    side_lines_.fetch_add(1, std::memory_order_relaxed);
    Place* const place = places_.front().robot.empty() ? nullptr : find_place(caller.hello.robot);
    serve_side_line(caller, {os_, plant_, place ? place->stopped : stopped_});
  } else {
    keep_runtime(caller);
  }
  const std::lock_guard lock(mutex_);
  caller.stream.reset();  // the peer sees the end at once
}

PlantListener::Place* PlantListener::find_place(const std::string& robot) {
  const auto it = std::ranges::find_if(places_, [&](const Place& p) { return p.robot.empty() || p.robot == robot; });
  return it == places_.end() ? nullptr : &*it;
}

void PlantListener::keep_runtime(Caller& caller) {
  const std::lock_guard lock(mutex_);
  const std::string& name = caller.hello.robot;
  Place* const place = find_place(name);
  if (!place) {
    std::string known;
    for (const Place& p : places_) known += (known.empty() ? "" : ", ") + p.robot;
    return refuse(*caller.stream, "this plant has no robot '" + name + "'; it has: " + known);
  }
  if (place->taken || place->waiting)
    return refuse(*caller.stream, place->robot.empty() ? std::string("this plant serves a runtime already")
                                                       : "this plant serves robot '" + name + "' already");
  caller.stream->set_patience({});
  place->waiting.emplace(std::move(caller));
  came_.notify_all();
}

Result<Caller> PlantListener::wait_runtime(hal::Duration patience, std::size_t robot) {
  std::unique_lock lock(mutex_);
  Place& place = places_[robot];
  if (!came_.wait_for(lock, patience, [&] { return place.waiting.has_value(); }))
    return Error{Errc::timeout, "no runtime has called"};
  Caller caller = std::move(*place.waiting);
  place.waiting.reset();
  place.taken = true;
  return caller;
}

void PlantListener::let_go(std::size_t robot) {
  const std::lock_guard lock(mutex_);
  places_[robot].taken = false;
}

void PlantListener::refuse(hal::Stream& stream, std::string_view reason) {
  turned_away_.fetch_add(1, std::memory_order_relaxed);
  turn_away(stream, reason);
}

}  // namespace sinew::sim_hil
