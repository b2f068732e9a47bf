#include "drivers/joints/dronecan_node.hpp"

#include <algorithm>
#include <bit>

namespace sinew::drivers {
namespace {

using namespace std::chrono_literals;
using wire::DronecanId;
using wire::DronecanWanted;

constexpr DronecanWanted kNodeHeard[] = {wire::kDronecanNodeStatus, wire::kDronecanGetNodeInfo,
                                         wire::kDronecanAllocation};
constexpr int kAnswerFramesPerTick = 2;
constexpr std::uint8_t kCommandPriority = 8, kStatusPriority = 24, kAnswerPriority = 30;
constexpr Duration kStatusPeriod =
    1s;  // the most that the specification allows is 1 s: NodeStatus.MAX_BROADCASTING_PERIOD
constexpr Duration kArmingPeriod = 500ms;
constexpr Duration kAllocationTimeout = 500ms;  // Allocation.FOLLOWUP_TIMEOUT

}  // namespace

std::string check_dronecan_node(const DronecanNodeConfig& config) {
  const auto allowed = [](std::uint8_t id) { return id >= 1 && id <= wire::kDronecanMaxNode; };
  if (!allowed(config.node_id)) return "dronecan: node_id: 1..127";
  if (config.name.empty() || config.name.size() > 80) return "dronecan: name: 1 to 80 characters";
  for (std::size_t i = 0; i < config.allocation.size(); ++i) {
    const auto& a = config.allocation[i];
    if (!allowed(a.node_id) || a.node_id == config.node_id)
      return "dronecan: allocation: node_id: 1..127, and not ours";
    for (std::size_t k = 0; k < i; ++k)
      if (config.allocation[k].node_id == a.node_id || config.allocation[k].unique_id == a.unique_id)
        return "dronecan: allocation: each node id and each unique id once";
  }
  return {};
}

DronecanNode::DronecanNode(const DronecanNodeConfig& config) : config_(config), assembler_(kNodeHeard, 2) {
  const std::uint32_t own = config_.node_id;
  interests_ = {{wire::kDronecanNodeStatus.type << 8u | own, 0x00FFFFFF, true},
                {1u << 16 | 0x8000u | own << 8 | 0x80u, 0x00FFFF80, true}};
  if (!config_.allocation.empty()) listen_for_askers();
  info_.set_name(config_.name);
  info_.unique_id = config_.unique_id;
}

void DronecanNode::listen_for_askers() { interests_.push_back({wire::kDronecanAllocation.type << 8u, 0x3FF, true}); }

void DronecanNode::allocate(const wire::DronecanUniqueId& unique_id, std::uint8_t node_id) {
  if (config_.allocation.empty()) listen_for_askers();
  config_.allocation.push_back({unique_id, node_id});
}

BusNeed DronecanNode::need(double tick_hz) const {
  const auto frames = [](std::size_t bytes) { return bytes <= 7 ? 1.0 : static_cast<double>((bytes + 2 + 6) / 7); };
  msg::CanFrame full;
  full.size = 8, full.flags = msg::kCanExtended;
  BusNeed need;
  need.add(full, 1 + 1 / msg::seconds(kArmingPeriod));
  for (std::size_t left = actuators_; left > 0; left -= std::min<std::size_t>(left, 15))
    need.add(full, tick_hz * frames(4 * std::min<std::size_t>(left, 15)));
  if (escs_ > 0) need.add(full, tick_hz * frames((14 * escs_ + 7) / 8));
  return need;
}

void DronecanNode::set_actuator(std::uint8_t actuator_id, wire::DronecanCommandType type, double value) noexcept {
  if (command_count_ == commands_.size()) return;
  commands_[command_count_++] = {actuator_id, static_cast<std::uint8_t>(type), value};
}

void DronecanNode::set_esc(std::size_t index, std::int16_t command) noexcept {
  if (index < raw_.command.size()) raw_.command[index] = command;
}

void DronecanNode::send_short(const DronecanId& id, std::uint64_t signature, std::uint8_t transfer,
                              std::span<const std::uint8_t> payload, FrameSink& out) const noexcept {
  wire::DronecanSplitter splitter(id, signature, transfer, payload);
  msg::CanFrame frame;
  if (splitter.next(frame)) out.send(frame);
}

void DronecanNode::send_all(const DronecanWanted& type, std::uint8_t priority, std::uint8_t& transfer,
                            std::span<const std::uint8_t> payload, FrameSink& out) noexcept {
  DronecanId id;
  id.priority = priority, id.type = type.type, id.source = config_.node_id;
  wire::DronecanSplitter splitter(id, type.signature, transfer, payload);
  transfer = static_cast<std::uint8_t>((transfer + 1) & 31);
  for (msg::CanFrame frame; splitter.next(frame);) out.send(frame);
}

void DronecanNode::say_status(Time now, FrameSink& out) noexcept {
  info_.status.uptime_s = static_cast<std::uint32_t>((now - started_) / 1s);
  std::array<std::uint8_t, 7> bytes{};
  send_all(wire::kDronecanNodeStatus, kStatusPriority, status_transfer_,
           std::span(bytes).first(encode(info_.status, bytes)), out);
}

void DronecanNode::say_armed(Time now, FrameSink& out) noexcept {
  if (armed_ == said_armed_ && now < armed_at_) return;
  armed_at_ = now + kArmingPeriod;
  said_armed_ = armed_;
  std::array<std::uint8_t, 1> bytes{};
  send_all(wire::kDronecanArmingStatus, kCommandPriority, arming_transfer_,
           std::span(bytes).first(encode(wire::DronecanArmingStatus{armed_}, bytes)), out);
}

void DronecanNode::begin(Time now, FrameSink& out) noexcept {
  command_count_ = 0;
  armed_ = false;
  raw_ = {};
  raw_.count = static_cast<std::uint8_t>(std::min(escs_, raw_.command.size()));
  if (!begun_) {
    begun_ = true;
    started_ = status_at_ = now;
  }
  if (now >= status_at_) {
    status_at_ = std::max(status_at_ + kStatusPeriod, now);
    say_status(now, out);
  }
  msg::CanFrame frame;
  for (int i = 0; answer_ && i < kAnswerFramesPerTick; ++i) {
    if (answer_->next(frame))
      out.send(frame);
    else
      answer_.reset();
  }
}

void DronecanNode::end(Time now, FrameSink& out) noexcept {
  say_armed(now, out);
  std::array<std::uint8_t, 60> bytes{};
  for (std::size_t at = 0; at < command_count_;) {
    wire::DronecanActuatorCommand command;
    while (at < command_count_ && command.count < command.command.size())
      command.command[command.count++] = commands_[at++];
    send_all(wire::kDronecanActuatorCommand, kCommandPriority, actuator_transfer_,
             std::span(bytes).first(encode(command, bytes)), out);
  }
  if (raw_.count > 0)
    send_all(wire::kDronecanEscRawCommand, kCommandPriority, esc_transfer_, std::span(bytes).first(encode(raw_, bytes)),
             out);
}

bool DronecanNode::answer(const DronecanId& id, std::uint64_t signature, std::uint8_t transfer,
                          std::size_t size) noexcept {
  answer_.emplace(id, signature, transfer, std::span(answer_bytes_).first(size));
  ++stats_.answers;
  return true;
}

Heard DronecanNode::on_frame(const msg::CanFrame& frame, Time now) noexcept {
  wire::DronecanTransfer transfer;
  using Parts = wire::DronecanAssembler::Heard;
  switch (assembler_.push(frame, now, config_.node_id, transfer)) {
    case Parts::foreign:
      return Heard::foreign;
    case Parts::partial:
      return Heard::mine;
    case Parts::broken:
      return Heard::malformed;
    case Parts::complete:
      break;
  }
  if (transfer.id.service) return transfer.id.request ? on_info_request(transfer) : Heard::foreign;
  if (transfer.id.type == wire::kDronecanNodeStatus.type) {
    if (transfer.id.source != config_.node_id) return Heard::foreign;
    ++stats_.own_id_heard;
    return Heard::mine;
  }
  return transfer.id.source == 0 ? on_allocation(transfer, now) : Heard::foreign;
}

Heard DronecanNode::on_info_request(const wire::DronecanTransfer& transfer) noexcept {
  ++stats_.info_requests;
  if (answer_) {
    ++stats_.answers_dropped;
    return Heard::mine;
  }
  DronecanId id = transfer.id;
  id.request = false;
  std::swap(id.source, id.destination);
  answer(id, wire::kDronecanGetNodeInfo.signature, transfer.transfer_id, encode(info_, answer_bytes_));
  return Heard::mine;
}

Heard DronecanNode::on_allocation(const wire::DronecanTransfer& transfer, Time now) noexcept {
  wire::DronecanAllocation asked;
  if (!decode(transfer.payload, asked)) return Heard::malformed;
  if (config_.allocation.empty()) return Heard::foreign;
  if (asked_size_ != 0 && now - asked_at_ > kAllocationTimeout) asked_size_ = 0;
  if (asked.first_part) asked_size_ = 0;
  // First and second requests have six bytes, the third four; anything else belongs to no sequence that we know of.
  const std::size_t expected = asked_size_ == 12 ? 4 : 6;
  if ((!asked.first_part && asked_size_ == 0) || asked.size != expected) return Heard::malformed;
  std::copy_n(asked.unique_id.begin(), asked.size, asked_.begin() + static_cast<std::ptrdiff_t>(asked_size_));
  asked_size_ += asked.size;
  asked_at_ = now;
  give(now);
  return Heard::mine;
}

/// Repeats the known bytes of the unique id; when all are known, gives the node id.
void DronecanNode::give(Time /*now*/) noexcept {
  const auto matches = [&](const DronecanNodeConfig::Allocated& a) {
    return std::equal(asked_.begin(), asked_.begin() + static_cast<std::ptrdiff_t>(asked_size_), a.unique_id.begin());
  };
  const auto found = std::find_if(config_.allocation.begin(), config_.allocation.end(), matches);
  if (found == config_.allocation.end()) {
    ++stats_.allocation_unknown;
    asked_size_ = 0;
    return;
  }
  if (answer_) {
    ++stats_.answers_dropped;  // it asks again
    asked_size_ = 0;
    return;
  }
  wire::DronecanAllocation given;
  given.unique_id = asked_;
  given.size = static_cast<std::uint8_t>(asked_size_);
  const bool whole = asked_size_ == asked_.size();
  if (whole) {
    given.node_id = found->node_id;
    ++stats_.allocated;
    asked_size_ = 0;
  }
  DronecanId id;
  id.priority = kAnswerPriority, id.type = wire::kDronecanAllocation.type, id.source = config_.node_id;
  answer(id, wire::kDronecanAllocation.signature, allocation_transfer_, encode(given, answer_bytes_));
  allocation_transfer_ = static_cast<std::uint8_t>((allocation_transfer_ + 1) & 31);
}

DronecanNodeStats DronecanNode::stats() const noexcept {
  DronecanNodeStats out = stats_;
  out.transfers = assembler_.stats();
  return out;
}

}  // namespace sinew::drivers
