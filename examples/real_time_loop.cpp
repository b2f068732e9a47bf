// A loop of 1 kHz in real time for half a second, with its statistics: the shortest main() around a graph.
#include <cstdio>

#include "hal/platform.hpp"
#include "msg/sensors.hpp"
#include "rt/exec/real_time_executor.hpp"

using namespace sinew;
using namespace std::chrono_literals;

class Beat final : public rt::Module {
  void declare(rt::Declaration& d) override { d.out("beat", out_); }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    out_.loan().stamp = step.now;
    return rt::StepStatus::ok;
  }
  rt::Out<msg::RangeSample> out_;
};

int main() {
  rt::ModuleTypes types;
  types.add<Beat>("Beat");
  rt::GraphSpec spec;
  spec.modules = {{.name = "beat", .type = "Beat"}};
  spec.threads = {{.name = "loop", .priority = 50, .period = 1ms, .order = {{"beat"}}}};
  rt::Graph graph(spec, types);
  hal::EmptyBoard board;
  if (!graph.check().empty() || !graph.configure(board)) return 1;

  hal::Os& os = hal::system_os();
  rt::RealTimeExecutor executor(graph, os);
  if (!executor.start()) return 1;
  for (const auto& line : executor.shortfalls()) std::printf("not granted: %s\n", line.c_str());
  os.sleep_until(executor.started_at() + 500ms);
  executor.stop();

  const rt::ThreadStats& s = executor.runner().thread_stats(graph.find_thread("loop"));
  std::printf(
      "%llu cycles, lateness p50 %lld ns, p99 %lld ns, %llu overruns\n",
      static_cast<unsigned long long>(s.completions.value()), static_cast<long long>(s.lateness.quantile(0.5).count()),
      static_cast<long long>(s.lateness.quantile(0.99).count()), static_cast<unsigned long long>(s.overruns.value()));
  return s.completions.value() > 0 ? 0 : 1;
}
