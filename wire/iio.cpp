#include "wire/iio.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace sinew::wire {
namespace {

void skip_space(std::string_view& text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t' || text.front() == '\n')) text.remove_prefix(1);
}

bool take(std::string_view& text, std::string_view word) {
  if (!text.starts_with(word)) return false;
  text.remove_prefix(word.size());
  return true;
}

template <class T>
bool take_number(std::string_view& text, T& out) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  if (error != std::errc{}) return false;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return true;
}

std::string_view trimmed(std::string_view text) {
  skip_space(text);
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ' || text.back() == '\0')) text.remove_suffix(1);
  return text;
}

constexpr std::size_t align(std::size_t offset, std::size_t to) { return (offset + to - 1) / to * to; }

constexpr std::uint64_t mask_of(unsigned bits) {
  return bits >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1;
}

/// The place of the i-th byte, counted from the lowest.
std::size_t byte_at(const IioForm& form, std::size_t i) { return form.big_endian ? form.storage_bits / 8u - 1 - i : i; }

}  // namespace

std::optional<IioForm> parse_iio_form(std::string_view text) noexcept {
  text = trimmed(text);
  IioForm form;
  if (take(text, "be:"))
    form.big_endian = true;
  else if (!take(text, "le:"))
    return {};
  if (take(text, "s"))
    form.is_signed = true;
  else if (!take(text, "u"))
    return {};
  if (!take_number(text, form.bits) || !take(text, "/") || !take_number(text, form.storage_bits)) return {};
  if (take(text, "X") && !take_number(text, form.repeat)) return {};
  if (take(text, ">>") && !take_number(text, form.shift)) return {};
  const unsigned storage = form.storage_bits;
  if (!text.empty() || (storage != 8 && storage != 16 && storage != 32 && storage != 64)) return {};
  if (form.bits == 0 || form.bits + form.shift > storage || form.repeat == 0 || form.repeat > 16) return {};
  return form;
}

bool IioLayout::add(std::uint32_t index, const IioForm& form) noexcept {
  if (count_ == kMaxChannels || find(index) || form.bytes() == 0) return false;
  channels_[count_++] = {index, form, 0};
  std::sort(channels_.begin(), channels_.begin() + static_cast<std::ptrdiff_t>(count_),
            [](const IioChannel& a, const IioChannel& b) { return a.index < b.index; });
  place();
  return true;
}

const IioChannel* IioLayout::find(std::uint32_t index) const noexcept {
  for (const IioChannel& c : channels())
    if (c.index == index) return &c;
  return nullptr;
}

void IioLayout::place() noexcept {
  std::size_t at = 0, largest = 1;
  for (std::size_t i = 0; i < count_; ++i) {
    const std::size_t bytes = channels_[i].form.bytes();
    channels_[i].offset = align(at, bytes);
    at = channels_[i].offset + bytes;
    largest = std::max(largest, bytes);
  }
  scan_bytes_ = align(at, largest);
}

std::int64_t iio_raw(std::span<const std::uint8_t> scan, const IioChannel& channel, std::size_t repeat) noexcept {
  const IioForm& form = channel.form;
  const std::size_t size = form.storage_bits / 8u;
  if (repeat >= form.repeat || channel.offset + size * (repeat + 1) > scan.size()) return 0;
  const std::uint8_t* at = scan.data() + channel.offset + size * repeat;
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < size; ++i) bits |= std::uint64_t{at[byte_at(form, i)]} << (8 * i);
  bits = bits >> form.shift & mask_of(form.bits);
  if (form.is_signed && (bits >> (form.bits - 1) & 1)) bits |= ~mask_of(form.bits);
  return static_cast<std::int64_t>(bits);
}

void put_iio_raw(std::span<std::uint8_t> scan, const IioChannel& channel, std::int64_t value) noexcept {
  const IioForm& form = channel.form;
  const std::size_t size = form.storage_bits / 8u;
  if (channel.offset + size > scan.size()) return;
  const std::uint64_t bits = (static_cast<std::uint64_t>(value) & mask_of(form.bits)) << form.shift;
  for (std::size_t i = 0; i < size; ++i)
    scan[channel.offset + byte_at(form, i)] = static_cast<std::uint8_t>(bits >> (8 * i));
}

std::optional<double> parse_iio_number(std::string_view text) noexcept {
  text = trimmed(text);
  double value = 0;
  if (!take_number(text, value) || !text.empty() || !std::isfinite(value)) return {};
  return value;
}

std::optional<std::array<double, 9>> parse_iio_mount_matrix(std::string_view text) noexcept {
  text = trimmed(text);
  std::array<double, 9> m{};
  for (std::size_t i = 0; i < m.size(); ++i) {
    if (i > 0 && !take(text, i % 3 == 0 ? ";" : ",")) return {};
    skip_space(text);
    if (!take_number(text, m[i]) || !std::isfinite(m[i])) return {};
    skip_space(text);
  }
  if (!text.empty()) return {};
  return m;
}

}  // namespace sinew::wire
