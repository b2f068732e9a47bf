#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rt/declaration.hpp"
#include "rt/graph_spec.hpp"

namespace sinew::rt {

/// Where a number lies in a message.
struct NumberField {
  std::uint32_t offset = 0;
  msg::Kind kind = msg::Kind::f64;
  double read(const void* message) const;
  /// Integers saturate, towards zero.
  void write(void* message, double value) const;
};
/// "voltage_v", "gyro_radps.x", "value[2]"; nothing when the type has no such number.
std::optional<NumberField> find_number(const msg::TypeInfo& type, std::string_view path);
/// The numbers that a path names: one, or with "[*]" after the first name ("temperature_c[*]") each of an array, of
/// which the message's own number `count`, where it has one, says how many are in use.
struct NumberFields {
  NumberField first;
  std::uint32_t stride = 0, most = 1;  // bytes from one to the next; the array's size
  std::optional<NumberField> count{};
  std::uint32_t size(const void* message) const;
  double read(const void* message, std::uint32_t i) const;  // i < size()
};
std::optional<NumberFields> find_numbers(const msg::TypeInfo& type, std::string_view path);
/// Every path that find_number() takes; an array as its first element.
std::vector<std::string> number_paths(const msg::TypeInfo& type);

/// One failsafe condition, watched on the newest message of its topic. Times count from the commit of the message that
/// began it, so they are exact whenever the guardian looks: `silent` since the last message, `stuck` from the first to
/// the newest of the messages that differ in nothing but their stamp, `value` since the first bad one. Of a list of
/// numbers those that are not finite count as not measured, and a message without any that is finite is bad. Before its
/// first message every condition holds: nothing is known to be good. Thread:  executor.   RT: yes, after configure().
class Failsafe {
 public:
  explicit Failsafe(const FailsafeSpec& spec) : spec_(spec) {}
  static std::string port_name(const FailsafeSpec& spec) { return "failsafe_" + spec.name; }

  void declare(Declaration& d);
  void configure();
  void reset();
  /// Looks at the latched message; true: the condition holds.
  bool look(Time now) noexcept;
  /// SafetyState::measured.
  double measured() const { return measured_; }

 private:
  bool look_silent(Time now) noexcept;
  bool look_stuck() noexcept;
  bool look_value(Time now) noexcept;
  double worst_of(const void* message) const noexcept;
  double margin(double value) const noexcept;
  bool is_new() noexcept;
  bool same_as_before(const void* message) const noexcept;

  FailsafeSpec spec_;
  AnyIn port_;
  NumberFields field_;
  std::uint32_t stamp_offset_ = 0;
  std::vector<std::byte> before_;  // the last message that differed

  bool any_ = false, bad_ = false;
  std::uint32_t sequence_ = 0;
  Time since_;
  double measured_ = 0;
};

}  // namespace sinew::rt
