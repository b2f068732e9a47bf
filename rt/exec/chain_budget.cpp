#include "rt/exec/chain_budget.hpp"

#include "math/convert.hpp"
#include "rt/parameters.hpp"

namespace sinew::rt {

using Result = ChainVerdict::Result;

ChainVerdict chain_within_budget(const Runner& runner, std::uint32_t chain) {
  const ChainSpec& spec = runner.graph().chains()[chain].spec;
  const ChainStats& stats = runner.chain_stats(chain);
  ChainVerdict v;
  v.messages = stats.age.count();
  v.misses = stats.budget_misses.value();
  v.allowed = math::to_integer<std::uint64_t>(spec.allowed_misses * static_cast<double>(v.messages));
  v.text = "chain " + spec.name + ": ";
  if (spec.budget == Duration{0}) {
    v.result = Result::no_budget;
    v.text += "it has no budget_ms";
  } else if (v.messages == 0) {
    v.result = Result::nothing_came;
    v.text += "no message reached " + spec.to.value;
  } else {
    v.result = v.misses <= v.allowed ? Result::pass : Result::fail;
    v.text += std::to_string(v.misses) + " of " + std::to_string(v.messages) + " messages older than " +
              format_number(static_cast<double>(spec.budget.count()) / 1e6) + " ms, " + std::to_string(v.allowed) +
              " allowed";
  }
  return v;
}

ChainVerdict chain_within_budget(const Runner& runner, std::string_view name) {
  const auto& chains = runner.graph().chains();
  for (std::uint32_t c = 0; c < chains.size(); ++c)
    if (chains[c].spec.name == name) return chain_within_budget(runner, c);
  ChainVerdict v;
  v.text = "chain " + std::string(name) + ": no such chain";
  return v;
}

}  // namespace sinew::rt
