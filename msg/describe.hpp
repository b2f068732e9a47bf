#pragma once
// The one description of a message: its fields in order, with units. Layout check, JSON, ros2msg schema text, CDR and
// the documentation all come from it; no other code lists the fields of a message.
//
//   struct RangeSample {
//     Time stamp;
//     double range_m = 0;
//   };
//   template <> struct Description<RangeSample> {
//     static constexpr std::string_view name = "RangeSample", doc = "Distance along the beam of a range finder.";
//     static constexpr auto fields = describe(field<&RangeSample::stamp>("ns", "when the echo returned"),
//                                             field<&RangeSample::range_m>("m", "NaN when out of range"));
//   };
//
// A field's name is read from the member pointer, so a misspelt field does not compile; a missing field, a field listed
// twice, or padding inside the struct fails check_layout(), which type_info<T>() asserts at compile time.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <tuple>
#include <type_traits>

#include "msg/time.hpp"

namespace sinew::msg {

enum class Kind : std::uint8_t { i8, u8, i16, u16, i32, u32, i64, u64, f32, f64, nested };

struct TypeInfo;

/// The name of one value of an enumeration, or of one bit of a set.
struct ValueName {
  std::string_view name;
  std::uint32_t value;

  template <class V>
  constexpr ValueName(std::string_view n, V v) : name(n), value(static_cast<std::uint32_t>(v)) {}
};

/// Empty: this value has no name.
constexpr std::string_view name_of(std::span<const ValueName> names, std::uint32_t value) {
  for (const ValueName& known : names)
    if (known.value == value) return known.name;
  return {};
}

/// One field as the type-erased codecs see it.
struct FieldInfo {
  std::string_view name, unit, doc;
  Kind kind;                           // of one element; enumerations and Time appear as their integer
  bool is_array;                       // a fixed-size array, also when it has one element
  std::uint32_t count;                 // elements; 1 for a scalar
  std::uint32_t offset;                // bytes from the start of the struct
  const TypeInfo* nested;              // for Kind::nested, else null
  std::span<const ValueName> names{};  // of its values, or of its bits; empty: the numbers are all there is
  bool bits = false;
  bool is_time = false;  // a Time: an instant, not a length of time
};

/// A stretch of floating-point numbers inside the struct; nested structs and neighbours are already merged.
struct FloatRun {
  std::uint32_t offset, count;
  bool is_f64;
};

/// A message type as rt, the recorder and the command line see it. One static object per type.
struct TypeInfo {
  std::string_view name, doc;
  std::uint32_t size, align;  // of the struct; the bulk, if any, follows it at once
  std::span<const FieldInfo> fields;
  void (*reset)(void*);        // gives every field its default; never touches the bulk
  std::string_view bulk_name;  // empty: no bulk (pixels) behind the struct
  /// Bytes of the bulk that hold data; only these count for hashes, comparison and recording.
  std::uint32_t (*bulk_used)(const void*);
  void (*set_bulk_capacity)(void*, std::uint32_t);  // the slot's owner calls it after reset
  std::span<const FloatRun> floats;                 // for canonicalise(); empty: the type has none

