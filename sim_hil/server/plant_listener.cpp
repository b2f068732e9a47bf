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
                             const hal::ThreadOptions& thread)
    : os_(os), listener_(std::move(listener)), plant_(std::move(plant)), thread_options_(thread) {
  for (DeviceInfo& d : plant_.devices) d.slots = 0, d.slots_offset = 0, d.slot_bytes = 0;  // no frames on a side line
}

Result<std::unique_ptr<PlantListener>> PlantListener::open(hal::Os& os, std::unique_ptr<hal::Listener> listener,
                                                           PlantDescription plant, const hal::ThreadOptions& thread) {
  std::unique_ptr<PlantListener> plant_listener(new PlantListener(os, std::move(listener), std::move(plant), thread));
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
  if (waiting_) turn_away(*waiting_->stream, "the plant has ended");
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
    serve_side_line(caller, {os_, plant_, stopped_});
  } else {
    keep_runtime(caller);
  }
  const std::lock_guard lock(mutex_);
  caller.stream.reset();  // the peer sees the end at once
}

void PlantListener::keep_runtime(Caller& caller) {
  const std::lock_guard lock(mutex_);
  if (taken_ || waiting_) return refuse(*caller.stream, "this plant serves a runtime already");
  caller.stream->set_patience({});
  waiting_.emplace(std::move(caller));
  came_.notify_all();
}

Result<Caller> PlantListener::wait_runtime(hal::Duration patience) {
  std::unique_lock lock(mutex_);
  if (!came_.wait_for(lock, patience, [&] { return waiting_.has_value(); }))
    return Error{Errc::timeout, "no runtime has called"};
  Caller caller = std::move(*waiting_);
  waiting_.reset();
  taken_ = true;
  return caller;
}

void PlantListener::let_go() {
  const std::lock_guard lock(mutex_);
  taken_ = false;
}

void PlantListener::refuse(hal::Stream& stream, std::string_view reason) {
  turned_away_.fetch_add(1, std::memory_order_relaxed);
  turn_away(stream, reason);
}

}  // namespace sinew::sim_hil
