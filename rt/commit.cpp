#include "rt/commit.hpp"

#include <bit>
#include <cstring>

#include "msg/compare.hpp"

namespace sinew::rt {
namespace {

constexpr std::uint32_t kNoStamp = 0xFFFFFFFF;

std::uint32_t stamp_offset(const msg::TypeInfo& type) {
  for (const msg::FieldInfo& f : type.fields)
    if (f.name == "stamp" && f.kind == msg::Kind::i64 && !f.is_array) return f.offset;
  return kNoStamp;
}

}  // namespace

struct Commit::Output {
  TopicWriter<StdAtomics> writer;
  std::byte* slots;
  std::size_t stride;
  std::uint32_t burst;
  std::uint32_t owned = 0;  // slots in hand: loans of this step, then what earlier steps gave back
  std::uint32_t loans = 0;
  std::uint32_t committed = 0;
  // What a message needs.
  const msg::TypeInfo* type;
  bool has_floats;
  void (*reset)(void*);
  void (*set_bulk_capacity)(void*, std::uint32_t);
  std::uint32_t bulk_bytes, stamp_at, source_chains;
  std::vector<Segment::Queue*> queues;
  std::unique_ptr<std::uint32_t[]> hand;                 // owned slots, loans first
  std::unique_ptr<const SlotHeader*[]> committed_slots;  // of the last commit
  std::unique_ptr<std::uint32_t[]> published;            // per slot: its newest sequence
  TopicId topic;
  std::string_view name;

  SlotHeader* slot(std::uint32_t i) const { return reinterpret_cast<SlotHeader*>(slots + i * stride); }
};

Commit::Commit(Segment& segment, WriterId writer)
    : log_(segment.log(writer)), number_(log_.number->load(std::memory_order_relaxed)), output_count_(log_.outputs) {
  outputs_ = std::make_unique<Output[]>(output_count_);
  for (std::uint32_t i = 0; i < output_count_; ++i) {
    Output& out = outputs_[i];
    const TopicId t = segment.topic_of(writer, i);
    const TopicEntry& entry = segment.entry(t);
    const Segment::Topic& topic = segment.topics_[t];
    out.published = std::make_unique<std::uint32_t[]>(entry.slot_count);
    out.queues = topic.queues;
    out.writer.ring = segment.ring(t);
    out.writer.slot_count = entry.slot_count;
    out.writer.keep = topic.sum.keep;
    out.writer.shared = topic.shared;
    out.writer.published = out.published.get();
    out.writer.queues = out.queues.data();
    out.writer.queue_count = static_cast<std::uint32_t>(out.queues.size());
    out.writer.start(segment.header().first_sequence);
    out.slots = &segment.at<std::byte>(entry.slots);
    out.stride = entry.slot_stride;
    out.burst = topic.sum.burst;
    out.type = topic.plan.type;
    out.has_floats = !topic.plan.type->floats.empty();
    out.reset = topic.plan.type->reset;
    out.set_bulk_capacity = topic.plan.type->set_bulk_capacity;
    out.bulk_bytes = topic.plan.bulk_bytes;
    out.stamp_at = stamp_offset(*topic.plan.type);
    out.source_chains = topic.plan.source_chains;
    out.hand = std::make_unique<std::uint32_t[]>(out.burst);
    out.committed_slots = std::make_unique<const SlotHeader*[]>(out.burst);
    out.topic = t;
    out.name = topic.plan.name;
  }
}

Commit::~Commit() = default;

void Commit::bind(OutputBase& port, std::uint32_t output) {
  port.commit_ = this;
  port.index_ = output;
  port.burst_ = outputs_[output].burst;
}

std::uint32_t Commit::own_slot(Output& out) noexcept {
  const std::uint32_t slot = out.writer.own();
  if (slot == kNoSlot) bug("out of slots: somebody holds more messages than planned", out.name);
  return slot;
}

void* Commit::try_loan(std::uint32_t output) noexcept {
  Output& out = outputs_[output];
  if (out.loans == out.burst) return nullptr;
  if (out.loans == out.owned) out.hand[out.owned++] = own_slot(out);
  void* message = out.slot(out.hand[out.loans++])->message();
  out.reset(message);
  if (out.set_bulk_capacity) out.set_bulk_capacity(message, out.bulk_bytes);
  loaned_ |= 1U << output;
  return message;
}

bool Commit::cancel(std::uint32_t output) noexcept {
  Output& out = outputs_[output];
  if (out.loans == 0) return false;
  if (--out.loans == 0) loaned_ &= ~(1U << output);
  return true;
}

std::uint32_t Commit::loans(std::uint32_t output) const noexcept { return outputs_[output].loans; }

void Commit::publish(Output& out, std::uint32_t slot, const CommitInfo& info) noexcept {
  SlotHeader* header = out.slot(slot);
  auto* message = static_cast<std::byte*>(header->message());
  if (out.has_floats) msg::canonicalise(*out.type, message);
  header->sequence = out.writer.next_sequence;
  header->commit = number_;
  header->stamp = {};
  if (out.stamp_at != kNoStamp) std::memcpy(&header->stamp, message + out.stamp_at, sizeof header->stamp);
  header->published = info.now;
  std::memcpy(header->origin_ns, info.origin_ns, sizeof header->origin_ns);
  for (std::uint32_t chains = out.source_chains; chains; chains &= chains - 1)
    header->origin_ns[std::countr_zero(chains)] = header->stamp.ns;

  out.committed_slots[out.committed++] = header;
  out.writer.publish(slot);
}

std::uint32_t Commit::commit(const CommitInfo& info) noexcept {
  const std::uint32_t mask = loaned_;
  for (std::uint32_t bits = committed_; bits; bits &= bits - 1) outputs_[std::countr_zero(bits)].committed = 0;
  committed_ = mask;
  if (mask == 0) return 0;
  loaned_ = 0;
  log_.open(++number_);
  for (std::uint32_t i = 0; i < output_count_; ++i) {
    Output& out = outputs_[i];
    if (mask >> i & 1) {
      for (std::uint32_t k = 0; k < out.loans; ++k) publish(out, out.hand[k], info);
      out.owned -= out.loans;
      for (std::uint32_t k = 0; k < out.owned; ++k) out.hand[k] = out.hand[out.loans + k];
      out.loans = 0;
    }
    log_.set_last(number_, i, out.writer.next_sequence - 1);
  }
  log_.publish(number_);
  return mask;
}

void Commit::discard() noexcept {
  for (std::uint32_t bits = loaned_; bits; bits &= bits - 1) outputs_[std::countr_zero(bits)].loans = 0;
  for (std::uint32_t bits = committed_; bits; bits &= bits - 1) outputs_[std::countr_zero(bits)].committed = 0;
  loaned_ = committed_ = 0;
}

std::span<const SlotHeader* const> Commit::committed(std::uint32_t output) const noexcept {
  const Output& out = outputs_[output];
  return {out.committed_slots.get(), out.committed};
}

TopicId Commit::topic(std::uint32_t output) const noexcept { return outputs_[output].topic; }

}  // namespace sinew::rt
