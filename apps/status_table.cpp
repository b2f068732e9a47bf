#include "apps/status_table.hpp"

#include <fmt/format.h>

#include "apps/gap_text.hpp"
#include "apps/graph_text.hpp"

namespace sinew::app {
namespace {

std::string cut(std::string line, int columns) {
  if (columns > 0 && line.size() > static_cast<std::size_t>(columns)) line.resize(static_cast<std::size_t>(columns));
  return line + "\n";
}

}  // namespace

StatusTable::StatusTable(const rt::Graph& graph, rt::Runner& runner)
    : graph_(graph), runner_(runner), cycles_(graph.threads().size()), messages_(graph.topics().size()) {}

std::string StatusTable::render(rt::Time now, int columns) {
  const double elapsed = last_.ns ? msg::seconds(now - last_) : 0;
  last_ = now;
  const auto rate = [&](std::uint64_t value, std::uint64_t& before) {
    const double r = elapsed > 0 ? static_cast<double>(value - before) / elapsed : 0;
    before = value;
    return r;
  };
  std::string out = cut(fmt::format("{:<14} {:>4} {:>9} {:>11} {:>11} {:>11} {:>8}", "thread", "prio", "rate",
                                    "late p50", "late p99", "exec p99", "overruns"),
                        columns);
  for (std::uint32_t t = 0; t < graph_.threads().size(); ++t) {
    const rt::ThreadStats& s = runner_.thread_stats(t);
    out += cut(fmt::format("{:<14} {:>4} {:>6.0f} Hz {:>11} {:>11} {:>11} {:>8}", graph_.threads()[t].spec.name,
                           graph_.threads()[t].spec.priority, rate(s.completions.value(), cycles_[t]),
                           human(s.lateness.quantile(0.5)), human(s.lateness.quantile(0.99)),
                           human(s.exec.quantile(0.99)), s.overruns.value()),
               columns);
  }
  const std::string gaps = gap_lines(graph_, runner_);
  for (std::size_t at = 0; at < gaps.size(); at = gaps.find('\n', at) + 1)
    out += cut(gaps.substr(at, gaps.find('\n', at) - at), columns);
  out += cut(fmt::format("{:<24} {:>9} {:>11} {:>8}", "topic", "rate", "age p99", "drops"), columns);
  for (std::uint32_t i = 0; i < graph_.topics().size(); ++i) {
    const rt::TopicStats& s = runner_.topic_stats(i);
    out += cut(fmt::format("{:<24} {:>6.0f} Hz {:>11} {:>8}", graph_.topics()[i].name,
                           rate(s.messages.value(), messages_[i]), human(s.age.quantile(0.99)), runner_.topic_drops(i)),
               columns);
  }
  return out;
}

}  // namespace sinew::app
