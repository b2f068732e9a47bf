#include "team/link.hpp"

#include <algorithm>
#include <cstring>

#include "math/hash.hpp"
#include "msg/cdr.hpp"
#include "msg/ros2msg.hpp"

namespace sinew::team {
namespace {

using namespace std::chrono_literals;
using rt::Duration;
using rt::Time;

constexpr Duration kStateEvery = 100ms, kQuietStateEvery = 500ms;  // while something changes, and while nothing does
constexpr Duration kLongestSilence = 1s;  // a frame at least so often, so that mates know that we live, and our clock
constexpr Duration kEchoEvery = 200ms;    // to each mate
constexpr std::size_t kMostEchoes = 4;    // in one frame
constexpr Duration kLongestEcho =
    std::chrono::hours(1);  // from our frame to the echo's arrival; a longer one is no echo
constexpr double kLargestFrame = msg::kMaxDatagramBytes;
constexpr std::size_t kHeadOfMarked = 32;  // of a FromMate, in front of its message

static_assert(offsetof(msg::FromMate<msg::MateState>, message) == kHeadOfMarked);

/// Of a FromMate; null: it is none.
const msg::FieldInfo* message_of(const msg::TypeInfo& type) {
  for (const msg::FieldInfo& f : type.fields)
    if (f.name == "message" && f.nested && f.offset == kHeadOfMarked && type.name.ends_with("FromMate")) return &f;
  return nullptr;
}

/// Takes every instant of the message, but those that are not set, onto the own clock. An instant that is `stamp` by
/// name was never later than the message arrived. False: one is impossible.
bool shift_times(const msg::TypeInfo& type, std::byte* message, Duration offset, Time received) {
  for (const msg::FieldInfo& f : type.fields) {
    for (std::uint32_t i = 0; i < f.count; ++i) {
      if (f.nested) {
        if (!shift_times(*f.nested, message + f.offset + i * f.nested->size, offset, received)) return false;
      } else if (f.is_time) {
        Time t;
        std::memcpy(&t, message + f.offset + i * sizeof t, sizeof t);
        if (t == Time{}) continue;
        if (!wire::is_team_instant(t.ns)) return false;
        t = t + offset;
        if (f.name == "stamp") t = std::min(t, received);
        std::memcpy(message + f.offset + i * sizeof t, &t, sizeof t);
      }
    }
  }
  return true;
}

std::uint32_t type_hash(const msg::TypeInfo& type) {
  return static_cast<std::uint32_t>(math::fnv1a64(msg::ros2msg_schema(type)));
}

std::size_t cdr_bytes_of(const msg::TypeInfo& type) {
  std::vector<std::max_align_t> message(type.size / sizeof(std::max_align_t) + 1);
  type.reset(message.data());
  return msg::cdr_size(type, message.data());
}

/// Numbers wrap.
bool is_newer(std::uint32_t a, std::uint32_t than) { return static_cast<std::int32_t>(a - than) > 0; }

}  // namespace

struct Link::Incoming {
  rt::AnyOut out;
  std::string name;   // "robot2/ball.model"
  std::string topic;  // "ball.model"
  std::size_t mate = 0;
  bool of_all = false;
  // After configure():
  const msg::TypeInfo* type = nullptr;  // of the mate's message
  std::uint32_t hash = 0;
  // Of this step:
  std::uint32_t loans = 0;
  std::byte* loaned = nullptr;
};

struct Link::Outgoing {
  rt::AnyIn in;
  Said said;
  Duration period{};
  std::uint32_t hash = 0;  // after configure()
};

std::string say_port(std::string_view topic) {
  std::string port = "say_" + std::string(topic);
  std::replace(port.begin(), port.end(), '.', '_');
  return port;
}

bool is_from_mate(const msg::TypeInfo& type) { return message_of(type) != nullptr; }

std::size_t most_cdr_bytes(std::string_view topic) {
  return msg::kMaxDatagramBytes - wire::kTeamHeadBytes - kMostEchoes * wire::kTeamEchoBytes - wire::kTeamMessageBytes -
         topic.size();
}

SaidCost cost_of(const Said& said, const msg::TypeInfo& type) {
  SaidCost cost;
  cost.message_bytes = wire::kTeamMessageBytes + said.topic.size() + cdr_bytes_of(type);
  cost.bytes_per_s = static_cast<double>(cost.message_bytes) * said.rate_hz;
  return cost;
}

double overhead_bytes_per_s(const LinkOptions& options, double step_hz) {
  double frames_hz = 0;  // each message may need a frame of its own
  for (const Said& s : options.said) frames_hz += s.rate_hz;
  frames_hz = std::max(frames_hz, 1 / msg::seconds(kLongestSilence));
  if (step_hz > 0) frames_hz = std::min(frames_hz, step_hz);
  const double echoes_hz = static_cast<double>(options.mates.size()) / msg::seconds(kEchoEvery);
  return frames_hz * static_cast<double>(wire::kTeamHeadBytes) +
         std::min(echoes_hz, frames_hz * kMostEchoes) * static_cast<double>(wire::kTeamEchoBytes);
}

Link::Link(LinkOptions options) : options_(std::move(options)) {
  for (const std::string& name : options_.heard) {
    auto remote = std::make_unique<Incoming>();
    const std::size_t slash = name.find('/');
    const std::string_view who = std::string_view(name).substr(0, slash);
    remote->name = name;
    remote->topic = name.substr(slash + 1);
    remote->of_all = who == kAllMates;
    while (remote->mate < options_.mates.size() && options_.mates[remote->mate].name != who) ++remote->mate;
    incoming_.push_back(std::move(remote));
  }
  for (const Said& said : options_.said) {
    auto topic = std::make_unique<Outgoing>();
    topic->said = said;
    topic->period = Duration(static_cast<std::int64_t>(1e9 / said.rate_hz));
    outgoing_.push_back(std::move(topic));
  }
  mates_.resize(options_.mates.size());
  newest_.resize(incoming_.size() * mates_.size());
  due_.resize(outgoing_.size());
  urgent_.resize(outgoing_.size());
}

Link::~Link() = default;

void Link::declare(rt::Declaration& d) {
  d.raw("raw", raw_, {.burst = kReceiveBurst});
  for (const auto& m : outgoing_) d.in(say_port(m->said.topic), m->in);
  for (const auto& e : incoming_) d.out(e->name, e->out, {.burst = e->of_all ? kReceiveBurst : 1});
  d.out("state", state_);
  d.out("frame", frame_);
  d.param("device", device_name_, {.doc = "name of the radio on the board"});
  d.state(mates_, newest_, due_, own_, counts_);
}

hal::Status Link::configure(rt::Setup& setup) {
  std::size_t largest = 0, longest = 0;
  for (const auto& e : incoming_) {
    e->type = e->out.type();
    if (e->of_all != is_from_mate(*e->type)) {
      setup.explain(e->name + " carries " + std::string(e->type->name) +
                    "; inputs of a topic of all mates are of FromMate<...>, and no others");
      return hal::Error{hal::Errc::bad_argument, "type of a remote topic"};
    }
    if (e->of_all) e->type = message_of(*e->type)->nested;
    e->hash = type_hash(*e->type);
    largest = std::max<std::size_t>(largest, e->type->size);
  }
  for (const auto& m : outgoing_) {
    m->hash = type_hash(*m->in.type());
    longest = std::max(longest, cdr_bytes_of(*m->in.type()));
  }
  cdr_.resize(longest);
  scratch_.resize(largest / sizeof(std::max_align_t) + 1);
  auto radio = setup.board().radio(device_name_);
  if (!radio) return drivers::explain_no_device(setup, device_name_, radio.error());
  device_ = *radio;
  return {};
}

void Link::reset() {
  std::fill(mates_.begin(), mates_.end(), MateRecord{});
  std::fill(newest_.begin(), newest_.end(), Newest{});
  std::fill(due_.begin(), due_.end(), Due{});
  own_ = {};
  counts_ = {};
  counts_.robot = options_.robot;
  counts_.mates = static_cast<std::uint32_t>(mates_.size());
  for (std::size_t i = 0; i < mates_.size(); ++i) mates_[i].state.robot = options_.mates[i].robot;
}

void Link::collect(Time) noexcept { drivers::collect_ready(raw_, *device_); }

void Link::emit(Time) noexcept {
  // A frame that is not sent is counted by the radio, and is like one that the network loses.
  if (const msg::Datagram* frame = frame_.committed()) static_cast<void>(device_->send(frame->bytes()));
}

/// The first step after a start. `start` has to differ from the one before, and a record must give it again: the
/// instant does both.
void Link::begin(Time now) noexcept {
  char seed[sizeof now.ns + sizeof options_.robot];
  std::memcpy(seed, &now.ns, sizeof now.ns);
  std::memcpy(seed + sizeof now.ns, &options_.robot, sizeof options_.robot);
  own_.start = static_cast<std::uint32_t>(math::fnv1a64(std::string_view(seed, sizeof seed)));
  own_.tokens = kLargestFrame;
  own_.frame_at = now - kLongestSilence;
  own_.state_at = now - kQuietStateEvery;
  own_.began = 1;
  counts_.start = own_.start;
}

rt::StepStatus Link::step(const rt::Step& step) noexcept {
  if (!own_.began) begin(step.now);
  for (const auto& e : incoming_) e->loans = 0, e->loaned = nullptr;
  for (const msg::Datagram& datagram : raw_) receive(datagram);
  send(step);
  if (step.now - own_.state_at >= (own_.changed ? kStateEvery : kQuietStateEvery)) publish_state(step.now);
  return rt::StepStatus::ok;
}

// ---- hearing

void Link::receive(const msg::Datagram& datagram) noexcept {
  own_.changed = 1;
  wire::TeamReader frame;
  if (frame.open(datagram.bytes()) != nullptr) {
    ++counts_.garbage;
    return;
  }
  const wire::TeamHead& head = frame.head();
  if (head.team != options_.team) {
    ++counts_.other_teams;
    return;
  }
  std::size_t i = 0;
  while (i < mates_.size() && options_.mates[i].robot != head.robot) ++i;
  if (i == mates_.size()) {
    ++counts_.strangers;
    counts_.last_stranger = head.robot;
    return;
  }
  MateRecord& mate = mates_[i];
  if (!accept(mate, head)) return;
  take_echoes(mate, frame, datagram.stamp);
  if (head.sequence == mate.state.sequence) mate.state.heard = datagram.stamp, mate.state.sent = Time{head.sent_ns};
  while (const auto message = frame.next()) receive_message(i, *message, datagram.stamp);
}

/// False: the frame came before, or is of an earlier life of the mate.
bool Link::accept(MateRecord& mate, const wire::TeamHead& head) noexcept {
  msg::MateState& state = mate.state;
  if (state.starts == 0 || head.start != state.start) {
    if (state.starts != 0 && head.start == mate.former_start) {
      ++state.reordered;  // of before its restart
      return false;
    }
    mate.former_start = state.start;
    mate.clock = hal::ClockFilter();
    mate.came = ~std::uint64_t{0};  // a frame of before the first one comes too late, and was never counted as lost
    state.start = head.start;
    state.sequence = head.sequence;
    mate.echoed = {};
    ++state.starts;
    ++state.frames;
    const auto place = static_cast<std::size_t>(&mate - mates_.data());
    for (std::size_t e = 0; e < incoming_.size(); ++e) newest_[e * mates_.size() + place] = {};
    return true;
  }
  const auto ahead = static_cast<std::int32_t>(head.sequence - state.sequence);
  if (ahead > 0) {
    mate.came = ahead < 64 ? mate.came << ahead | 1 : 1;
    state.lost += static_cast<std::uint32_t>(ahead) - 1;
    state.sequence = head.sequence;
    ++state.frames;
    return true;
  }
  const std::uint64_t bit = ahead > -64 ? std::uint64_t{1} << -ahead : 0;
  if (bit == 0 || (mate.came & bit) != 0) {
    ++state.duplicated;
    return false;
  }
  mate.came |= bit;
  --state.lost;
  ++state.frames;
  ++state.reordered;
  return true;
}

void Link::take_echoes(MateRecord& mate, const wire::TeamReader& frame, Time arrived) noexcept {
  for (std::size_t i = 0; i < frame.echoes(); ++i) {
    const wire::TeamEcho echo = frame.echo(i);
    if (echo.robot != options_.robot || echo.start != own_.start) continue;
    if (Time{echo.sent_ns} > arrived || arrived - Time{echo.sent_ns} > kLongestEcho) continue;
    mate.clock.add(Time{echo.sent_ns}, Time{echo.received_ns}, Time{frame.head().sent_ns}, arrived);
    return;  // a frame has one for each mate
  }
}

/// A message counts once, however many topics it comes to.
void Link::receive_message(std::size_t mate, const wire::TeamMessage& message, Time received) noexcept {
  MateRecord& from = mates_[mate];
  bool foreign = false, dropped = false, unclocked = false, published = false;
  for (std::size_t e = 0; e < incoming_.size(); ++e) {
    Incoming& remote = *incoming_[e];
    if (remote.topic != message.topic || (!remote.of_all && remote.mate != mate)) continue;
    Newest& newest = newest_[e * mates_.size() + mate];
    if (remote.hash != message.type_hash) {
      foreign = true;
    } else if (newest.any && !is_newer(message.sequence, newest.sequence)) {
      dropped = true;
    } else if (!from.clock.any()) {
      unclocked = true;
    } else {
      newest = {1, message.sequence};
      (publish(from, remote, message, received) ? published : dropped) = true;
    }
  }
  from.state.foreign += foreign;
  from.state.dropped += dropped;
  from.state.unclocked += unclocked;
  from.state.messages += published;
}

/// False: it is not what its type says, or there is no room for it.
bool Link::publish(const MateRecord& from, Incoming& remote, const wire::TeamMessage& message, Time received) noexcept {
  auto* const decoded = reinterpret_cast<std::byte*>(scratch_.data());
  if (remote.of_all && remote.loans == kReceiveBurst) return false;
  remote.type->reset(decoded);
  if (!msg::cdr_decode(*remote.type, message.cdr, decoded)) return false;
  const auto clock = from.clock.at(received);
  if (!shift_times(*remote.type, decoded, clock.offset, received)) return false;
  if (remote.of_all || !remote.loaned) remote.loaned = static_cast<std::byte*>(remote.out.loan()), ++remote.loans;
  if (!remote.of_all) {  // the newest of the step takes the place of one before
    std::memcpy(remote.loaned, decoded, remote.type->size);
    return true;
  }
  msg::FromMate<msg::MateState> head;  // of any type: its head is the same
  head.stamp = message.stamp_ns == 0 ? received : std::min(Time{message.stamp_ns} + clock.offset, received);
  head.received = received;
  head.stamp_bound_ns = clock.bound.count();
  head.robot = from.state.robot;
  head.sequence = message.sequence;
  std::memcpy(remote.loaned, &head, kHeadOfMarked);
  std::memcpy(remote.loaned + kHeadOfMarked, decoded, remote.type->size);
  return true;
}

// ---- saying

/// Those that are due, the most urgent first: by priority, then the one that has waited longest, then as in the file.
std::size_t Link::by_urgency(Time now) noexcept {
  std::size_t n = 0;
  for (std::size_t i = 0; i < outgoing_.size(); ++i) {
    const Due& due = due_[i];
    const rt::AnyIn& in = outgoing_[i]->in;
    if (in.get() && now >= due.at && !(due.any && in.header(0)->sequence == due.sequence))
      urgent_[n++] = static_cast<std::uint32_t>(i);
  }
  const auto before = [this](std::uint32_t a, std::uint32_t b) {
    const int pa = outgoing_[a]->said.priority, pb = outgoing_[b]->said.priority;
    if (pa != pb) return pa > pb;
    return due_[a].at != due_[b].at ? due_[a].at < due_[b].at : a < b;
  };
  std::sort(urgent_.begin(), urgent_.begin() + static_cast<std::ptrdiff_t>(n), before);
  return n;
}

/// At most one frame a step, within the budget: a bucket of bytes that fills at the budget's rate and holds one frame.
void Link::send(const rt::Step& step) noexcept {
  own_.tokens = std::min(kLargestFrame, own_.tokens + options_.bytes_per_s * msg::seconds(step.dt));
  const std::size_t urgent = by_urgency(step.now);
  if (urgent == 0 && step.now - own_.frame_at < kLongestSilence) return;
  const auto room = static_cast<std::size_t>(own_.tokens);
  const std::size_t needed = wire::kTeamHeadBytes + (urgent ? bytes_of(*outgoing_[urgent_[0]]) : 0);
  std::size_t said = 0;
  if (room >= needed) {
    msg::Datagram& out = frame_.loan();
    wire::TeamWriter frame({out.data.data(), room},
                           {options_.robot, own_.start, own_.sequence, step.now.ns, options_.team});
    add_echoes(frame, std::min(kMostEchoes, (room - needed) / wire::kTeamEchoBytes), step.now);
    while (said < urgent && add_message(frame, urgent_[said], step.now)) ++said;
    out.stamp = step.now;
    out.sender = options_.robot;
    out.size = static_cast<std::uint32_t>(frame.finish().size());
    own_.tokens -= static_cast<double>(out.size);
    own_.frame_at = step.now;
    ++own_.sequence;
    ++counts_.sent;
    counts_.sent_bytes += out.size;
  }
  for (std::size_t i = said; i < urgent; ++i) {
    Due& due = due_[urgent_[i]];
    if (!due.starved) ++counts_.starved, due.starved = 1, own_.changed = 1;
  }
}

std::size_t Link::bytes_of(const Outgoing& topic) noexcept {
  return wire::kTeamMessageBytes + topic.said.topic.size() + msg::cdr_size(*topic.in.type(), topic.in.get());
}

/// To the mates that were told longest ago.
void Link::add_echoes(wire::TeamWriter& frame, std::size_t most, Time now) noexcept {
  for (std::size_t n = 0; n < most; ++n) {
    MateRecord* next = nullptr;
    for (MateRecord& mate : mates_) {
      const bool fresh =
          mate.state.starts != 0 && (mate.echoed == Time{} || mate.echoed_sequence != mate.state.sequence);
      const bool due = mate.echoed == Time{} || now - mate.echoed >= kEchoEvery;
      if (fresh && due && (!next || mate.echoed < next->echoed)) next = &mate;
    }
    if (!next) return;
    const msg::MateState& state = next->state;
    frame.add(wire::TeamEcho{static_cast<std::uint16_t>(state.robot), state.start, state.sequence, state.sent.ns,
                             state.heard.ns});
    next->echoed = now;
    next->echoed_sequence = state.sequence;
  }
}

/// False: it did not fit.
bool Link::add_message(wire::TeamWriter& frame, std::size_t said, Time now) noexcept {
  const Outgoing& topic = *outgoing_[said];
  const rt::SlotHeader& header = *topic.in.header(0);
  const std::size_t size = msg::cdr_encode(*topic.in.type(), topic.in.get(), cdr_);
  const wire::TeamMessage message{topic.said.topic, topic.hash, header.sequence, header.stamp.ns, {cdr_.data(), size}};
  if (!frame.add(message)) return false;
  Due& due = due_[said];
  due.at = due.at + topic.period <= now ? now + topic.period : due.at + topic.period;
  due.any = 1;
  due.sequence = header.sequence;
  due.starved = 0;
  return true;
}

void Link::publish_state(Time now) noexcept {
  msg::TeamState& all = state_.loan();
  all = counts_;
  all.stamp = now;
  for (std::size_t i = 0; i < mates_.size(); ++i) {
    msg::MateState& mate = all.mate[i];
    mate = mates_[i].state;
    if (!mates_[i].clock.any()) continue;
    const auto e = mates_[i].clock.at(mate.heard);
    mate.clock_offset_ns = e.offset.count();
    mate.clock_bound_ns = e.bound.count();
    mate.clock_drift = e.drift;
  }
  own_.state_at = now;
  own_.changed = 0;
}

}  // namespace sinew::team
