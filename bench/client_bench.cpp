// The age of a frame when another program has it: libsinew_client woken by the writer itself, beside a bare futex in
// shared memory. Both messages come from the same thread, in turn, and go to a process each. Then what waiting at 30 Hz
// costs, woken at once and by the doorbells' thread, and the ages of that mode and of looking each millisecond.
#include <linux/futex.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "client/sinew_client.h"
#include "hal/board.hpp"
#include "hal/platform.hpp"
#include "msg/image.hpp"
#include "pairs.hpp"
#include "rt/exec/real_time_executor.hpp"
#include "tap/server.hpp"

namespace sinew::bench {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t kWidth = 640, kHeight = 480, kFrameBytes = 2 * kWidth * kHeight;
constexpr std::size_t kMostSamples = 100'000;
constexpr double kGoal = 1.15, kGoalShare = 0.2;

/// Ages that a reading process measured; in memory of both.
struct Samples {
  std::atomic<std::uint32_t> count{0};
  std::array<float, kMostSamples> age_us{};
  void add(std::int64_t ns) {
    const std::uint32_t n = count.load(std::memory_order_relaxed);
    if (n == kMostSamples) return;
    age_us[n] = static_cast<float>(static_cast<double>(ns) * 1e-3);
    count.store(n + 1, std::memory_order_release);
  }
  std::vector<double> take(std::uint32_t from, std::uint32_t n) const {
    return {age_us.begin() + from, age_us.begin() + from + n};
  }
};

struct Shared {
  // The floor: as many slots as the topic has, since frames are read in place, and a word to sleep on that counts them.
  struct Slot {
    std::atomic<std::int64_t> stamp_ns{0};
    std::array<std::byte, kFrameBytes> frame{};
  };
  alignas(64) std::atomic<std::uint32_t> word{0};
  alignas(4096) std::array<Slot, 6> slots{};
  Slot& slot(std::uint32_t number) { return slots[number % slots.size()]; }
  // All processes.
  std::atomic<bool> alternates{true};  // false: every frame goes to the topic
  Samples floor, ours, bells, polled;
  std::atomic<std::int64_t> cpu_ns{0};
};

Shared* g_shared = nullptr;

std::int64_t now_ns() { return hal::system_os().now().ns; }

void wake(std::atomic<std::uint32_t>& word) { ::syscall(SYS_futex, &word, FUTEX_WAKE, 1, nullptr, nullptr, 0); }

/// With a time-out, as everybody who waits for a camera has one: the kernel's timer for it is part of the job.
void sleep_on(std::atomic<std::uint32_t>& word, std::uint32_t seen) {
  const std::int64_t until = now_ns() + 1'000'000'000;
  const timespec limit{static_cast<time_t>(until / 1'000'000'000), static_cast<long>(until % 1'000'000'000)};
  ::syscall(SYS_futex, &word, FUTEX_WAIT_BITSET, seen, &limit, nullptr, FUTEX_BITSET_MATCH_ANY);
}

/// Every second frame goes out the bare way, from the same step of the same thread.
class Camera final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override { d.out("raw", out_); }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    if (g_shared->alternates.load(std::memory_order_relaxed) && step.number % 2 == 0) {
      const std::uint32_t next = g_shared->word.load(std::memory_order_relaxed) + 1;
      g_shared->slot(next).stamp_ns.store(now_ns(), std::memory_order_relaxed);
      g_shared->word.store(next, std::memory_order_release);
      wake(g_shared->word);
      return rt::StepStatus::stale;
    }
    msg::Image& image = out_.loan();
    image.stamp = step.now;
    return image.format_as(msg::PixelFormat::yuyv, kWidth, kHeight) ? rt::StepStatus::ok : rt::StepStatus::fault;
  }

 private:
  rt::Out<msg::Image> out_;
};

