// How late a 1 kHz thread is with hostile programs at the robot's socket and memory, beside the same thread alone and
// beside programs that only use up the processors. In turns; one ratio of medians (and of 99 % quantiles) a turn.
#include <sys/mman.h>

#include <atomic>
#include <cstring>
#include <filesystem>
#include <mutex>

#include "hal/linux/process.hpp"
#include "hal/platform.hpp"
#include "msg/image.hpp"
#include "msg/sensors.hpp"
#include "pairs.hpp"
#include "rt/exec/real_time_executor.hpp"
#include "tap/server.hpp"

namespace sinew::bench {
namespace {

using namespace std::chrono_literals;

constexpr hal::Duration kTurn = 700ms, kSettle = 150ms;

class Sensor final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override { d.out("range", out_); }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    out_.loan().stamp = step.now;
    return rt::StepStatus::ok;
  }

 private:
  rt::Out<msg::RangeSample> out_;
};

class Eye final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override { d.out("frame", out_); }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    msg::Image& image = out_.loan();
    if (!image.format_as(msg::PixelFormat::mono8, 640, 480)) return rt::StepStatus::fault;
    image.stamp = step.now;
    std::memset(image.pixels(), 1, 640 * 480);
    return rt::StepStatus::ok;
  }

 private:
  rt::Out<msg::Image> out_;
};

/// Collects the lateness of the fast thread while a turn runs.
class Turn final : public rt::RunObserver {
 public:
  Turn() { us_.reserve(1 << 16); }
  void completed(const rt::StepRecord& r) noexcept override {
    if (r.module != 0 || !on_.load(std::memory_order_acquire)) return;
    if (us_.size() < us_.capacity()) us_.push_back(static_cast<double>((r.now - r.release).count()) * 1e-3);
  }
  std::vector<double> run(hal::Os& os) {
    us_.clear();
    on_.store(true, std::memory_order_release);
    os.sleep_until(os.now() + kTurn);
    on_.store(false, std::memory_order_release);
    os.sleep_until(os.now() + 5ms);  // lets a step that has begun end
    return us_;
  }

 private:
  std::atomic<bool> on_{false};
  std::vector<double> us_;
};

rt::GraphSpec robot() {
  rt::GraphSpec g;
  g.robot = "bench";
  for (const char* name : {"sensor", "eye"}) {
    rt::ModuleSpec m;
    m.name = name, m.type = name;
    g.modules.push_back(m);
    rt::ThreadSpec t;
    t.name = name, t.order = {{name, 0}};
    g.threads.push_back(t);
  }
  g.threads[0].priority = 80, g.threads[0].period = 1ms;
  g.threads[1].priority = 40, g.threads[1].period = 33ms;
  rt::TopicSpec frame;
  frame.name = "eye.frame", frame.image_bytes = 640 * 480;
  g.topics.push_back(frame);
  return g;
}

using Children = std::vector<std::unique_ptr<hal::ChildProcess>>;

Children start(const std::vector<std::string>& what, const std::string& socket, const char* log) {
  Children all;
  for (const auto& w : what) {
    const char* amount = w == "killed" || w == "garbage" ? "100000" : "60";
    auto child = hal::ChildProcess::start({TAP_HOSTILE, w, socket, amount}, log);
    if (!child) std::exit(2);
    all.push_back(std::move(*child));
  }
  return all;
}

double share(std::vector<double> us, double q) { return quantile(us, q); }

int run(int turns) {
  ::mlockall(MCL_CURRENT | MCL_FUTURE);
  std::string folder = (std::filesystem::temp_directory_path() / "sinew-bench-XXXXXX").string();
  if (!::mkdtemp(folder.data())) return 2;
  ::setenv("SINEW_RUN_DIR", folder.c_str(), 1);
  rt::ModuleTypes types;
  types.add<Sensor>("sensor");
  types.add<Eye>("eye");
  rt::Graph graph(robot(), types);
  hal::EmptyBoard board;
  hal::Os& os = hal::system_os();
  if (!graph.check({}).empty() || !graph.configure(board, {.os = &os})) return 2;
  Turn turn;
  rt::RealTimeOptions options;
  options.runner.observer = &turn;
  options.lock_memory = false;  // the whole program's memory is locked already
  rt::RealTimeExecutor executor(graph, os, options);
  if (!executor.start()) return 2;
  for (const auto& line : executor.shortfalls()) std::printf("not as meant: %s\n", line.c_str());
  bool good = true;
  {
    std::string why;
    auto name = tap::Name::take("bench", why);
    if (!name) {
      std::printf("%s\n", why.c_str());
      return 2;
    }
    auto server = tap::Server::open(**name, graph, executor.runner(), os);
    if (!server) return 2;
    const std::vector<std::string> hostiles{"spin", "wake", "flood", "garbage", "killed"};
    const std::vector<std::string> burners(hostiles.size(), "burn");
    Pairs p50_alone, p50_burn, p99_alone, p99_burn;
    for (int i = 0; i < turns; ++i) {
      std::vector<double> alone, beside, burned;
      const auto with = [&](const std::vector<std::string>& what) {
        const Children children = start(what, (*name)->path(), "/dev/null");
        os.sleep_until(os.now() + kSettle);
        return turn.run(os);
      };
      if (i % 2 == 0) alone = turn.run(os), beside = with(hostiles), burned = with(burners);
      if (i % 2 == 1) burned = with(burners), beside = with(hostiles), alone = turn.run(os);
      p50_alone.add({share(beside, 0.5)}, {share(alone, 0.5)});
      p99_alone.add({share(beside, 0.99)}, {share(alone, 0.99)});
      p50_burn.add({share(beside, 0.5)}, {share(burned, 0.5)});
      p99_burn.add({share(beside, 0.99)}, {share(burned, 0.99)});
    }
    good &= report("hostile_p50_beside_alone", p50_alone.ratio(), 1.2);
    good &= report("hostile_p99_beside_alone", p99_alone.ratio(), 1.2);
    good &= report("hostile_p50_beside_plain_load", p50_burn.ratio(), 1.2);
    good &= report("hostile_p99_beside_plain_load", p99_burn.ratio(), 1.2);
    const tap::ServerStats& s = (*server)->stats();
    std::printf("%-34s %llu connections, %llu requests, %llu of garbage\n", "  meanwhile at the socket",
                static_cast<unsigned long long>(s.accepted.value()),
                static_cast<unsigned long long>(s.requests.value()),
                static_cast<unsigned long long>(s.garbage.value()));
    const auto& stats = executor.runner().module_stats(0);
    if (stats.fault.value() || stats.stops.value()) good = false, std::printf("the robot was hurt\n");
  }
  executor.stop();
  std::filesystem::remove_all(folder);
  return good ? 0 : 1;
}

}  // namespace
}  // namespace sinew::bench

int main(int argc, char** argv) { return sinew::bench::run(std::max(15, argc > 1 ? std::atoi(argv[1]) : 15)); }
