#include "drivers/joints/can_hub.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace sinew::drivers {
namespace {

using namespace std::chrono_literals;

constexpr int kFramesPerStep = 512;  // a flood of frames does not hold up ticks
constexpr std::size_t kMostMasks = 8;
constexpr Duration kLoadWindow = 1s;

void count(hal::Tally& tally) noexcept { tally.add(); }

}  // namespace

CanHub::CanHub(hal::Os& os, hal::CanBus& bus, const CanHubConfig& config)
    : os_(os), bus_(bus), config_(config), period_(static_cast<std::int64_t>(1e9 / config.tick_hz)) {}

CanHub::~CanHub() { stop(); }

void CanHub::add(std::unique_ptr<BusService> service) { services_.push_back(std::move(service)); }

ServoProtocol& CanHub::add(std::unique_ptr<ServoProtocol> servo, ServoOwner& owner, std::size_t index) {
  servos_.push_back({std::move(servo), &owner, index});
  if (std::find(owners_.begin(), owners_.end(), &owner) == owners_.end()) owners_.push_back(&owner);
  return *servos_.back().servo;
}

// ---- before the start ----

hal::Status CanHub::configure(std::string& why) {
  standard_.assign(0x800, kEnd);
  bool hooked = true;
  for (const auto& service : services_) hooked = hook(*service, kNoServo) && hooked;
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    hooked = hook(*servos_[i].servo, static_cast<std::uint16_t>(i)) && hooked;
  }
  if (!(config_.tick_hz > 0) || config_.tick_hz > 10'000) {
    why = "tick_hz: above 0, at most 10000";
  } else if (!hooked) {
    why = "listens to too many kinds of identifiers";
  } else {
    why = plan();
  }
  if (!why.empty()) return hal::Error{hal::Errc::bad_argument, "CAN hub"};
  bus_.set_wake(&bus_wake_);
  return {};
}

std::string CanHub::plan() {
  std::vector<const ServoProtocol*> servos;
  for (const Entry& entry : servos_) servos.push_back(entry.servo.get());
  if (const auto clashes = find_clashes(servos); !clashes.empty()) {
    const BusClash& c = clashes.front();
    return "servo '" + servos[c.second]->config().name + "': " + std::string(c.key) + ": " + std::to_string(c.number) +
           ": " + c.why;
  }
  const BusLoad load = plan_load(services_, servos, config_.tick_hz, bus_.bit_rate());
  planned_load_ = load.part;
  if (load.part <= config_.max_load) return {};
  return "max_load_percent: " + std::to_string(std::lround(100 * config_.max_load)) + ": " + to_string(load);
}

std::uint16_t* CanHub::head(const Interest& interest) {
  if (!interest.extended) return interest.id <= 0x7FF && interest.mask == 0x7FF ? &standard_[interest.id] : nullptr;
  auto table = std::find_if(extended_.begin(), extended_.end(),
                            [&interest](const MaskTable& t) { return t.mask == interest.mask; });
  if (table == extended_.end()) {
    if (extended_.size() == kMostMasks) return nullptr;
    const std::size_t slots = std::bit_ceil(8 * (servos_.size() + services_.size() + 1));
    extended_.push_back({interest.mask, std::vector<std::uint32_t>(slots), std::vector<std::uint16_t>(slots, kEnd)});
    table = extended_.end() - 1;
  }
  const std::uint32_t key = interest.id & interest.mask;
  const std::size_t mask = table->heads.size() - 1;
  std::size_t at = (key * 0x9E3779B1u >> 7) & mask;
  for (std::size_t tries = 0; tries <= mask; ++tries, at = (at + 1) & mask) {
    if (table->heads[at] != kEnd && table->keys[at] != key) continue;
    table->keys[at] = key;
    return &table->heads[at];
  }
  return nullptr;
}

bool CanHub::hook(CanListener& listener, std::uint16_t servo) {
  for (const Interest& interest : listener.interests()) {
    std::uint16_t* first = head(interest);
    if (first == nullptr || hooks_.size() >= kEnd) return false;
    hooks_.push_back({&listener, servo, *first});
    *first = static_cast<std::uint16_t>(hooks_.size() - 1);
  }
  return true;
}

// ---- running ----

hal::Status CanHub::start() {
  ending_.store(false, std::memory_order_relaxed);  // the thread is made after it
  auto thread = os_.start_thread(config_.thread, [this] { run(); });
  if (!thread) return thread.error();
  thread_ = std::move(*thread);
  return {};
}

void CanHub::stop() {
  if (!thread_) return;
  ending_.store(true, std::memory_order_release);  // pairs with run()'s
  ring();
  thread_.reset();  // joins
  bus_.set_wake(nullptr);
}

void CanHub::run() {
  while (!ending_.load(std::memory_order_acquire)) {
    const std::uint32_t seen = word_.load(std::memory_order_seq_cst);
    const Time next = step(os_.now());
    // This thread sets sleeping_, then reads the word (in wait); ring() changes the word, then reads sleeping_.
    // Sequential consistency: at least one of the two sees the other's change.
    sleeping_.store(true, std::memory_order_seq_cst);
    os_.wait(word_, seen, next);
    sleeping_.store(false, std::memory_order_relaxed);
  }
  sink_.deadline = os_.now() + 100ms;
  sink_.patient = true;
  for (const Entry& entry : servos_) entry.servo->farewell(sink_);
}

void CanHub::ring() noexcept {
  word_.fetch_add(1, std::memory_order_seq_cst);
  if (sleeping_.load(std::memory_order_seq_cst)) os_.wake(word_);
}

