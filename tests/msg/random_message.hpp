#pragma once
// Messages of any type with contents that a codec might stumble over, in memory shaped like a slot.
#include <cstring>
#include <limits>
#include <new>
#include <vector>

#include "math/random.hpp"
#include "msg/all.hpp"
#include "msg/bulk.hpp"
#include "msg/text.hpp"

namespace sinew::test {

inline constexpr std::uint32_t kBulkCapacity = 4096;

/// A struct and its bulk, at their defaults.
class Slot {
 public:
  explicit Slot(const msg::TypeInfo& type, std::uint32_t bulk_capacity = kBulkCapacity)
      : type_(type), bulk_capacity_(bulk_capacity), words_((type.size + bulk_capacity + 63) / 8) {
    reset();
  }
  void reset() {
    type_.reset(get());
    if (type_.has_bulk()) type_.set_bulk_capacity(get(), bulk_capacity_);
  }
  void* get() { return words_.data(); }
  const void* get() const { return words_.data(); }
  std::uint8_t* bytes() { return reinterpret_cast<std::uint8_t*>(words_.data()); }

 private:
  const msg::TypeInfo& type_;
  std::uint32_t bulk_capacity_;
  std::vector<std::uint64_t> words_;
};

template <class F, class Bits>
void put_float(math::Random& random, std::uint8_t* p) {
  using Limits = std::numeric_limits<F>;
  const F special[] = {F(0),
                       -F(0),
                       F(1),
                       Limits::denorm_min(),
                       -Limits::denorm_min(),
                       Limits::min(),
                       Limits::max(),
                       -Limits::max(),
                       Limits::infinity(),
                       -Limits::infinity(),
                       F(0.1),
                       Limits::lowest() / 3,
                       Limits::quiet_NaN()};
  const std::uint32_t choice = random.below(2 * std::size(special));
  F value;
  if (choice < std::size(special)) {
    value = special[choice];
  } else {
    const Bits bits = static_cast<Bits>(random.next_u64());  // any pattern, NaNs of all kinds among them
    std::memcpy(&value, &bits, sizeof value);
  }
  std::memcpy(p, &value, sizeof value);
}

inline void fill(const msg::TypeInfo& type, math::Random& random, std::uint8_t* p) {
  for (const msg::FieldInfo& f : type.fields)
    for (std::uint32_t i = 0; i < f.count; ++i) {
      const std::uint32_t size = f.kind == msg::Kind::nested ? f.nested->size : msg::size_of(f.kind);
      std::uint8_t* at = p + f.offset + i * size;
      if (f.kind == msg::Kind::nested) {
        fill(*f.nested, random, at);
      } else if (f.kind == msg::Kind::f64) {
        put_float<double, std::uint64_t>(random, at);
      } else if (f.kind == msg::Kind::f32) {
        put_float<float, std::uint32_t>(random, at);
      } else {
        const std::uint64_t choices[] = {0, 1, ~0ull, 1ull << 63, ~0ull >> 1, random.next_u64(), random.below(60)};
        const std::uint64_t value = choices[random.below(std::size(choices))];
        std::memcpy(at, &value, size);
      }
    }
}

/// A message of random contents; its bulk is filled as far as the random fields say it is used.
inline Slot random_message(const msg::TypeInfo& type, math::Random& random) {
  Slot slot(type);
  fill(type, random, slot.bytes());
  if (type.has_bulk()) {
    type.set_bulk_capacity(slot.get(), kBulkCapacity);
    for (std::uint32_t i = 0; i < kBulkCapacity; ++i)
      slot.bytes()[type.size + i] = static_cast<std::uint8_t>(random.next_u32());
  }
  return slot;
}

}  // namespace sinew::test
