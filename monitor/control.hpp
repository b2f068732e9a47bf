#pragma once
#include <chrono>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::monitor {

/// Who commands one robot: at most one page or program at a time, for as long as it says that it is still there.
/// Thread:  one.
class Control {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::seconds kLease{5};  // without take() or keep(), control is free again
  static constexpr std::size_t kMostAsked = 8, kMostName = 64;

  /// The key of the new commander; empty: somebody else has control. Who has it already gets the same key again.
  /// `fresh_key`: what the key becomes.
  std::string take(std::string_view who, std::string_view key, std::string fresh_key, Time now);
  /// False: this is not the commander's key (any more).
  bool keep(std::string_view key, Time now);
  bool release(std::string_view key, Time now);
  /// Shown to the commander until it releases. False: nobody has control, or too many have asked.
  bool ask(std::string_view who, Time now);

  /// Whether a command with this key (empty: none) may go on.
  bool allows(std::string_view key, Time now) const;
  /// Empty: nobody.
  std::string who(Time now) const { return is_held(now) ? who_ : std::string(); }
  std::vector<std::string> asked(Time now) const { return is_held(now) ? asked_ : std::vector<std::string>(); }

 private:
  bool is_held(Time now) const { return !key_.empty() && now < until_; }

  std::string who_{}, key_{};
  Time until_{};
  std::vector<std::string> asked_{};
};

}  // namespace sinew::monitor