rt::GraphSpec robot_spec() {
  rt::GraphSpec g;
  g.robot = "client_bench";
  rt::ModuleSpec camera;
  camera.name = "camera", camera.type = "Camera";
  g.modules = {camera};
  rt::ThreadSpec loop;
  loop.name = "loop", loop.period = 4ms, loop.priority = 50, loop.order = {{"camera", 0}};
  g.threads = {loop};
  rt::TopicSpec raw;
  raw.name = "camera.raw", raw.image_bytes = kFrameBytes, raw.wake_outsiders = true;
  g.topics = {raw};
  return g;
}

/// A process that reads until it is killed.
class Reader {
 public:
  explicit Reader(const std::function<void()>& body) : pid_(::fork()) {
    if (pid_ != 0) return;
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    body();
    std::_Exit(1);
  }
  ~Reader() {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

 private:
  pid_t pid_;
};

void read_floor() {
  std::uint32_t seen = 0;
  unsigned sum = 0;
  for (;;) {
    while (g_shared->word.load(std::memory_order_acquire) == seen) sleep_on(g_shared->word, seen);
    seen = g_shared->word.load(std::memory_order_acquire);
    const Shared::Slot& slot = g_shared->slot(seen);
    sum += std::to_integer<unsigned>(slot.frame[0]) + std::to_integer<unsigned>(slot.frame[kFrameBytes - 1]);
    keep(sum);
    g_shared->floor.add(now_ns() - slot.stamp_ns.load(std::memory_order_relaxed));
  }
}

enum class Mode { at_once, bells, polls };

void read_ours(Mode mode, Samples& samples) {
  sinew_robot* robot = nullptr;
  while (sinew_attach("client_bench", &robot) != SINEW_OK) std::this_thread::sleep_for(5ms);
  std::uint32_t topic = 0;
  if (sinew_topic_find(robot, "camera.raw", &topic) != SINEW_OK) return;
  if (mode == Mode::at_once && sinew_wake_at_once(robot, topic, 1) != SINEW_OK) return;
  sinew_message m{};
  std::uint32_t last = 0;
  unsigned sum = 0;
  for (;;) {
    if (mode == Mode::polls) {
      std::this_thread::sleep_for(1ms);
      if (sinew_latest(robot, topic, &m) != SINEW_OK || m.sequence == last) continue;
      last = m.sequence;
    } else if (sinew_wait(robot, topic, 1'000'000'000, &m) != SINEW_OK) {
      continue;
    }
    const auto* pixels = static_cast<const unsigned char*>(m.bulk);
    sum += pixels[0] + pixels[m.bulk_bytes - 1];
    keep(sum);
    samples.add(now_ns() - m.published_ns);
    rusage used{};
    ::getrusage(RUSAGE_SELF, &used);
    const auto ns = [](const timeval& t) { return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_usec * 1000; };
    g_shared->cpu_ns.store(ns(used.ru_utime) + ns(used.ru_stime), std::memory_order_relaxed);
  }
}

/// Processor time of this process' threads with that name.
std::int64_t thread_ns(const std::string& name) {
  std::int64_t sum = 0;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    std::string comm;
    std::int64_t ns = 0;
    std::getline(std::ifstream(task.path() / "comm") >> std::ws, comm);
    if (comm == name && std::ifstream(task.path() / "schedstat") >> ns) sum += ns;
  }
  return sum;
}

class Robot {
 public:
  Robot() : graph_(robot_spec(), types()) {
    rt::ConfigureOptions configure;
    configure.os = &os_;
    std::string why;
    auto name = tap::Name::take("client_bench", why);
    if (!graph_.check().empty() || !graph_.configure(board_, configure) || !name) std::abort();
    name_ = std::move(*name);
    rt::RealTimeOptions options;
    options.lock_memory = false;
    executor_ = std::make_unique<rt::RealTimeExecutor>(graph_, os_, options);
    if (!executor_->start()) std::abort();
    auto server = tap::Server::open(*name_, graph_, executor_->runner(), os_);
    if (!server) std::abort();
    server_ = std::move(*server);
  }
  ~Robot() {
    server_.reset();
    executor_->stop();
  }
  void set_period(hal::Duration period) {
    if (!graph_.set_period("loop", period)) std::abort();
  }

