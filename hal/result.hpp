#pragma once
#include <cstdint>
#include <optional>
#include <utility>

namespace sinew::hal {

/// The kind of a failure; `detail` of the Error has more.
enum class Errc : std::uint8_t {
  not_found,      // no such device, file or peer
  busy,           // another holder has it
  denied,         // permission or privilege is missing
  not_supported,  // this board or kernel cannot do it
  bad_argument,   // refused before anything was touched
  bad_data,       // a peer or file sent what the format does not allow
  closed,         // the other side went away
  timeout,
  out_of_memory,
  io,  // the system refused; detail is its errno
};

/// A failure as a value: kind, the place that reports it, and one number (errno, node id, byte offset).
/// Owner:   `where` is a string literal.
struct Error {
  Errc code = Errc::io;
  const char* where = "";
  std::int64_t detail = 0;
};

const char* to_string(Errc code);

/// A value or an Error, spelled after std::expected. RT: yes.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : value_(std::move(value)) {}
  Result(Error error) : error_(error) {}
  bool has_value() const { return value_.has_value(); }
  explicit operator bool() const { return has_value(); }
  T& value() { return *value_; }
  const T& value() const { return *value_; }
  T& operator*() { return *value_; }
  const T& operator*() const { return *value_; }
  T* operator->() { return &*value_; }
  const T* operator->() const { return &*value_; }
  const Error& error() const { return error_; }

 private:
  std::optional<T> value_;
  Error error_{};
};

/// Success or an Error.
template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(error), ok_(false) {}
  bool has_value() const { return ok_; }
  explicit operator bool() const { return ok_; }
  const Error& error() const { return error_; }

 private:
  Error error_{};
  bool ok_ = true;
};

using Status = Result<void>;

}  // namespace sinew::hal
