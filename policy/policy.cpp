#include "policy/policy.hpp"

#include <algorithm>
#include <cstring>

#include "math/elementary.hpp"
#include "msg/actuators.hpp"

namespace sinew::policy {

struct Policy::Output {
  std::string name;
  rt::AnyOut port;
  std::optional<rt::NumberField> stamp{}, count{}, armed{};
  double channels = 0;  // of an ActuatorCommand, unless the robot file sets its count
};

Policy::Policy(PolicyOptions options, std::shared_ptr<const PolicyFile> file)
    : options_(std::move(options)), file_(std::move(file)) {
  for (std::size_t i = 0; i < observed_topics(options_).size(); ++i) in_.push_back(std::make_unique<rt::AnyIn>());
  for (std::string& name : commanded_ports(options_)) {
    out_.push_back(std::make_unique<Output>());
    out_.back()->name = std::move(name);
  }
}

Policy::~Policy() = default;

void Policy::declare(rt::Declaration& d) {
  const auto topics = observed_topics(options_);
  for (std::size_t i = 0; i < topics.size(); ++i) d.in(topic_port(topics[i]), *in_[i]);
  for (const auto& out : out_) d.out(out->name, out->port);
  d.out("state", state_);
  d.out("vectors", vectors_);
  d.param("publish_vectors", publish_vectors_, {.doc = "what the network gets and gives, each step, on `vectors`"});
  d.state(past_, sent_, carried_, put_out_, seen_, began_);
}

hal::Status Policy::configure(rt::Setup& setup) {
  std::vector<rt::Problem> problems;
  network_ = load_network(options_, *file_, problems);
  if (network_) {
    PlanTypes types;
    for (const auto& in : in_) types.topics.push_back(in->type());
    for (const auto& out : out_) types.ports.push_back(out->port.type());
    plan_ = make_plan(options_, types, *network_, problems);
  }
  for (const rt::Problem& p : problems) setup.explain(p.key + ": " + p.value + ": " + p.allowed);
  if (!problems.empty()) return hal::Error{hal::Errc::bad_argument, "policy"};

  for (std::uint32_t i = 0; i < out_.size(); ++i) {
    Output& out = *out_[i];
    const msg::TypeInfo& type = *out.port.type();
    out.stamp = rt::find_number(type, "stamp");
    if (&type != &msg::type_info<msg::ActuatorCommand>()) continue;
    out.count = rt::find_number(type, "count");
    out.armed = rt::find_number(type, "armed");
    const auto first = rt::find_number(type, "value[0]"), second = rt::find_number(type, "value[1]");
    for (const Command& c : plan_.commands) {
      if (c.port != i) continue;
      if (c.field.offset == out.count->offset || c.field.offset == out.armed->offset) continue;
      const std::uint32_t channel = (c.field.offset - first->offset) / (second->offset - first->offset);
      out.channels = std::max(out.channels, static_cast<double>(channel + 1));
    }
  }
  now_.assign(plan_.sources.size(), 0);
  commands_.assign(plan_.commands.size(), 0);
  past_.assign(plan_.past, 0);
  sent_.assign(plan_.sent, 0);
  carried_.assign(plan_.carried, 0);
  put_out_.assign(plan_.watched.size(), 0);
  seen_.assign(in_.size(), {});
  return {};
}

void Policy::reset() {
  for (auto* numbers : {&past_, &sent_, &carried_, &put_out_}) std::fill(numbers->begin(), numbers->end(), 0.0f);
  std::fill(seen_.begin(), seen_.end(), Seen{});
  began_ = 0;
}

namespace {

/// False: it was limited.
bool shape(const Shaping& s, double x, double& out) {
  out = x * s.scale + s.offset;
  if (s.high && out > *s.high) return out = *s.high, false;
  if (s.low && out < *s.low) return out = *s.low, false;
  return true;
}

}  // namespace

/// What all sources say now. False: a number is not finite.
bool Policy::sample() noexcept {
  clipped_ = 0;
  for (std::size_t i = 0; i < plan_.sources.size(); ++i) {
    const Source& s = plan_.sources[i];
    double raw = 0;
    if (s.kind == Source::Kind::field) raw = s.field.read(in_[s.topic]->get());
    if (s.kind == Source::Kind::output) raw = double{put_out_[s.output]};
    double shaped = 0;
    if (!shape(s.shaping, raw, shaped)) ++clipped_;
    now_[i] = static_cast<float>(shaped);
    if (!math::is_finite(double{now_[i]})) return false;
  }
  return true;
}

/// Before there is a past, it is like the first step.
float Policy::value_of(std::uint32_t source, std::uint32_t age) const noexcept {
  return age == 0 || began_ == 0 ? now_[source] : past_[plan_.sources[source].past + age - 1];
}

void Policy::remember() noexcept {
  for (std::size_t i = 0; i < plan_.sources.size(); ++i) {
    float* past = past_.data() + plan_.sources[i].past;
    const std::uint32_t depth = plan_.sources[i].depth;
    if (depth == 0) continue;
    if (began_ == 0) {
      std::fill_n(past, depth, now_[i]);
    } else {
      std::memmove(past + 1, past, (depth - 1) * sizeof(float));
      past[0] = now_[i];
    }
  }
}

/// False: a number that comes out is not finite.
bool Policy::run() noexcept {
  for (const Feed& f : plan_.feeds) network_->input(f.input)[f.index] = value_of(f.source, f.age);
  for (const Recurrence& r : plan_.recurrences)
    std::copy_n(carried_.data() + r.first, r.size, network_->input(r.input).data());
  network_->run();
  for (std::size_t o = 0; o < network_->outputs().size(); ++o)
    for (const float y : network_->output(o))
      if (!math::is_finite(double{y})) return false;
  return true;
}

void Policy::look_at_topics(rt::Time now) noexcept {
  for (std::size_t i = 0; i < in_.size(); ++i) {
    const rt::SlotHeader& header = *in_[i]->header(0);
    Seen& seen = seen_[i];
    const std::uint32_t arrived = seen.any ? header.sequence - seen.sequence : 1;
    seen.counts.age_ns = (now - header.stamp).count();
    seen.counts.arrived = arrived;
    if (arrived == 0) ++seen.counts.repeated;
    if (arrived > 1) seen.counts.skipped += arrived - 1;
    if (seen.any && header.stamp < seen.stamp) ++seen.counts.reordered;
    seen.any = 1;
    seen.sequence = header.sequence;
    seen.stamp = header.stamp;
  }
}

void Policy::publish(rt::Time now) noexcept {
  clipped_commands_ = 0;
  for (std::size_t i = 0; i < plan_.commands.size(); ++i) {
    const Command& c = plan_.commands[i];
    double shaped = 0;
    const double raw = c.value ? *c.value : double{network_->output(c.output)[c.index]};
    if (!shape(c.shaping, raw, shaped)) ++clipped_commands_;
    float* sent = sent_.data() + c.past;
    const auto made = static_cast<float>(shaped);
    if (began_ == 0) {
      std::fill_n(sent, c.delay + 1, made);
    } else {
      std::memmove(sent + 1, sent, c.delay * sizeof(float));
      sent[0] = made;
    }
    commands_[i] = sent[c.delay];
  }
  rt::Time oldest = now;
  for (const auto& in : in_) oldest = std::min(oldest, in->header(0)->stamp);
  for (std::uint32_t port = 0; port < out_.size(); ++port) {
    Output& out = *out_[port];
    void* message = out.port.loan();
    if (out.count) out.count->write(message, out.channels);
    if (out.armed) out.armed->write(message, 1);
    for (std::size_t i = 0; i < plan_.commands.size(); ++i)
      if (plan_.commands[i].port == port) plan_.commands[i].field.write(message, double{commands_[i]});
    if (out.stamp) std::memcpy(static_cast<std::byte*>(message) + out.stamp->offset, &oldest, sizeof oldest);
  }
  msg::PolicyState& state = state_.loan();
  state.stamp = now;
  state.topics = static_cast<std::uint32_t>(in_.size());
  for (std::size_t i = 0; i < in_.size(); ++i) state.topic[i] = seen_[i].counts;
  state.clipped = clipped_;
  state.clipped_commands = clipped_commands_;
  state.delay = plan_.most_delay;
  if (!publish_vectors_) return;
  msg::PolicyVectors& v = vectors_.loan();
  v.stamp = now;
  for (const std::uint32_t i : plan_.plain_inputs)
    for (const float x : network_->input(i))
      if (const std::uint32_t at = v.observed++; at < v.observation.size()) v.observation[at] = x;
  for (const std::uint32_t o : plan_.plain_outputs)
    for (const float y : network_->output(o))
      if (const std::uint32_t at = v.put_out++; at < v.output.size()) v.output[at] = y;
}

rt::StepStatus Policy::step(const rt::Step& step) noexcept {
  for (const auto& in : in_)
    if (!in->get()) return rt::StepStatus::stale;
  if (!sample()) return rt::StepStatus::fault;
  if (!run()) return rt::StepStatus::fault;
  // From here on nothing fails: a step that ends otherwise leaves no trace in the state.
  remember();
  for (const Recurrence& r : plan_.recurrences)
    std::copy_n(network_->output(r.output).data(), r.size, carried_.data() + r.first);
  for (std::size_t i = 0; i < plan_.watched.size(); ++i)
    put_out_[i] = network_->output(plan_.watched[i].output)[plan_.watched[i].index];
  look_at_topics(step.now);
  publish(step.now);
  began_ = 1;
  return rt::StepStatus::ok;
}

}  // namespace sinew::policy
