#include "apps/view/gap_text.hpp"

#include <fmt/format.h>

#include "apps/view/graph_text.hpp"

namespace sinew::app {
namespace {

std::string line(const std::string& thread, const rt::GapStats& gaps, const char* cause) {
  const std::uint64_t n = gaps.count.value();
  if (n == 0) return {};
  const rt::Duration min{gaps.min_ns.value()}, max{gaps.max_ns.value()};
  return fmt::format("thread {}: {} gap{} of {}{}: {}\n", thread, n, n == 1 ? "" : "s", human(min),
                     n == 1 ? "" : " to " + human(max), cause);
}

}  // namespace

std::string gap_lines(const rt::Graph& graph, rt::Runner& runner) {
  std::string out;
  for (std::uint32_t t = 0; t < graph.threads().size(); ++t) {
    const rt::ThreadStats& stats = runner.thread_stats(t);
    const std::string& name = graph.threads()[t].spec.name;
    out += line(name, stats.throttled,
                "looks like the kernel's real-time throttle (kernel.sched_rt_runtime_us): a fixed-priority thread that "
                "does not sleep uses it up");
    out +=
        line(name, stats.taken, "the processor was taken away, by the machine's host or by threads of higher priority");
  }
  return out;
}

}  // namespace sinew::app
