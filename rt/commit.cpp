#include "rt/commit.hpp"

#include <bit>
#include <cstring>

#include "math/elementary.hpp"
#include "msg/compare.hpp"

namespace sinew::rt {
namespace {

/// Offset from the header to the value of its stamp: the message's `stamp`, or a place that is always 0.
std::uint32_t stamp_offset(const msg::TypeInfo& type) {
  for (const msg::FieldInfo& f : type.fields)
    if (f.name == "stamp" && f.kind == msg::Kind::i64 && !f.is_array)
      return static_cast<std::uint32_t>(sizeof(SlotHeader)) + f.offset;
  return offsetof(SlotHeader, reserved);
}

/// Copies in pieces of 16 bytes; gcc 12 does not do so without this.
inline void copy_origins(std::int64_t* to, const std::int64_t* from) {
  typedef long long Two __attribute__((vector_size(16)));
#pragma GCC unroll 4
  for (std::size_t c = 0; c < kMaxChains; c += 2) {
    Two two;
    std::memcpy(&two, from + c, sizeof two);
    std::memcpy(to + c, &two, sizeof two);
  }
}

/// The floating-point fields as pieces of 16 bytes, to look at them fast: most messages hold no NaN, and
/// msg::canonicalise() does the work where one may. The pieces are added up: a NaN in any of them makes the sum one.
/// Infinities of both signs do, too, and so may a piece that reaches over its field: then the message is looked at in
/// vain.
class NanPieces {
 public:
  explicit NanPieces(std::span<const msg::FloatRun> runs = {}) {
    add(runs, true);
    const std::size_t doubles = offsets_.size();
    add(runs, false);
    doubles_ = offsets_.data();
    floats_ = offsets_.data() + doubles;
    end_ = offsets_.data() + offsets_.size();
  }
  NanPieces(NanPieces&&) = default;  // a vector's memory moves with it
  NanPieces& operator=(NanPieces&&) = default;

  bool may_hold_nan(const std::byte* message) const {
    if (doubles_ != floats_ && sum_is_nan<double>(doubles_, floats_, message)) return true;
    return floats_ != end_ && sum_is_nan<float>(floats_, end_, message);
  }

 private:
  static constexpr std::uint32_t kPiece = 16;
  static constexpr std::size_t kAtOnce = 4;

  /// The last piece is repeated up to a multiple of kAtOnce.
  void add(std::span<const msg::FloatRun> runs, bool doubles) {
    const std::size_t before = offsets_.size();
    for (const msg::FloatRun& run : runs) {
      if (run.is_f64 != doubles) continue;
      const std::uint32_t end = run.offset + run.count * (doubles ? 8 : 4);
      for (std::uint32_t at = run.offset; at < end; at += kPiece) {
        const bool reaches_over = at + kPiece > end && end >= kPiece;
        offsets_.push_back(reaches_over ? end - kPiece : at);
      }
    }
    while ((offsets_.size() - before) % kAtOnce != 0) offsets_.push_back(offsets_.back());
  }

  template <class Real>
  static bool sum_is_nan(const std::uint32_t* at, const std::uint32_t* end, const std::byte* message) {
    typedef Real Vector __attribute__((vector_size(kPiece)));
    Vector sum{};
    do {
#pragma GCC unroll 4
      for (std::size_t i = 0; i < kAtOnce; ++i) {
        Vector v;
        std::memcpy(&v, message + at[i], sizeof v);
        sum += v;
      }
      at += kAtOnce;
    } while (at != end);
    Real total = sum[0];
    for (std::size_t i = 1; i < kPiece / sizeof(Real); ++i) total += sum[i];
    return math::is_nan(total);
  }

  std::vector<std::uint32_t> offsets_;  // of the pieces with doubles, then of those with floats
  const std::uint32_t *doubles_ = nullptr, *floats_ = nullptr, *end_ = nullptr;
};

}  // namespace

struct alignas(64) CommitOutput {
  TopicWriter<StdAtomics> writer;
  // The writer's hand. Slots go out in the order in which they were owned: loans first, then the spare from the top.
  std::uint32_t loans = 0;      // in `hand`
  std::uint32_t spares = 0;     // in `spare`: owned, given back by cancel() or discard(); the top is the oldest
  std::uint32_t committed = 0;  // the first of `hand` after a commit, until the next loan
  std::uint32_t burst;
  std::uint32_t held = 0, most_held = 0;  // owned, in neither `hand` nor `spare`
  std::unique_ptr<SlotHeader*[]> hand, spare;
  std::unique_ptr<bool[]> is_held;  // per slot
  std::byte* slots;
  std::size_t stride;
  const SlotHeader** newest;  // of the segment's topic
  // What a message needs.
  std::uint32_t bulk_bytes, stamp_at, source_chains;
  NanPieces pieces;
  const msg::TypeInfo* type;
  std::vector<SlotQueue<StdAtomics>*> queues;
  std::unique_ptr<std::uint32_t[]> published;  // per slot: its newest sequence
  std::string_view name;
  TopicId topic;
  const Commit* owner;
  std::uint32_t index;