void CanHub::poke() noexcept {
  poked_.store(true, std::memory_order_release);  // pairs with step()'s exchange: the setpoint was written before
  ring();
}

Time CanHub::step(Time now) noexcept {
  if (next_tick_.ns == 0) next_tick_ = now;
  const bool more = read_frames(now);
  if (now >= next_tick_) {
    if (last_tick_.ns != 0 && now - next_tick_ > period_) count(counters_.late_ticks);
    tick(now);
  } else if (poked_.load(std::memory_order_acquire)) {
    const Time earliest = last_tick_ + part_of(period_, kEarliestTick);
    if (now < earliest) return more ? now : earliest;
    tick(now);
  }
  return more ? now : next_tick_;
}

bool CanHub::read_frames(Time now) noexcept {
  msg::CanFrame frame;
  bool more = true, any = false;
  for (int i = 0; i < kFramesPerStep && more; ++i) {
    const auto got = bus_.read(frame);
    if (!got) count(counters_.errors);  // gone for now: the servos see the silence
    more = got && *got;
    if (more) take(frame, now);
    any = any || more;
  }
  if (any) {
    for (ServoOwner* owner : owners_) owner->settled(*this, false);
  }
  return more;
}

void CanHub::take(const msg::CanFrame& frame, Time now) noexcept {
  if (frame.error()) {
    count(counters_.errors);
    return;
  }
  count(counters_.frames);
  load_bits_ += hal::can_frame_bits(frame);
  bool known = false;
  if (!frame.extended()) {
    known = frame.id <= 0x7FF && dispatch(standard_[frame.id], frame, now);
  } else {
    for (const MaskTable& table : extended_) {
      const std::uint32_t key = frame.id & table.mask;
      const std::size_t mask = table.heads.size() - 1;
      for (std::size_t at = (key * 0x9E3779B1u >> 7) & mask; table.heads[at] != kEnd; at = (at + 1) & mask) {
        if (table.keys[at] != key) continue;
        known = dispatch(table.heads[at], frame, now) || known;
        break;
      }
    }
  }
  if (!known) count(counters_.unknown);
}

bool CanHub::dispatch(std::uint16_t at, const msg::CanFrame& frame, Time now) noexcept {
  if (at == kEnd) return false;
  bool mine = false, malformed = false;
  for (; at != kEnd; at = hooks_[at].next) {
    const Hook& hook = hooks_[at];
    const Heard heard = hook.listener->on_frame(frame, now);
    mine = mine || heard == Heard::mine;
    malformed = malformed || heard == Heard::malformed;
    if (heard != Heard::mine || hook.servo == kNoServo) continue;
    const Entry& entry = servos_[hook.servo];
    entry.owner->feedback(entry.index, entry.servo->feedback());
  }
  if (!mine) count(malformed ? counters_.malformed : counters_.foreign);
  return true;
}

void CanHub::tick(Time now) noexcept {
  const bool poked = poked_.exchange(false, std::memory_order_acq_rel);
  sink_.deadline = now + period_;
  for (const auto& service : services_) service->begin(now, sink_);
  for (ServoOwner* owner : owners_) owner->latch(*this);
  for (const Entry& entry : servos_) {
    entry.servo->tick(now, entry.owner->command(entry.index, now), sink_);
    entry.owner->feedback(entry.index, entry.servo->feedback());
  }
  for (const auto& service : services_) service->end(now, sink_);
  for (ServoOwner* owner : owners_) owner->settled(*this, true);
  last_tick_ = now;
  if (poked) {
    next_tick_ = now + part_of(period_, kLatestTick);  // waits for the next setpoint
  } else {                                             // a late tick does not shift the next ones
    next_tick_ = now - next_tick_ < period_ && now >= next_tick_ ? next_tick_ + period_ : now + period_;
  }
  count(counters_.ticks);
  measure_load(now);
}

void CanHub::measure_load(Time now) noexcept {
  if (load_since_.ns == 0) load_since_ = now;
  const Duration window = now - load_since_;
  if (window < kLoadWindow) return;
  const double rate = bus_.bit_rate();
  const double load = rate > 0 ? static_cast<double>(load_bits_) / (msg::seconds(window) * rate) : 0;
  counters_.measured.store(load);
  load_bits_ = 0;
  load_since_ = now;
}

void CanHub::Sink::send(const msg::CanFrame& frame) noexcept {
  hal::Status sent = hub_.bus_.send(frame, deadline);
  while (patient && !sent && sent.error().code == hal::Errc::timeout && hub_.os_.now() < deadline) {
    hub_.os_.sleep_until(hub_.os_.now() + 1ms);  // some eight frames leave meanwhile
    sent = hub_.bus_.send(frame, deadline);
  }
  if (!sent) {
    count(hub_.counters_.send_failed);
    return;
  }
  count(hub_.counters_.sent);
  hub_.load_bits_ += hal::can_frame_bits(frame);
}

CanHubStats CanHub::stats() const noexcept {
  const auto of = [](const hal::Tally& tally) { return tally.value(); };
  CanHubStats s;
  s.frames = of(counters_.frames);
  s.unknown = of(counters_.unknown);
  s.foreign = of(counters_.foreign);
  s.malformed = of(counters_.malformed);
  s.errors = of(counters_.errors);
  s.sent = of(counters_.sent);
  s.send_failed = of(counters_.send_failed);
  s.ticks = of(counters_.ticks);
  s.late_ticks = of(counters_.late_ticks);
  s.planned_load = planned_load_;
  s.measured_load = counters_.measured.load();
  return s;
}

}  // namespace sinew::drivers
