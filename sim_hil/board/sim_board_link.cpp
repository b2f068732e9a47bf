// The sim board's life with its plant: start, clocks, a plant that is lost and comes back, the end.
#include <algorithm>

#include "sim_hil/board/sim_board.hpp"
#include "sim_hil/board/sim_sending.hpp"

namespace sinew::sim_hil {
namespace {

using namespace std::chrono_literals;
using hal::Errc;
using hal::Error;
using hal::Status;

constexpr Duration kClocksAgree = 1h;                       // two readings of one clock, however slow the start was
constexpr Duration kFirstPause = 50ms, kLongestPause = 1s;  // between two tries to reach a lost plant
constexpr Duration kRelinkPatience = 2s;                    // for each answer of a plant that is back
constexpr Duration kLastWords = 200ms;                      // for the Bye to a plant that takes nothing

Duration scaled(Duration d, double rate) {
  return Duration(static_cast<std::int64_t>(static_cast<double>(d.count()) * rate));
}

}  // namespace

Status SimBoard::start() {
  if (started_) return {};
  if (ended()) return end_error_;
  if (shared_.lockstep) {
    static_cast<void>(line_.out.add(Type::start, 0, Time{}));
    if (auto ok = line_.flush(); !ok) return end(ok.error());
    started_ = true;
    return {};
  }
  std::string why;
  if (auto ok = start_plant(line_, why); !ok) {
    if (end_reason_.empty()) end_reason_ = why;
    return end(ok.error());
  }
  started_ = true;
  line_.wait_for(options_.patience, nullptr);
  heard_ns_.store(options_.os->now().ns, std::memory_order_relaxed);
  auto reader = options_.os->start_thread(options_.reader, [this] { read_loop(); });
  if (!reader) return end(reader.error());
  reader_ = std::move(*reader);
  return {};
}

/// Free-running: Start, and where the plant's time stands. `why` is filled when the plant says Bye.
Status SimBoard::start_plant(PlantConnection& line, std::string& why) {
  const bool local = line.stream->local();
  if (!local) {
    if (!keeper_) {
      hal::ThreadOptions thread = options_.reader;
      thread.name = "sim_clock";
      keeper_.emplace(*options_.os, thread, options_.connect, shared_.plant_clock);
    }
    keeper_->begin();
  }
  const Time sent = options_.os->now();
  static_cast<void>(line.out.add(Type::start, 0, Time{}));
  if (auto ok = line.flush(); !ok) return ok;
  Message message;
  if (auto ok = line.receive(message); !ok) return ok;
  if (message.header.type == Type::bye) {
    why = decode_text(message.payload);
    return Error{Errc::closed, "the plant ended the run"};
  }
  line.stream->split();
  return set_clock(message, sent, local);
}

/// Where plant time stands on the runtime's clock. On one machine both read the same host clock.
Status SimBoard::set_clock(const Message& message, Time sent, bool local) {
  ClockInfo info;
  if (message.header.type != Type::clock) return Error{Errc::bad_data, "plant does not answer Start with Clock"};
  if (auto ok = decode(message.header, message.payload, info); !ok) return ok;
  const Time host = options_.os->now();
  const bool one_clock = static_cast<const hal::Clock*>(options_.os) == options_.clock;
  const Time now = one_clock ? host : options_.clock->now();
  Duration host_offset{0};
  if (!local) {
    keeper_->add(sent, Time{info.host_ns}, Time{info.host_ns}, host);
    host_offset = keeper_->host_offset();
  }
  const Duration ago = host - (Time{info.host_ns} + host_offset);
  if (ago > kClocksAgree || ago < -kClocksAgree)
    return Error{Errc::bad_data, "plant reads another host clock than this machine's", info.host_ns};
  const Duration offset = now - (message.header.time + scaled(ago, info.rate));
  shared_.plant_clock.set(offset);
  if (!local) keeper_->follow(offset, host_offset, info.rate);
  return {};
}

// ---- receiving, and a plant that is lost

void SimBoard::read_loop() {
  for (;;) {
    const Status ok = read_some();
    if (ok || (!ended() && relink(ok.error()))) continue;
    static_cast<void>(end(ok.error()));
    for (auto& device : devices_)
      if (device) device->notify();  // their readers learn that no more samples come
    return;
  }
}

Status SimBoard::read_some() {
  Message message;
  auto next = line_.in.next(message);
  if (!next) return next.error();
  if (*next) return take(message, shared_.clock->now());
  auto n = line_.read(line_.in.space());
  if (!n) return n.error();
  heard_ns_.store(options_.os->now().ns, std::memory_order_relaxed);
  line_.in.filled(*n);
  return {};
}

/// Looks for the plant until it is back. False: not found in time, or the board ends.
bool SimBoard::relink(const Error& lost) {
  if (options_.relink_for.count() <= 0 || !options_.connect || lost.code == Errc::bad_data || leaving()) return false;
  linked_.store(false, std::memory_order_seq_cst);
  hal::Os& os = *options_.os;
  while (sending_.load(std::memory_order_seq_cst)) os.sleep_until(os.now() + 50us);
  if (keeper_) keeper_->stop();

  const std::string reason = describe_failure(lost, "connection to plant '" + welcome_.plant + "' lost");
  const Time at = shared_.clock->now(), give_up = os.now() + options_.relink_for;
  {
    const std::lock_guard lock(link_mutex_);
    outages_.push_back({at, Duration{0}, reason});
  }
  std::string why = reason;
  Duration pause = kFirstPause;
  bool back = false;
  for (int attempt = 1; !back && !leaving() && os.now() < give_up; ++attempt) {
    say_trouble(why + "; try " + std::to_string(attempt) + " in " + std::to_string(pause / 1ms) + " ms");
    const Time next = os.now() + pause;
    while (!leaving() && os.now() < next) os.wait(leave_, 0, next);
    pause = std::min(2 * pause, kLongestPause);
    back = !leaving() && try_relink(why);
    if (!end_reason_.empty()) break;  // it is back as another
  }
  const std::lock_guard lock(link_mutex_);
  outages_.back().length = shared_.clock->now() - at;
  trouble_.clear();
  if (!back) ended_at_ = at;
  if (!back && end_reason_.empty() && !leaving()) end_reason_ = reason + "; looked for it in vain: " + why;
  return back;
}

bool SimBoard::try_relink(std::string& why) {
  PlantConnection fresh;
  auto stream = options_.connect();
  if (!stream) {
    why = describe_failure(stream.error(), "plant '" + welcome_.plant + "' is not back");
    return false;
  }
  fresh.stream = std::move(*stream);
  const Silence until_we_leave{.go_on = [this](Duration) { return !leaving(); }};
  fresh.wait_for(kRelinkPatience, &until_we_leave);
  why.clear();
  if (!fresh.shake_hands(hello(), why)) return false;
  if (const std::string what = difference(welcome_, fresh.welcome); !what.empty()) {
    end_reason_ = "plant '" + fresh.welcome.plant + "' came back as another: " + what;
    static_cast<void>(fresh.out.add_text(Type::bye, Time{}, end_reason_));
    static_cast<void>(fresh.flush());  // the run is over either way
    return false;
  }
  if (auto ok = start_plant(fresh, why); !ok) {
    why = describe_failure(ok.error(), why.empty() ? "plant '" + welcome_.plant + "' does not start" : why);
    return false;
  }
  fresh.wait_for(options_.patience, nullptr);
  return take_line(fresh);
}

/// False when bye() was faster.
bool SimBoard::take_line(PlantConnection& fresh) {
  const std::lock_guard lock(link_mutex_);
  if (leaving()) return false;
  if (line_.memory) retired_.push_back(std::move(line_.memory));
  line_ = std::move(fresh);
  for (auto& device : devices_)
    if (device) device->relinked(line_.memory.get());
  last_commit_ = {};
  linked_.store(true, std::memory_order_seq_cst);
  return true;
}

void SimBoard::say_trouble(std::string text) {
  const std::lock_guard lock(link_mutex_);
  trouble_ = std::move(text);
}

std::string SimBoard::link_trouble() const {
  const std::lock_guard lock(link_mutex_);
  return trouble_;
}

Duration SimBoard::silent_for() const {
  const std::int64_t heard = heard_ns_.load(std::memory_order_relaxed);
  if (heard == 0 || ended() || !linked_.load(std::memory_order_relaxed)) return Duration{0};
  return options_.os->now() - Time{heard};
}

/// Sends what waits, but does not wait long for a plant that takes nothing: false.
bool SimBoard::flush_soon() {
  if (!options_.os) return static_cast<bool>(line_.flush());
  const Time give_up = options_.os->now() + kLastWords;
  for (;;) {
    const auto n = line_.stream->write_now(line_.out.pending());
    if (!n) return false;
    line_.out.sent(*n);
    if (line_.out.pending().empty()) return true;
    if (options_.os->now() >= give_up) return false;
    options_.os->sleep_until(options_.os->now() + 5ms);
  }
}

void SimBoard::bye(std::string_view reason) {
  if (said_bye_) return;
  said_bye_ = true;
  leave_.store(1, std::memory_order_release);
  if (options_.os) options_.os->wake(leave_);
  if (const Sending sending(*this); sending) {
    if (ended()) reason = end_reason_;
    if (line_.out.room() >= kHeaderBytes + reason.size() || flush_soon()) {
      static_cast<void>(line_.out.add_text(Type::bye, Time{}, reason));
      flush_soon();  // the peer may be gone already; then nobody needs the reason
    }
  }
  {
    const std::lock_guard lock(link_mutex_);
    line_.stream->shutdown();
  }
  if (reader_) reader_->join();
  if (keeper_) keeper_->stop();
}

}  // namespace sinew::sim_hil
