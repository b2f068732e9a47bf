#include "rt/exec/step_again.hpp"

#include <algorithm>
#include <cstring>

#include "rt/external_source.hpp"
#include "rt/guardian.hpp"
#include "rt/parameters.hpp"
#include "rt/saved_state.hpp"

namespace sinew::rt {
namespace {

using PortKind = Declaration::PortKind;

}  // namespace

StepAgain::StepAgain(Graph& graph, std::uint32_t module)
    : module_(graph.modules()[module]), code_(graph, module), output_of_port_(module_.topic.size(), kNone) {
  if (const WriterId writer = graph.output_writer(module); writer != kNone)
    outputs_ = std::make_unique<Commit>(graph.segment(), writer);
  std::uint32_t output = 0;
  for (std::size_t p = 0; p < module_.topic.size(); ++p) {
    const Declaration::Port& port = module_.declaration.ports[p];
    held_.emplace_back();
    if (module_.topic[p] == kNone) continue;
    if (port.kind == PortKind::output) {
      outputs_->bind(*port.output, output);
      output_of_port_[p] = output++;
    } else {
      held_.back() = std::make_unique<const SlotHeader*[]>(port.depth);
      port.input->slots_ = held_.back().get();
      port.input->max_age_ = port.max_age;
    }
  }
  if (module_.external) module_.external->bound();
}

StepAgain::~StepAgain() = default;

hal::Result<StepStatus> StepAgain::step(const StepRecord& recorded, std::span<const Input> inputs) {
  if (auto held = hold(inputs); !held) return held.error();
  if (recorded.number == 0 && !fresh_) reset();
  fresh_ = false;
  if (module_.driver) module_.driver->set_device_state(recorded.device_state);
  StepStatus status = StepStatus::ok;
  {
    const FpModeScope fp_mode;
    status = code_.run({recorded.now, recorded.dt, recorded.timed_out, recorded.number}, nullptr);
  }
  if (outputs_ && status == StepStatus::ok)
    outputs_->commit(commit_info(recorded.completed));
  else if (outputs_)
    outputs_->discard();
  let_go();
  return status;
}

std::span<const SlotHeader* const> StepAgain::published(std::uint32_t port) const {
  if (output_of_port_[port] == kNone) return {};
  return outputs_->committed(output_of_port_[port]);
}

hal::Status StepAgain::hold(std::span<const Input> inputs) {
  if (inputs.size() != held_.size())
    return hal::Error{hal::Errc::bad_data, "inputs for another number of ports", static_cast<int>(inputs.size())};
  for (std::size_t p = 0; p < inputs.size(); ++p) {
    const std::size_t most = held_[p] ? module_.declaration.ports[p].depth : 0;
    if (inputs[p].messages.size() > most)
      return hal::Error{hal::Errc::bad_data, "more messages than the port holds; port", static_cast<int>(p)};
  }
  for (std::size_t p = 0; p < inputs.size(); ++p) {
    if (!held_[p]) continue;
    InputBase& input = *module_.declaration.ports[p].input;
    std::copy(inputs[p].messages.begin(), inputs[p].messages.end(), held_[p].get());
    input.count_ = static_cast<std::uint32_t>(inputs[p].messages.size());
    input.updated_ = inputs[p].updated;
    input.dropped_ = inputs[p].dropped;
    input.dropped_total_ += inputs[p].dropped;
  }
  return {};
}

void StepAgain::let_go() {
  for (std::size_t p = 0; p < held_.size(); ++p)
    if (held_[p]) module_.declaration.ports[p].input->count_ = 0;
}

CommitInfo StepAgain::commit_info(Time completed) const {
  CommitInfo info{completed};
  for (std::size_t p = 0; p < held_.size(); ++p)
    if (held_[p]) module_.declaration.ports[p].input->merge_origins(module_.carried_chains[p], info.origin_ns);
  return info;
}

void StepAgain::reset() {
  module_.module->reset();
  fresh_ = true;
}

hal::Result<Effect> StepAgain::take(const Request& request, const Effect& recorded,
                                    std::span<const std::byte> message) {
  Effect effect{recorded.step, false};
  switch (request.kind) {
    case Request::Kind::set_param: {
      const auto& params = module_.declaration.params;
      const ParamValue value = std::visit([](const auto v) { return ParamValue(v); }, request.value);
      if (request.index >= params.size() || !accepts(params[request.index], value))
        return hal::Error{hal::Errc::bad_data, "no such parameter, or a value that it refuses", request.index};
      assign(params[request.index], value);
      return effect;
    }
    case Request::Kind::enable:
      if (recorded.step == 0) reset();  // it was disabled before
      return effect;
    case Request::Kind::disable:
      return effect;
    case Request::Kind::arm:
    case Request::Kind::disarm:
      if (!module_.guardian) break;
      if (request.kind == Request::Kind::arm)
        effect.refused = !module_.guardian->arm();
      else
        module_.guardian->disarm();
      return effect;
    case Request::Kind::message: {
      if (!module_.external) break;
      const auto& ports = module_.declaration.ports;
      if (request.index >= ports.size() || message.size() < ports[request.index].type->size)
        return hal::Error{hal::Errc::bad_data, "no such port, or a message of another size", request.index};
      OutsideMessage posted{.bytes = message};
      for (const msg::FieldInfo& f : ports[request.index].type->fields)  // as it was published, or as it was posted
        if (f.name == "stamp" && f.kind == msg::Kind::i64 && !f.is_array)
          std::memcpy(&posted.stamp, message.data() + f.offset, sizeof posted.stamp);
      const auto place = module_.external->stage(request.index, posted);
      if (!place) return place.error();
      module_.external->take(*place);
      return effect;
    }
    case Request::Kind::set_period:
      break;
  }
  return hal::Error{hal::Errc::bad_argument, "a request that is not for this module",
                    static_cast<std::int64_t>(request.kind)};
}

std::size_t StepAgain::state_bytes() const { return SavedState(module_.declaration).bytes(); }
std::uint64_t StepAgain::state_layout() const { return SavedState(module_.declaration).layout(); }
void StepAgain::save_state(std::span<std::byte> to) const { SavedState(module_.declaration).save(to); }

hal::Status StepAgain::restore_state(std::span<const std::byte> from) {
  const hal::Status restored = SavedState(module_.declaration).restore(from);
  if (restored) fresh_ = false;
  return restored;
}

}  // namespace sinew::rt