  void reset(void* message) const {
    type->reset(message);
    if (type->set_bulk_capacity) type->set_bulk_capacity(message, bulk_bytes);
  }
  SlotHeader* claim() noexcept;
  [[gnu::noinline]] SlotHeader* claim_any() noexcept;
  SlotHeader* take_in_hand(SlotHeader* header) noexcept;
  std::byte* message(std::uint32_t loan) const { return static_cast<std::byte*>(hand[loan]->message()); }
  bool cancel() noexcept;
  void discard() noexcept;
  SlotHeader* hold() noexcept;
  SlotHeader* let_go_of(void* message) noexcept;
  void fill(SlotHeader* header, std::uint32_t number, const CommitInfo& info) const noexcept;
  bool publish_one(std::uint32_t number, const CommitInfo& info) noexcept;
  void publish_all(std::uint32_t number, const CommitInfo& info) noexcept;
  std::span<const SlotHeader* const> last_committed() const noexcept { return {hand.get(), committed}; }
};

Commit::Commit(Segment& segment, WriterId writer)
    : log_(segment.log(writer)),
      number_(log_.number->load(std::memory_order_relaxed)),
      output_count_(log_.record_words - 1) {
  outputs_ = std::make_unique<CommitOutput[]>(output_count_);
  for (std::uint32_t i = 0; i < output_count_; ++i) {
    CommitOutput& out = outputs_[i];
    const TopicId t = segment.topic_of(writer, i);
    const TopicEntry& entry = segment.entry(t);
    Segment::Topic& topic = segment.topics_[t];
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
    out.stride = static_cast<std::size_t>(entry.slot_stride);
    out.burst = topic.sum.burst;
    out.type = topic.plan.type;
    out.pieces = NanPieces(topic.plan.type->floats);
    out.bulk_bytes = topic.plan.bulk_bytes;
    out.stamp_at = stamp_offset(*topic.plan.type);
    out.source_chains = topic.plan.source_chains;
    out.most_held = topic.sum.held;
    out.hand = std::make_unique<SlotHeader*[]>(out.burst);
    // No further slot is owned while a spare is left: loans, spares and held slots never exceed burst + most_held.
    out.spare = std::make_unique<SlotHeader*[]>(out.burst + out.most_held);
    out.is_held = std::make_unique<bool[]>(entry.slot_count);
    out.newest = &topic.newest;
    out.owner = this;
    out.index = i;
    out.topic = t;
    out.name = topic.plan.name;
  }
}

Commit::~Commit() = default;

void Commit::bind(OutputBase& port, std::uint32_t output) {
  port.output_ = &outputs_[output];
  port.bulk_bytes_ = outputs_[output].bulk_bytes;
}

/// A slot to fill, with its old content; null when the burst is used up. The common path makes no call.
inline SlotHeader* CommitOutput::claim() noexcept {
  if ((loans | spares) != 0 || writer.shared) return claim_any();
  return take_in_hand(reinterpret_cast<SlotHeader*>(slots + writer.own_in_turn() * stride));
}

SlotHeader* CommitOutput::claim_any() noexcept {
  if (loans == burst) return nullptr;
  if (spares != 0) return take_in_hand(spare[--spares]);
  const std::uint32_t slot = writer.own();
  if (slot == kNoSlot) bug("out of slots: somebody holds more messages than planned", name);
  return take_in_hand(reinterpret_cast<SlotHeader*>(slots + slot * stride));
}

inline SlotHeader* CommitOutput::take_in_hand(SlotHeader* header) noexcept {
  hand[loans++] = header;
  return header;
}

inline bool CommitOutput::cancel() noexcept {
  if (loans == 0) return false;
  spare[spares++] = hand[--loans];
  return true;
}

SlotHeader* CommitOutput::hold() noexcept {
  if (held == most_held) return nullptr;
  SlotHeader* header = nullptr;
  if (spares != 0) {
    header = spare[--spares];
  } else {
    const std::uint32_t slot = writer.own();
    if (slot == kNoSlot) bug("out of slots: somebody holds more messages than planned", name);
    header = reinterpret_cast<SlotHeader*>(slots + slot * stride);
  }
  ++held;
  is_held[header->slot] = true;
  return header;
}

SlotHeader* CommitOutput::let_go_of(void* message) noexcept {
  const std::ptrdiff_t at = static_cast<std::byte*>(message) - slots - static_cast<std::ptrdiff_t>(sizeof(SlotHeader));
  const std::size_t slot = static_cast<std::size_t>(at) / stride;
  if (at < 0 || static_cast<std::size_t>(at) % stride != 0 || slot >= writer.slot_count || !is_held[slot])
    bug("publishes or puts back a message that it does not hold", name);
  is_held[slot] = false;
  --held;
  return static_cast<SlotHeader*>(message) - 1;
}

void CommitOutput::discard() noexcept {
  while (cancel()) {
  }
  committed = 0;
}

[[gnu::always_inline]] inline void CommitOutput::fill(SlotHeader* header, std::uint32_t number,
                                                      const CommitInfo& info) const noexcept {
  header->sequence = writer.next_sequence;
  header->commit = number;
  std::memcpy(&header->stamp, reinterpret_cast<std::byte*>(header) + stamp_at, sizeof header->stamp);
  header->published = info.now;
  copy_origins(header->origin_ns, info.origin_ns);
  for (std::uint32_t chains = source_chains; chains; chains &= chains - 1)
    header->origin_ns[std::countr_zero(chains)] = header->stamp.ns;
  *newest = header;
}

void CommitOutput::publish_all(std::uint32_t number, const CommitInfo& info) noexcept {
  for (std::uint32_t k = 0; k < loans; ++k) {
    if (pieces.may_hold_nan(message(k))) msg::canonicalise(*type, message(k));
    fill(hand[k], number, info);
    writer.publish(hand[k]->slot);
  }
  committed = loans;
  loans = 0;
}

/// The most common commit, without a call: one message on the only output, read in this thread only. False, with
/// nothing done, for any other commit.
inline bool CommitOutput::publish_one(std::uint32_t number, const CommitInfo& info) noexcept {
  if (loans != 1 || writer.shared) return false;
  SlotHeader* const header = hand[0];
  if (pieces.may_hold_nan(static_cast<std::byte*>(header->message()))) return false;
  const std::uint32_t slot = header->slot;
  fill(header, number, info);
  writer.publish_in_turn(slot);
  committed = 1;
  loans = 0;
  return true;
}

void* Commit::try_loan(std::uint32_t output) noexcept {
  CommitOutput& out = outputs_[output];
  SlotHeader* header = out.claim();
  if (!header) return nullptr;
  void* message = header->message();
  out.reset(message);
  return message;
}
bool Commit::cancel(std::uint32_t output) noexcept { return outputs_[output].cancel(); }
std::uint32_t Commit::loans(std::uint32_t output) const noexcept { return outputs_[output].loans; }

std::uint32_t Commit::held(std::uint32_t output) const noexcept { return outputs_[output].held; }

std::uint32_t Commit::commit(const CommitInfo& info) noexcept {
  const std::uint32_t number = number_ + 1;
  if (output_count_ != 1) return commit_any(info);
  CommitOutput& only = outputs_[0];
  const std::uint32_t sequence = only.writer.next_sequence;
  if (!only.publish_one(number, info)) return commit_any(info);
  number_ = number;
  log_.set_last(log_.open(number), 0, sequence);
  log_.publish(number);
  return committed_ = 1;
}

std::uint32_t Commit::commit_any(const CommitInfo& info) noexcept {
  committed_ = 0;
  for (std::uint32_t i = 0; i < output_count_; ++i) committed_ |= (outputs_[i].loans != 0 ? 1U : 0U) << i;
  if (committed_ == 0) return 0;
  ++number_;
  for (std::uint32_t i = 0; i < output_count_; ++i) outputs_[i].publish_all(number_, info);
  StdAtomics::Word* record = log_.open(number_);
  for (std::uint32_t i = 0; i < output_count_; ++i) log_.set_last(record, i, outputs_[i].writer.next_sequence - 1);
  log_.publish(number_);
  return committed_;
}

void Commit::discard() noexcept {
  committed_ = 0;
  for (std::uint32_t i = 0; i < output_count_; ++i) outputs_[i].discard();
}

std::span<const SlotHeader* const> Commit::committed(std::uint32_t output) const noexcept {
  if ((committed_ >> output & 1) == 0) return {};
  return outputs_[output].last_committed();
}

TopicId Commit::topic(std::uint32_t output) const noexcept { return outputs_[output].topic; }

// ---- the ports' side

void* OutputBase::loan_erased() {
  void* message = claim();
  output_->reset(message);
  return message;
}

void* OutputBase::claim() {
  SlotHeader* header = output_->claim();
  if (!header) bug("more loans in one step than the declared burst", output_->name);
  return header->message();
}

void* OutputBase::try_claim() {
  SlotHeader* header = output_->claim();
  return header ? header->message() : nullptr;
}

void OutputBase::cancel_newest() {
  if (!output_->cancel()) bug("cancel() without a loan", output_->name);
}

void* OutputBase::hold_slot() {
  SlotHeader* header = output_->hold();
  return header ? header->message() : nullptr;
}

bool OutputBase::publish_held(void* message) {
  if (output_->loans == output_->burst) return false;
  output_->take_in_hand(output_->let_go_of(message));
  return true;
}

void OutputBase::put_back_held(void* message) { output_->spare[output_->spares++] = output_->let_go_of(message); }

const void* OutputBase::newest_committed() const {
  const auto slots = output_->owner->committed(output_->index);
  return slots.empty() ? nullptr : slots.back()->message();
}

}  // namespace sinew::rt
