#include "rt/module_rig.hpp"

#include <algorithm>
#include <cstring>

#include "math/hash.hpp"
#include "rt/parameters.hpp"
#include "rt/trap.hpp"

namespace sinew::rt {
namespace {

using PortKind = Declaration::PortKind;

bool is_input(const Declaration::Port& p) { return p.kind == PortKind::latest || p.kind == PortKind::queue; }

ConnectionPlan connection_of(const Declaration::Port& port) {
  using Kind = ConnectionPlan::Kind;
  const Kind queue = port.overflow == Overflow::drop_oldest ? Kind::drop_oldest : Kind::drop_newest;
  return {port.kind == PortKind::latest ? Kind::latest : queue, port.depth, false};
}

class EmptyBoard final : public hal::Board {
 public:
  hal::Result<hal::Imu*> imu(std::string_view) override { return none(); }
  hal::Result<hal::Range*> range(std::string_view) override { return none(); }
  hal::Result<hal::Baro*> baro(std::string_view) override { return none(); }
  hal::Result<hal::Camera*> camera(std::string_view) override { return none(); }
  hal::Result<hal::Actuators*> actuators(std::string_view) override { return none(); }

 private:
  static hal::Error none() { return {hal::Errc::not_found, "the rig has no devices"}; }
};

class RigSetup final : public Setup {
 public:
  RigSetup(hal::Board& board, const std::string& name, std::vector<std::string>& explanations)
      : board_(board), name_(name), explanations_(explanations) {}
  hal::Board& board() override { return board_; }
  std::string_view module_name() const override { return name_; }
  void explain(std::string text) override { explanations_.push_back(std::move(text)); }

 private:
  hal::Board& board_;
  const std::string& name_;
  std::vector<std::string>& explanations_;
};

}  // namespace

struct ModuleRig::Feed {
  std::unique_ptr<Commit> commit;
  void flush(Time published) {
    if (commit->loans(0)) commit->commit({published});
  }
};

ModuleRig::ModuleRig(Module& module, RigOptions options)
    : module_(module), driver_(dynamic_cast<DriverModule*>(&module)), options_(std::move(options)) {
  module_.declare(declaration_);
  build();
  module_.reset();
}

ModuleRig::~ModuleRig() = default;

void ModuleRig::build() {
  SegmentPlan plan(SegmentOptions{.first_sequence = options_.first_sequence});
  const auto& ports = declaration_.ports;
  std::vector<WriterId> writer(ports.size());
  std::vector<ConnectionId> connection(ports.size());
  bool has_outputs = false;
  WriterId outputs = 0;
  for (std::size_t p = 0; p < ports.size(); ++p) {
    const bool output = ports[p].kind == PortKind::output;
    if (output && !has_outputs) outputs = plan.add_writer(options_.name);
    has_outputs |= output;
    writer[p] = output ? outputs : plan.add_writer(ports[p].name);
    TopicPlan topic{.name = ports[p].name, .type = ports[p].type};
    topic.bulk_bytes = ports[p].type->has_bulk() ? options_.image_bytes : 0;
    topic.burst = std::max(ports[p].burst, 1U);
    const TopicId id = plan.add_topic(writer[p], std::move(topic));
    if (!output) connection[p] = plan.connect(id, connection_of(ports[p]));
  }
  segment_ = std::make_unique<Segment>(plan);
  latch_ = std::make_unique<Latch>(*segment_);
  if (has_outputs) outputs_ = std::make_unique<Commit>(*segment_, outputs);
  raws_.resize(ports.size());
  feeds_.resize(ports.size());
  sent_through_.resize(ports.size());
  std::uint32_t next_output = 0;
  for (std::size_t p = 0; p < ports.size(); ++p) {
    if (ports[p].kind == PortKind::output) {
      sent_through_[p] = {outputs_.get(), next_output};
      outputs_->bind(*ports[p].output, next_output++);
      continue;
    }
    auto commit = std::make_unique<Commit>(*segment_, writer[p]);
    if (is_input(ports[p])) {
      feeds_[p] = std::make_unique<Feed>(Feed{std::move(commit)});
    } else {
      commit->bind(*ports[p].output, 0);
      sent_through_[p] = {commit.get(), 0};
      raws_[p] = std::move(commit);
    }
    latch_->bind(*ports[p].input, connection[p], ports[p].max_age);
  }
}

void ModuleRig::set(std::string_view param, const ParamValue& value) {
  if (!accepts(param, value)) bug("parameter does not exist or refuses the value", param);
  assign(*find_param(declaration_, param), value);
}

bool ModuleRig::accepts(std::string_view param, const ParamValue& value) const {
  const Declaration::Param* p = find_param(declaration_, param);
  return p && rt::accepts(*p, value);
}

hal::Status ModuleRig::configure(hal::Board& board) {
  RigSetup setup(board, options_.name, explanations_);
  hal::Status configured = module_.configure(setup);
  if (configured) reset();
  return configured;
}

hal::Status ModuleRig::configure() {
  EmptyBoard board;
  return configure(board);
}

void ModuleRig::reset() {
  module_.reset();
  number_ = 0;
}

std::uint32_t ModuleRig::port_index(std::string_view name, bool input, const msg::TypeInfo& type) const {
  for (std::uint32_t p = 0; p < declaration_.ports.size(); ++p) {
    const Declaration::Port& port = declaration_.ports[p];
    if (port.name != name || is_input(port) != input) continue;
    if (port.type != &type) bug("port has another message type", name);
    return p;
  }
  bug(input ? "no such input" : "no such output", name);
}

void ModuleRig::put_erased(std::string_view input, const msg::TypeInfo& type, const void* message, Time published) {
  void* slot = loan_erased(input, type);
  const auto bulk = msg::bulk_of(type, message);
  if (bulk.size() > options_.image_bytes) bug("message is larger than RigOptions::image_bytes", input);
  std::memcpy(slot, message, type.size + bulk.size());
  if (type.has_bulk()) type.set_bulk_capacity(slot, options_.image_bytes);
  feeds_[port_index(input, true, type)]->flush(published);
}

void* ModuleRig::loan_erased(std::string_view input, const msg::TypeInfo& type) {
  Feed& feed = *feeds_[port_index(input, true, type)];
  feed.flush(now_);
  return feed.commit->try_loan(0);
}

Status ModuleRig::step(Time now, Duration dt, bool timed_out) {
  now_ = now;
  if (dt <= Duration{0}) bug("dt must be more than 0", options_.name);
  for (const auto& feed : feeds_)
    if (feed) feed->flush(now);
  if (driver_) driver_->collect(now);
  for (const auto& raw : raws_)
    if (raw) raw->commit({now});
  latch_->latch();
  math::Random random(options_.seed, static_cast<std::uint32_t>(math::fnv1a64(options_.name)), number_);
  Status status;
  {
    const Step step{now, dt, timed_out, number_++, random};
    const trap::Scope scope(options_.name.c_str(), declaration_.is_best_effort ? &best_effort_calls_ : nullptr);
    status = module_.step(step);
  }
  if (outputs_) {
    if (status == Status::ok)
      outputs_->commit({now});
    else
      outputs_->discard();
  }
  if (status == Status::ok && driver_) driver_->emit(now);
  latch_->release();
  return status;
}

std::span<const SlotHeader* const> ModuleRig::sent_erased(std::string_view output, const msg::TypeInfo& type) const {
  const auto& [commit, index] = sent_through_[port_index(output, false, type)];
  return commit->committed(index);
}

}  // namespace sinew::rt
