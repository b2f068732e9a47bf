#pragma once
#include <string>
#include <string_view>

#include "rt/exec/runner.hpp"

namespace sinew::rt {

/// How a chain kept its age budget. For a test:
///
///   const auto kept = rt::chain_within_budget(executor.runner(), "imu_to_motors");
///   EXPECT_TRUE(kept) << kept.text;
struct ChainVerdict {
  enum class Result : std::uint8_t {
    pass,
    fail,          // more messages than allowed were older than the budget
    no_budget,     // the robot file gives none
    nothing_came,  // no message reached the end of the chain
    unknown,       // no such chain
  };
  Result result = Result::unknown;
  std::uint64_t messages = 0, misses = 0, allowed = 0;
  std::string text;  // "chain imu_to_motors: 3 of 1000 messages older than 10 ms, 0 allowed"
  explicit operator bool() const { return result == Result::pass; }
};

/// Thread: any, while the run goes on or after it.
ChainVerdict chain_within_budget(const Runner& runner, std::uint32_t chain);
ChainVerdict chain_within_budget(const Runner& runner, std::string_view name);

}  // namespace sinew::rt
