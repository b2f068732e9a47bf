#include "record/run/message_store.hpp"

#include <algorithm>
#include <cstring>
#include <new>

#include "msg/bulk.hpp"
#include "msg/cdr.hpp"

namespace sinew::record {
namespace {

constexpr std::size_t kAlign = alignof(rt::SlotHeader);

void release(std::byte* p) { ::operator delete[](p, std::align_val_t{kAlign}); }

constexpr std::uint64_t kMostPixels = std::uint64_t{msg::kMaxImageWidth} * msg::kMaxImageHeight * 3;

bool before(std::uint32_t a, std::uint32_t b) { return static_cast<std::int32_t>(a - b) < 0; }

}  // namespace

MessageStore::Entry& MessageStore::place(std::uint32_t sequence, rt::Time published, std::size_t bulk) {
  auto at = std::lower_bound(entries_.begin(), entries_.end(), sequence,
                             [](const Entry& e, std::uint32_t s) { return before(e.sequence, s); });
  if (at == entries_.end() || at->sequence != sequence) {
    Entry fresh;
    if (!spare_.empty()) {
      fresh = std::move(spare_.back());
      spare_.pop_back();
    }
    fresh.sequence = sequence;
    fresh.whole = false;
    fresh.head.reset();
    fresh.pixels = 0;
    at = entries_.insert(at, std::move(fresh));
  }
  at->published = published;
  if (!at->memory || at->capacity < bulk) {
    const std::size_t bytes = sizeof(rt::SlotHeader) + type_->size + bulk;
    decltype(at->memory) memory(static_cast<std::byte*>(::operator new[](bytes, std::align_val_t{kAlign})), &release);
    new (memory.get()) rt::SlotHeader;
    type_->reset(memory.get() + sizeof(rt::SlotHeader));
    at->memory = std::move(memory);
    at->capacity = bulk;
    at->pixels = 0;
  }
  auto* header = reinterpret_cast<rt::SlotHeader*>(at->memory.get());
  header->sequence = sequence;
  header->published = published;
  return *at;
}

bool MessageStore::add(std::uint32_t sequence, rt::Time published, std::span<const std::byte> cdr) {
  Entry& entry = place(sequence, published, 0);
  auto* header = reinterpret_cast<rt::SlotHeader*>(entry.memory.get());
  const auto decoded =
      msg::cdr_decode(*type_, {reinterpret_cast<const std::uint8_t*>(cdr.data()), cdr.size()}, header->message());
  if (!decoded) return false;
  for (const msg::FieldInfo& f : type_->fields)
    if (f.name == "stamp" && f.kind == msg::Kind::i64 && !f.is_array)
      std::memcpy(&header->stamp, static_cast<const std::byte*>(header->message()) + f.offset, sizeof header->stamp);
  return entry.whole = true;
}

/// An image is whole when it has as many pixels as its head says.
void MessageStore::settle(Entry& entry) {
  const auto* image = static_cast<const msg::Image*>(entry.message());
  entry.whole = entry.head && entry.pixels == image->bulk_used();
}

bool MessageStore::add_head(std::uint32_t sequence, rt::Time published, std::span<const std::byte> cdr) {
  ImageHead head;
  if (!decode(cdr, head)) return false;
  const std::uint64_t used = std::min<std::uint64_t>(std::uint64_t{head.stride} * head.height, head.capacity_bytes);
  if (used > kMostPixels) return false;
  Entry& entry = place(sequence, published, static_cast<std::size_t>(used));
  entry.head = head;
  auto* header = reinterpret_cast<rt::SlotHeader*>(entry.memory.get());
  header->stamp = head.stamp;
  auto& image = *static_cast<msg::Image*>(header->message());
  image.stamp = head.stamp;
  image.exposure_ns = head.exposure_ns;
  image.frame_number = head.frame_number;
  image.width = head.width, image.height = head.height, image.stride = head.stride;
  image.format = static_cast<msg::PixelFormat>(head.format);
  image.capacity_bytes = head.capacity_bytes;  // the claimed capacity; the used bytes are there
  settle(entry);
  return true;
}

bool MessageStore::add_pixels(std::uint32_t sequence, rt::Time published, std::span<const std::byte> cdr) {
  const auto pixels = image_pixels(cdr);
  if (!pixels || pixels->size() > kMostPixels) return false;
  set_pixels(sequence, published, *pixels);
  return true;
}

void MessageStore::set_pixels(std::uint32_t sequence, rt::Time published, std::span<const std::byte> pixels) {
  Entry& entry = place(sequence, published, pixels.size());
  auto* header = reinterpret_cast<rt::SlotHeader*>(entry.memory.get());
  if (!pixels.empty()) std::memcpy(static_cast<msg::Image*>(header->message())->pixels(), pixels.data(), pixels.size());
  entry.pixels = pixels.size();
  settle(entry);
}

void MessageStore::put(std::uint32_t sequence, const rt::SlotHeader& message) {
  const auto bulk = msg::bulk_of(*type_, message.message());
  Entry& entry = place(sequence, message.published, bulk.size());
  auto* header = reinterpret_cast<rt::SlotHeader*>(entry.memory.get());
  header->stamp = message.stamp;
  std::memcpy(header->message(), message.message(), type_->size);
  if (!bulk.empty()) std::memcpy(static_cast<std::byte*>(header->message()) + type_->size, bulk.data(), bulk.size());
  entry.whole = true;
}

const MessageStore::Entry* MessageStore::newest_until(std::uint32_t sequence) const {
  const auto after = std::upper_bound(entries_.begin(), entries_.end(), sequence,
                                      [](std::uint32_t s, const Entry& e) { return before(s, e.sequence); });
  return after == entries_.begin() ? nullptr : &*(after - 1);
}

const MessageStore::Entry* MessageStore::find(std::uint32_t sequence) const {
  if (entries_.empty()) return nullptr;
  const std::uint32_t index = sequence - entries_.front().sequence;  // usually there are no gaps
  if (index < entries_.size() && entries_[index].sequence == sequence) return &entries_[index];
  const auto at = std::lower_bound(entries_.begin(), entries_.end(), sequence,
                                   [](const Entry& e, std::uint32_t s) { return before(e.sequence, s); });
  return at != entries_.end() && at->sequence == sequence ? &*at : nullptr;
}

void MessageStore::forget(rt::Time horizon, std::size_t keep, std::optional<std::uint32_t> from) {
  while (entries_.size() > keep && entries_[keep].published <= horizon) {
    if (from && !before(entries_.front().sequence, *from)) return;
    spare_.push_back(std::move(entries_.front()));
    entries_.pop_front();
  }
}

}  // namespace sinew::record
