// How late a 1 kHz thread is with hostile programs at the robot's socket and memory: beside the same thread alone,
// beside programs that merely use up the processors, and beside the same hostile programs at a decoy, a second robot in
// another process without fixed priorities. One ratio of medians (and of 99 % quantiles) a turn. The decoy is the
// floor: what these programs take from the machine (forks, exits, kernel calls that are not preempted) whoever they
// attack.
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <filesystem>
#include <string_view>

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

Children start(const std::vector<std::string>& what, const std::string& socket) {
  Children all;
  for (const auto& w : what) {
    const char* amount = w == "killed" || w == "garbage" ? "100000" : "60";
    auto child = hal::ChildProcess::start({TAP_HOSTILE, w, socket, amount}, "/dev/null");
    if (!child) std::exit(2);
    all.push_back(std::move(*child));
  }
  return all;
}

/// The robot of robot() on this machine, with its socket; ends the program when it cannot be had.
class Robot {
 public:
  Robot(const char* name, bool fixed_priority, rt::RunObserver* observer) : graph_(robot(), types()) {
    if (!graph_.check({}).empty() || !graph_.configure(board_, {.os = &os_})) std::exit(2);
    rt::RealTimeOptions options;
    options.runner.observer = observer;
    options.fixed_priority = fixed_priority;
    options.lock_memory = false;  // the whole program's is
    executor_.emplace(graph_, os_, options);
    if (!executor_->start()) std::exit(2);
    for (const auto& line : executor_->shortfalls()) std::printf("not as meant: %s\n", line.c_str());
    std::string why;
    auto taken = tap::Name::take(name, why);
    if (!taken) std::printf("%s\n", why.c_str()), std::exit(2);
    name_ = std::move(*taken);
    auto server = tap::Server::open(*name_, graph_, executor_->runner(), os_);
    if (!server) std::exit(2);
    server_ = std::move(*server);
  }
  ~Robot() {
    server_.reset();
    executor_->stop();
  }
  const std::string& socket() const { return name_->path(); }
  const tap::ServerStats& served() const { return server_->stats(); }
  bool is_well() const {
    const auto& stats = executor_->runner().module_stats(0);
    return stats.fault.value() == 0 && stats.stops.value() == 0;
  }

 private:
  static const rt::ModuleTypes& types() {
    static const rt::ModuleTypes all = [] {
      rt::ModuleTypes types;
      types.add<Sensor>("sensor");
      types.add<Eye>("eye");
      return types;
    }();
    return all;
  }
  hal::Os& os_ = hal::system_os();
  hal::EmptyBoard board_;
  rt::Graph graph_;
  mutable std::optional<rt::RealTimeExecutor> executor_;
  std::unique_ptr<tap::Name> name_;
  std::unique_ptr<tap::Server> server_;
};

constexpr const char* kDecoy = "decoy";

/// The second robot, until it is killed.
int be_decoy() {
  ::mlockall(MCL_CURRENT | MCL_FUTURE);
  const Robot decoy(kDecoy, false, nullptr);
  while (true) ::pause();
}

/// Starts it; answers its socket once that is there.
std::string start_decoy(Children& children, const std::string& folder) {
  auto child = hal::ChildProcess::start({hal::program_path(), "--decoy"}, "/dev/null");
  if (!child) std::exit(2);
  children.push_back(std::move(*child));
  const std::string socket = folder + "/" + kDecoy + ".sock";
  hal::Os& os = hal::system_os();
  for (int look = 0; look < 500 && !std::filesystem::exists(socket); ++look) os.sleep_until(os.now() + 10ms);
  return socket;
}

int run(int turns) {
  ::mlockall(MCL_CURRENT | MCL_FUTURE);
  std::string folder = (std::filesystem::temp_directory_path() / "sinew-bench-XXXXXX").string();
  if (!::mkdtemp(folder.data())) return 2;
  ::setenv("SINEW_RUN_DIR", folder.c_str(), 1);
  hal::Os& os = hal::system_os();
  Turn turn;
  bool good = true;
  {
    const Robot robot("bench", true, &turn);
    Children decoys;
    const std::string decoy = start_decoy(decoys, folder);
    const std::vector<std::string> hostiles{"spin", "wake", "flood", "garbage", "killed"};
    const std::vector<std::string> burners(hostiles.size(), "burn");
    Pairs p50_alone, p50_burn, p50_decoy, p99_alone, p99_burn, p99_decoy, p99_floor;
    for (int i = 0; i < turns; ++i) {
      std::vector<double> alone, beside, burned, elsewhere;
      const auto with = [&](const std::vector<std::string>& what, const std::string& socket) {
        const Children children = start(what, socket);
        os.sleep_until(os.now() + kSettle);
        return turn.run(os);
      };
      const auto first = [&] { alone = turn.run(os), beside = with(hostiles, robot.socket()); };
      const auto second = [&] { elsewhere = with(hostiles, decoy), burned = with(burners, robot.socket()); };
      if (i % 2 == 0) first(), second();
      if (i % 2 == 1) second(), first();
      const auto add = [](Pairs& pairs, std::vector<double>& ours, std::vector<double>& floor, double q) {
        pairs.add({quantile(ours, q)}, {quantile(floor, q)});
      };
      add(p50_alone, beside, alone, 0.5), add(p99_alone, beside, alone, 0.99);
      add(p50_burn, beside, burned, 0.5), add(p99_burn, beside, burned, 0.99);
      add(p50_decoy, beside, elsewhere, 0.5), add(p99_decoy, beside, elsewhere, 0.99);
      add(p99_floor, elsewhere, burned, 0.99);
    }
    constexpr double kInformation = 0;
    good &= report("hostile_p50_beside_alone", p50_alone.ratio(), 1.2);
    good &= report("hostile_p50_beside_plain_load", p50_burn.ratio(), 1.2);
    good &= report("hostile_p50_beside_decoy", p50_decoy.ratio(), 1.2);
    good &= report("hostile_p99_beside_decoy", p99_decoy.ratio(), 1.2);
    report("hostile_p99_beside_alone", p99_alone.ratio(), kInformation);
    report("hostile_p99_beside_plain_load", p99_burn.ratio(), kInformation);
    report("decoy_p99_beside_plain_load", p99_floor.ratio(), kInformation);
    const tap::ServerStats& s = robot.served();
    std::printf("%-34s %llu connections, %llu requests, %llu of garbage\n", "  meanwhile at the socket",
                static_cast<unsigned long long>(s.accepted.value()),
                static_cast<unsigned long long>(s.requests.value()),
                static_cast<unsigned long long>(s.garbage.value()));
    if (!robot.is_well()) good = false, std::printf("the robot was hurt\n");
  }
  std::filesystem::remove_all(folder);
  return good ? 0 : 1;
}

}  // namespace
}  // namespace sinew::bench

int main(int argc, char** argv) {
  if (argc > 1 && std::string_view(argv[1]) == "--decoy") return sinew::bench::be_decoy();
  return sinew::bench::run(std::max(15, argc > 1 ? std::atoi(argv[1]) : 15));
}
