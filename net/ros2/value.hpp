#pragma once
// A value of a ROS 2 type whose definition was read at run time, and its bytes.
#include <bit>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "net/ros2/schema.hpp"

namespace sinew::ros2 {

using Bytes = std::vector<std::uint8_t>;

/// What a field holds; which member counts is said by its Field.
struct Value {
  std::uint64_t bits = 0;                 // of a number: an integer with its sign extended, or a double
  std::string text;                       // of a text
  std::vector<Value> items;               // of an array; of a nested type its fields
  std::span<const std::uint8_t> bytes{};  // of an array of int8 or uint8; the memory is somebody else's

  void set(double number) { bits = std::bit_cast<std::uint64_t>(number); }
  double number() const { return std::bit_cast<double>(bits); }
  std::int64_t integer() const { return static_cast<std::int64_t>(bits); }
  void set_integer(std::int64_t value) { bits = static_cast<std::uint64_t>(value); }
};

/// One message, with its fields by their paths: "header.stamp.sec", "k[8]". Places of fields stay the same as long as
/// no array on their path changes its size. Thread:  owner.   RT: no.
class Message {
 public:
  explicit Message(const Type& type);
  Message(const Message&) = delete;

  const Type& type() const { return type_; }
  Value& root() { return root_; }
  const Value& root() const { return root_; }
  /// Null: there is no such field, or no such element at present.
  Value* find(std::string_view path);

  /// All numbers 0, texts and sequences empty.
  static void make_default(const Type& type, Value& value);
  static void make_default(const Field& field, Value& value);

 private:
  const Type& type_;
  Value root_;
};

/// A field's element, below a value of `type`; null as Message::find(). `field`: what it is.
Value* find_value(const Type& type, Value& value, std::string_view path, const Field** field = nullptr);

/// Appends the message to nothing: `out` is its bytes afterwards, XCDR1, little-endian, with the head 00 01 00 00.
/// Numbers are cut to their field's size.
void encode(const Type& type, const Value& value, std::vector<std::uint8_t>& out);

/// Outcome of decode(): `error` is null, or why and where.
struct [[nodiscard]] Decoded {
  const char* error = nullptr;
  std::size_t at = 0;
  explicit operator bool() const { return error == nullptr; }
};

inline constexpr std::size_t kMostValues = 1'000'000;  // elements of all arrays of a message, bytes not counted

/// The bytes as a peer sent them: XCDR1 of either byte order. Any input is accepted or refused in time and memory that
/// are bounded by its size; up to 3 bytes behind the message are padding. Owner:   arrays of bytes are views of `in`.
Decoded decode(const Type& type, std::span<const std::uint8_t> in, Value& value);

}  // namespace sinew::ros2
