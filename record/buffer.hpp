#pragma once
// Little-endian bytes of MCAP: a buffer to write them to, a cursor to read them from.
#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace sinew::record {

using Texts = std::map<std::string, std::string>;

inline std::span<const std::byte> as_bytes(std::string_view text) { return std::as_bytes(std::span(text)); }
inline std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Bytes that grow at the end and keep their memory when cleared.
class Buffer {
 public:
  const std::byte* data() const { return bytes_.get(); }
  std::byte* data() { return bytes_.get(); }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  std::span<const std::byte> bytes() const { return {bytes_.get(), size_}; }
  void clear() { size_ = 0; }
  void reserve(std::size_t capacity) {
    if (capacity > capacity_) grow(capacity);
  }
  /// Room for `size` more bytes, which the caller fills.
  std::byte* extend(std::size_t size) {
    if (size > capacity_ - size_) grow(size_ + size);
    std::byte* at = bytes_.get() + size_;
    size_ += size;
    return at;
  }
  /// Makes it exactly `size` long; new bytes are not initialised.
  void resize(std::size_t size) {
    reserve(size);
    size_ = size;
  }

  void append(std::span<const std::byte> bytes) {
    if (!bytes.empty()) std::memcpy(extend(bytes.size()), bytes.data(), bytes.size());
  }
  template <class T>
  void number(T value) {
    put(extend(sizeof value), value);
  }
  void text(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size()));
    append(as_bytes(text));
  }
  void texts(const Texts& map) {
    const std::size_t at = begin_length<std::uint32_t>();
    for (const auto& [key, value] : map) text(key), text(value);
    end_length<std::uint32_t>(at);
  }
  /// A length that is known only when the bytes that it counts are there.
  template <class T>
  std::size_t begin_length() {
    number(T{0});
    return size_;
  }
  template <class T>
  void end_length(std::size_t at) {
    put(bytes_.get() + at - sizeof(T), static_cast<T>(size_ - at));
  }

  template <class T>
  static void put(std::byte* at, T value) {
    if constexpr (std::endian::native == std::endian::little)
      std::memcpy(at, &value, sizeof value);
    else
      for (std::size_t i = 0; i < sizeof value; ++i) at[i] = static_cast<std::byte>(value >> (8 * i));
  }

 private:
  void grow(std::size_t capacity) {
    capacity = std::max(capacity, capacity_ + capacity_ / 2);
    auto bigger = std::make_unique_for_overwrite<std::byte[]>(capacity);
    if (size_ != 0) std::memcpy(bigger.get(), bytes_.get(), size_);
    bytes_ = std::move(bigger), capacity_ = capacity;
  }
  std::unique_ptr<std::byte[]> bytes_;
  std::size_t size_ = 0, capacity_ = 0;
};

/// Reads from bytes that may be anything: past their end every value is zero or empty, and good() is false.
class Cursor {
 public:
  explicit Cursor(std::span<const std::byte> bytes) : rest_(bytes) {}
  bool good() const { return good_; }
  std::span<const std::byte> rest() const { return rest_; }

  template <class T>
  T number() {
    const auto from = take(sizeof(T));
    T value = 0;
    for (std::size_t i = 0; i < from.size(); ++i)
      value = static_cast<T>(value | static_cast<T>(std::to_integer<T>(from[i])) << (8 * i));
    return value;
  }
  std::span<const std::byte> take(std::uint64_t size) {
    if (size > rest_.size()) {
      good_ = false, rest_ = {};
      return {};
    }
    const auto taken = rest_.first(static_cast<std::size_t>(size));
    rest_ = rest_.subspan(taken.size());
    return taken;
  }
  std::string_view text() { return as_text(take(number<std::uint32_t>())); }
  Texts texts() {
    Cursor inside(take(number<std::uint32_t>()));
    Texts map;
    while (good_ && !inside.rest().empty()) {
      std::string key(inside.text());
      std::string value(inside.text());
      map.insert_or_assign(std::move(key), std::move(value));
      good_ = inside.good();
    }
    return map;
  }

 private:
  std::span<const std::byte> rest_;
  bool good_ = true;
};

}  // namespace sinew::record
