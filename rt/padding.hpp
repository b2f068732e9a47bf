#pragma once
#include <type_traits>

namespace sinew::rt {

namespace detail {

template <class T>
struct Bytes {
  unsigned char byte[sizeof(T)];
};

// The compiler evaluates this: to read a byte of padding is an error then, so the expression is no constant.
template <class T>
constexpr bool every_byte_has_a_value() {
  const Bytes<T> bytes = __builtin_bit_cast(Bytes<T>, __builtin_bit_cast(T, Bytes<T>{}));
  unsigned sum = 0;
  for (const unsigned char b : bytes.byte) sum += b;
  return sum == 0;
}

template <class T, class = void>
struct HasNoPadding : std::false_type {};
template <class T>
struct HasNoPadding<T, std::enable_if_t<every_byte_has_a_value<T>()>> : std::true_type {};

}  // namespace detail

/// True if each byte of a trivially copyable type belongs to a value. A byte of padding keeps what was in memory
/// before, so two equal objects could differ in their bytes. std::has_unique_object_representations does not say it of
/// types with floating-point numbers. False also for a class that the compiler cannot look into: with pointers or
/// unions, or without a constructor that may run at compile time (`= default` is one if the members have initial
/// values).
template <class T>
inline constexpr bool kHasNoPadding = detail::HasNoPadding<T>::value;

}  // namespace sinew::rt