  bool has_bulk() const { return !bulk_name.empty(); }
};

template <class T>
struct Description;  // specialised next to each message

template <class T>
concept Described = requires {
  Description<T>::fields;
};

namespace detail {

template <auto Member>
constexpr std::string_view member_name() {
  std::string_view s = __PRETTY_FUNCTION__;  // gcc and clang both print "... Member = &Struct::field]" (and maybe more)
  const auto begin_at = s.find("Member = ");
  s.remove_prefix(begin_at);
  s = s.substr(0, s.find_first_of(";]"));
  s.remove_prefix(s.rfind(':') + 1);
  if (s.back() == ')') s.remove_suffix(1);
  return s;
}

template <class M>
struct MemberOf;
template <class T, class V>
struct MemberOf<V T::*> {
  using Struct = T;
  using Value = V;
};

template <class V>
struct Element {
  using Type = V;
  static constexpr std::uint32_t count = 1;
  static constexpr bool is_array = false;
};
template <class V, std::size_t N>
struct Element<std::array<V, N>> {
  using Type = V;
  static constexpr std::uint32_t count = N;
  static constexpr bool is_array = true;
};

template <class V>
constexpr Kind kind_of() {
  if constexpr (std::is_enum_v<V>)
    return kind_of<std::underlying_type_t<V>>();
  else if constexpr (std::is_same_v<V, Time>)
    return Kind::i64;
  else if constexpr (std::is_same_v<V, float>)
    return Kind::f32;
  else if constexpr (std::is_same_v<V, double>)
    return Kind::f64;
  else if constexpr (std::is_integral_v<V> && !std::is_same_v<V, bool>) {
    constexpr int log2 = sizeof(V) == 1 ? 0 : sizeof(V) == 2 ? 1 : sizeof(V) == 4 ? 2 : 3;
    return static_cast<Kind>(2 * log2 + (std::is_unsigned_v<V> ? 1 : 0));
  } else {
    static_assert(Described<V>,
                  "a field is an integer (not bool), an enumeration, float, double, Time, a described "
                  "struct, or a std::array of one of these");
    return Kind::nested;
  }
}

}  // namespace detail

template <auto Member>
struct Field {
  using Struct = typename detail::MemberOf<decltype(Member)>::Struct;
  using Value = typename detail::MemberOf<decltype(Member)>::Value;
  static constexpr std::string_view name = detail::member_name<Member>();
  std::string_view unit, doc;
  std::span<const ValueName> names{};
  bool bits = false;
};

/// Units: SI symbol, "1" for ratios and counts, "ns" for Time.
template <auto Member>
constexpr Field<Member> field(std::string_view unit, std::string_view doc = {}) {
  return {unit, doc};
}

/// An enumeration whose values have names. The names are given here only: definitions in recordings, what the commands
/// print, `topic pub` and the documentation take them from here. `names` lives as long as the program.
template <auto Member>
constexpr Field<Member> enum_field(std::span<const ValueName> names, std::string_view doc = {}) {
  return {"enum", doc, names};
}

/// A set of bits with names, likewise.
template <auto Member>
constexpr Field<Member> bits_field(std::span<const ValueName> names, std::string_view doc = {}) {
  return {"1", doc, names, true};
}

template <class... F>
constexpr std::tuple<F...> describe(F... fields) {
  return {fields...};
}

/// True when the fields are exactly the members: no member left out or listed twice, no padding between or behind them.
template <class T>
constexpr bool check_layout() {
  return std::apply(
      [](auto... f) {
        constexpr std::size_t n = sizeof...(f);
        const std::array<std::string_view, n> names{decltype(f)::name...};
        for (std::size_t i = 0; i < n; ++i)
          for (std::size_t j = i + 1; j < n; ++j)
            if (names[i] == names[j]) return false;
        return (std::is_same_v<typename decltype(f)::Struct, T> && ...) &&
               (sizeof(typename decltype(f)::Value) + ... + std::size_t{0}) == sizeof(T);
      },
      Description<T>::fields);
}

template <class T>
concept HasBulk = requires(T t, const T c) {
  { Description<T>::bulk } -> std::convertible_to<std::string_view>;
  { c.bulk_used() } -> std::same_as<std::uint32_t>;
  t.set_bulk_capacity(std::uint32_t{});
};

namespace detail {

template <class T, auto Member>
FieldInfo field_info(const Field<Member>& f);

/// Most runs that a field of this type, or all fields of a described struct, can have.
template <class V>
constexpr std::size_t max_float_runs() {
  using E = typename Element<V>::Type;
  constexpr Kind kind = kind_of<E>();
  if constexpr (kind == Kind::nested)
    return Element<V>::count *
           std::apply([](auto... f) { return (max_float_runs<typename decltype(f)::Value>() + ... + std::size_t{0}); },
                      Description<E>::fields);
  else
    return kind == Kind::f32 || kind == Kind::f64 ? 1 : 0;
}

/// Fills `out` with the runs of these fields in order of offset; returns how many.
std::size_t find_float_runs(std::span<const FieldInfo> fields, FloatRun* out);

template <class T>
struct TypeInfoOf {
  static constexpr std::size_t kCount = std::tuple_size_v<decltype(Description<T>::fields)>;
  std::array<FieldInfo, kCount> fields;
  std::array<FloatRun, max_float_runs<T>()> float_runs;
  TypeInfo info;

  TypeInfoOf()
      : fields(std::apply([](const auto&... f) { return std::array<FieldInfo, kCount>{field_info<T>(f)...}; },
                          Description<T>::fields)),
        info{Description<T>::name,
             Description<T>::doc,
             sizeof(T),
             alignof(T),
             fields,
             [](void* p) { new (p) T(); },
             {},
             nullptr,
             nullptr,
             {}} {
    info.floats = {float_runs.data(), find_float_runs(fields, float_runs.data())};
    if constexpr (HasBulk<T>) {
      info.bulk_name = Description<T>::bulk;
      info.bulk_used = [](const void* p) { return static_cast<const T*>(p)->bulk_used(); };
      info.set_bulk_capacity = [](void* p, std::uint32_t bytes) { static_cast<T*>(p)->set_bulk_capacity(bytes); };
    }
  }
  TypeInfoOf(const TypeInfoOf&) = delete;
};

}  // namespace detail

/// The description of T for type-erased code. First call allocates nothing but runs a static constructor: call it in
/// declare() or configure(), not in a step.
template <Described T>
const TypeInfo& type_info() {
  static_assert(check_layout<T>(),
                "the description of this message misses a field, lists one twice, or the struct has "
                "padding: name the padding as a field or reorder");
  static_assert(std::is_standard_layout_v<T> && std::is_trivially_destructible_v<T>);
  static_assert(HasBulk<T> || std::is_trivially_copyable_v<T>);
  static const detail::TypeInfoOf<T> holder;
  return holder.info;
}

namespace detail {

template <class T, auto Member>
FieldInfo field_info(const Field<Member>& f) {
  using Value = typename Field<Member>::Value;
  using E = Element<Value>;
  constexpr Kind kind = kind_of<typename E::Type>();
  alignas(T) static const std::byte storage[sizeof(T)]{};
  const T* object =
      static_cast<const T*>(static_cast<const void*>(storage));  // only the address of the member is taken
  const auto offset = reinterpret_cast<const std::byte*>(&(object->*Member)) - storage;
  const TypeInfo* nested = nullptr;
  if constexpr (kind == Kind::nested) nested = &type_info<typename E::Type>();
  return {Field<Member>::name,
          f.unit,
          f.doc,
          kind,
          E::is_array,
          E::count,
          static_cast<std::uint32_t>(offset),
          nested,
          f.names,
          f.bits,
          std::is_same_v<typename E::Type, Time>};
}

}  // namespace detail

}  // namespace sinew::msg
