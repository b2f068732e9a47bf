#include "apps/view/status_table.hpp"

#include <fmt/format.h>

#include "apps/view/gap_text.hpp"
#include "apps/view/graph_text.hpp"

namespace sinew::app {
namespace {

constexpr rt::Duration kWindow = std::chrono::seconds(1);

std::string cut(std::string line, int columns) {
  if (columns > 0 && line.size() > static_cast<std::size_t>(columns)) line.resize(static_cast<std::size_t>(columns));
  return line + "\n";
}

}  // namespace

StatusRows rows_of(const rt::Graph& graph, rt::Runner& runner) {
  StatusRows rows;
  for (std::uint32_t t = 0; t < graph.threads().size(); ++t) {
    const rt::ThreadStats& s = runner.thread_stats(t);
    rows.threads.push_back({graph.threads()[t].spec.name, graph.threads()[t].spec.priority, s.completions.value(),
                            s.overruns.value(), s.lateness.quantile(0.5), s.lateness.quantile(0.99),
                            s.exec.quantile(0.99)});
  }
  for (std::uint32_t t = 0; t < graph.topics().size(); ++t) {
    const rt::TopicStats& s = runner.topic_stats(t);
    rows.topics.push_back({graph.topics()[t].name, s.messages.value(), runner.topic_drops(t), s.age.quantile(0.99)});
  }
  rows.gaps = gap_lines(graph, runner);
  return rows;
}

std::string StatusTable::rate(const std::string& key, std::uint64_t count, rt::Time now) {
  std::deque<Count>& counts = counts_[key];
  counts.push_back({now, count});
  while (counts.size() > 2 && now - counts[1].at >= kWindow) counts.pop_front();
  const double elapsed_s = msg::seconds(now - counts.front().at);
  if (elapsed_s <= 0) return "-";
  return fmt::format("{:.0f} Hz", static_cast<double>(count - counts.front().count) / elapsed_s);
}

std::string StatusTable::render(const StatusRows& rows, rt::Time now, int columns) {
  std::string out = cut(fmt::format("{:<24} {:>9} {:>9} {:>9} {:>9} {:>9} {:>4}", "thread", "rate", "overruns",
                                    "late p50", "late p99", "exec p99", "prio"),
                        columns);
  for (const auto& t : rows.threads)
    out +=
        cut(fmt::format("{:<24} {:>9} {:>9} {:>9} {:>9} {:>9} {:>4}", t.name, rate("thread " + t.name, t.cycles, now),
                        t.overruns, human(t.late_p50), human(t.late_p99), human(t.exec_p99), t.priority),
            columns);
  for (std::size_t at = 0; at < rows.gaps.size(); at = rows.gaps.find('\n', at) + 1)
    out += cut(rows.gaps.substr(at, rows.gaps.find('\n', at) - at), columns);
  out += cut(fmt::format("{:<24} {:>9} {:>9} {:>9}", "topic", "rate", "lost", "age p99"), columns);
  for (const auto& t : rows.topics)
    out += cut(fmt::format("{:<24} {:>9} {:>9} {:>9}", t.name, rate("topic " + t.name, t.messages, now), t.lost,
                           human(t.age_p99)),
               columns);
  return out;
}

}  // namespace sinew::app
