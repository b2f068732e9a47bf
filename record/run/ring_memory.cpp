#include "record/run/ring_memory.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <new>

namespace sinew::record {
namespace {

constexpr std::uint32_t kRingMagic = 0x474E4952, kRingVersion = 1;  // "RING"

}  // namespace

/// 32-bit words only: another process maps it.
struct RingMemory::Header {
  std::uint32_t magic, version, slot_bytes;
  std::atomic<std::uint32_t> newest;  // number of the newest part; 0: none yet
  struct Slot {
    std::atomic<std::uint32_t> number, size;  // release: what it counts is there; partner: parts()
  };
  std::array<Slot, kSlots> slots;
  std::array<char, kMaxFolder + 1> folder;
};

static_assert(std::atomic<std::uint32_t>::is_always_lock_free && sizeof(std::atomic<std::uint32_t>) == 4);

/// A file in a slot.
class RingMemory::Part final : public hal::OutputFile {
 public:
  Part(std::span<std::byte> room, std::atomic<std::uint32_t>& size) : room_(room), size_(size) {}
  hal::Status append(hal::Parts parts) noexcept override {
    std::size_t at = size_.load(std::memory_order_relaxed), size = 0;
    for (const auto& part : parts) size += part.size();
    if (size > room_.size() - at) return hal::Error{hal::Errc::io, "flight ring: a part is full", ENOSPC};
    for (const auto& part : parts) {
      if (!part.empty()) std::memcpy(&room_[at], part.data(), part.size());
      at += part.size();
    }
    size_.store(static_cast<std::uint32_t>(at), std::memory_order_release);
    return {};
  }
  hal::Status sync() noexcept override { return {}; }
  hal::Status cut(std::uint64_t size) noexcept override {
    size_.store(static_cast<std::uint32_t>(size), std::memory_order_release);
    return {};
  }
  hal::Result<std::uint64_t> free_bytes() noexcept override {
    return std::uint64_t{room_.size() - size_.load(std::memory_order_relaxed)};
  }

 private:
  std::span<std::byte> room_;
  std::atomic<std::uint32_t>& size_;
};

RingMemory::Header& RingMemory::header() const { return *std::launder(reinterpret_cast<Header*>(memory_.data())); }

hal::Result<RingMemory> RingMemory::create(std::span<std::byte> memory) {
  if (memory.size() < kLeastBytes || memory.size() / kSlots > UINT32_MAX)
    return hal::Error{hal::Errc::bad_argument, "flight ring: its size", static_cast<std::int64_t>(memory.size())};
  RingMemory ring(memory);
  auto* header = new (memory.data()) Header{};
  header->magic = kRingMagic, header->version = kRingVersion;
  header->slot_bytes = static_cast<std::uint32_t>((memory.size() - sizeof(Header)) / kSlots);
  return ring;
}

std::optional<RingMemory> RingMemory::open(std::span<std::byte> memory) {
  if (memory.size() < sizeof(Header)) return std::nullopt;
  RingMemory ring(memory);
  const Header& h = ring.header();
  if (h.magic != kRingMagic || h.version != kRingVersion || h.slot_bytes > (memory.size() - sizeof(Header)) / kSlots)
    return std::nullopt;
  return ring;
}

std::size_t RingMemory::slot_bytes() const { return header().slot_bytes; }

std::span<std::byte> RingMemory::slot(unsigned i) const {
  return memory_.subspan(sizeof(Header) + i * slot_bytes(), slot_bytes());
}

unsigned RingMemory::next_slot() const { return header().newest.load(std::memory_order_relaxed) % kSlots; }

std::unique_ptr<hal::OutputFile> RingMemory::next_part() {
  Header& h = header();
  const std::uint32_t number = h.newest.load(std::memory_order_relaxed) + 1;
  const unsigned i = next_slot();
  h.slots[i].number.store(0, std::memory_order_release);  // not a part while it is emptied
  h.slots[i].size.store(0, std::memory_order_release);
  h.slots[i].number.store(number, std::memory_order_release);
  h.newest.store(number, std::memory_order_release);
  return std::make_unique<Part>(slot(i), h.slots[i].size);
}

std::vector<std::span<const std::byte>> RingMemory::parts() const {
  const Header& h = header();
  std::vector<std::pair<std::uint32_t, std::span<const std::byte>>> found;
  for (unsigned i = 0; i < kSlots; ++i) {
    const std::uint32_t number = h.slots[i].number.load(std::memory_order_acquire);
    const std::size_t size = std::min<std::size_t>(h.slots[i].size.load(std::memory_order_acquire), h.slot_bytes);
    if (number != 0 && size != 0) found.emplace_back(number, slot(i).first(size));
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::span<const std::byte>> parts;
  for (const auto& [number, bytes] : found) parts.push_back(bytes);
  return parts;
}

std::size_t RingMemory::bytes_used() const {
  std::size_t used = 0;
  for (const auto& part : parts()) used += part.size();
  return used;
}

void RingMemory::set_folder(std::string_view folder) {
  auto& kept = header().folder;
  kept.fill('\0');
  if (folder.size() <= kMaxFolder) std::copy(folder.begin(), folder.end(), kept.begin());
}

std::string RingMemory::folder() const {
  const auto& kept = header().folder;
  return {kept.begin(), std::find(kept.begin(), kept.end() - 1, '\0')};
}

}  // namespace sinew::record