 private:
  static rt::ModuleTypes types() {
    rt::ModuleTypes t;
    t.add<Camera>("Camera");
    return t;
  }
  hal::Os& os_ = hal::system_os();
  hal::EmptyBoard board_;
  rt::Graph graph_;
  std::unique_ptr<tap::Name> name_;
  std::unique_ptr<rt::RealTimeExecutor> executor_;
  std::unique_ptr<tap::Server> server_;
};

void wait_for(const Samples& samples, std::uint32_t count) {
  while (samples.count.load(std::memory_order_acquire) < count) std::this_thread::sleep_for(10ms);
}

/// Shares of a core at 30 frames a second, over `seconds`: the waiting process, and the robot's thread that rings.
void report_share(const char* name, const Samples& samples, std::chrono::seconds seconds, double goal) {
  wait_for(samples, samples.count.load() + 20);
  const std::int64_t cpu = g_shared->cpu_ns.load(), bells = thread_ns("doorbells"), begin = now_ns();
  std::this_thread::sleep_for(seconds);
  const auto share = [&](std::int64_t ns) {
    return 100.0 * static_cast<double>(ns) / static_cast<double>(now_ns() - begin);
  };
  report_figure(name, share(g_shared->cpu_ns.load() - cpu), goal, "% of a core");
  report_figure("  and the robot's doorbells", share(thread_ns("doorbells") - bells), 0, "% of a core");
}

void report_age(const char* name, const Samples& samples) {
  wait_for(samples, 600);
  std::vector<double> ages = samples.take(100, 500);
  report_figure(name, median(ages), 0, "us old at the median");
}

int run(int pairs) {
  std::string folder = (std::filesystem::temp_directory_path() / "sinew-bench-XXXXXX").string();
  if (!::mkdtemp(folder.data())) return 1;
  ::setenv("SINEW_RUN_DIR", folder.c_str(), 1);
  void* memory =
      ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
  if (memory == MAP_FAILED) return 1;
  g_shared = new (memory) Shared;
  bool good = true;
  {
    constexpr std::uint32_t kBatch = 50, kWarm = 100;
    const Reader floor(read_floor), ours([] { read_ours(Mode::at_once, g_shared->ours); });
    const Robot robot;
    Pairs all;
    wait_for(g_shared->ours, kWarm), wait_for(g_shared->floor, kWarm);
    // The ours[n] and floor[n] of one batch are of the same half second.
    const std::uint32_t ours_from = g_shared->ours.count.load(), floor_from = g_shared->floor.count.load();
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(pairs); ++i) {
      wait_for(g_shared->ours, ours_from + (i + 1) * kBatch), wait_for(g_shared->floor, floor_from + (i + 1) * kBatch);
      all.add(g_shared->ours.take(ours_from + i * kBatch, kBatch),
              g_shared->floor.take(floor_from + i * kBatch, kBatch));
    }
    good = report("frame to another program, at once", all.ratio(), kGoal);
  }
  g_shared->alternates.store(false);
  const auto seconds = 10s;
  for (const Mode mode : {Mode::at_once, Mode::bells, Mode::polls}) {
    Samples& samples = mode == Mode::at_once ? g_shared->ours
                       : mode == Mode::bells ? g_shared->bells
                                             : g_shared->polled;
    samples.count.store(0);
    const Reader reader([&] { read_ours(mode, samples); });
    Robot robot;
    const char* age[] = {"  woken at once", "  woken by the doorbells", "  looking each millisecond"};
    const char* cost[] = {"waiting at 30 Hz, at once", "waiting at 30 Hz, doorbells", "looking each ms, at 30 Hz"};
    const auto i = static_cast<std::size_t>(mode);
    report_age(age[i], samples);
    robot.set_period(33333us);
    report_share(cost[i], samples, seconds, mode == Mode::polls ? 0 : kGoalShare);
  }
  std::filesystem::remove_all(folder);
  return good ? 0 : 1;
}

}  // namespace
}  // namespace sinew::bench

int main(int argc, char** argv) { return sinew::bench::run(argc > 1 ? std::atoi(argv[1]) : 25); }
