// Every check of `sinew doctor`, both ways, on machines that are made of files.
#include "hal/linux/system_check.hpp"

#include <gmock/gmock.h>

#include "made_machine.hpp"

namespace sinew::hal::system_check_test {
namespace {

using enum CheckState;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST_F(Machine, ThatSaysNothingIsUnknownAndNotIll) {
  std::vector<std::string> unknowns;
  for (const auto& c : check_system(SystemFiles(root_.string()), demand)) {
    EXPECT_NE(c.state, problem) << c.id;
    EXPECT_NE(c.state, warning) << c.id;
    if (c.state == unknown) unknowns.push_back(c.id);
  }
  EXPECT_THAT(unknowns, ElementsAre("sched_fifo", "throttling", "memory_lock", "preemption", "hres_timers",
                                    "clock_source", "timer_slack", "cpus"));
}

TEST_F(Machine, EveryAilmentComesWithAdvice) {
  file("proc/self/status", kNoPrivilege);
  file("proc/self/limits", limits("0", "65536"));
  file("proc/version", "Linux version 6.1.0 #1 SMP Debian");
  file("proc/cmdline", "quiet highres=off");
  file("proc/sys/kernel/sched_rt_runtime_us", "0");
  file("proc/sys/kernel/sched_rt_period_us", "1000000");
  file("proc/self/timerslack_ns", "5000000");
  file("sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet");
  cpus(2);
  file("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "ondemand");
  file("sys/devices/system/cpu/cpu1/cpuidle/state2/latency", "500");
  irq_thread("51", "irq/45-can0", 50);
  thread("control", 80, {7});
  irq(30, "eth0", "0-7");
  for (const auto& c : check_system(SystemFiles(root_.string()), demand)) {
    EXPECT_TRUE(c.state == problem || c.state == warning) << c.id << ": " << c.seen;
    EXPECT_FALSE(c.advice.empty()) << c.id;
  }
}

// ---- preemption

struct Kernel {
  const char *version, *preempt_file, *command_line, *config;
  CheckState state;
  const char* seen;
};
class Preemption : public Machine, public ::testing::WithParamInterface<Kernel> {};
TEST_P(Preemption, IsReadFromWhateverSaysIt) {
  const Kernel& k = GetParam();
  if (*k.version) file("proc/version", k.version);
  if (*k.preempt_file) file("sys/kernel/debug/sched/preempt", k.preempt_file);
  if (*k.command_line) file("proc/cmdline", k.command_line);
  file("proc/sys/kernel/osrelease", "6.6.1");
  if (*k.config) file("boot/config-6.6.1", std::string("# CONFIG\n") + k.config);
  EXPECT_EQ(look("preemption").state, k.state);
  EXPECT_THAT(look("preemption").seen, HasSubstr(k.seen));
}
INSTANTIATE_TEST_SUITE_P(
    Kernels, Preemption,
    ::testing::Values(Kernel{"#1 SMP PREEMPT_RT Debian", "", "", "", ok, "PREEMPT_RT"},
                      Kernel{"#1 SMP PREEMPT RT Debian", "", "", "", ok, "PREEMPT_RT"},
                      Kernel{"#1 SMP PREEMPT Thu", "", "", "", warning, "preemptible (full), but not"},
                      Kernel{"#1 SMP Thu", "", "", "", warning, "hardly preemptible"},
                      Kernel{"#1 SMP PREEMPT_DYNAMIC", "", "", "", unknown, "does not say"},
                      Kernel{"#1 SMP PREEMPT_DYNAMIC", "none voluntary (full) lazy", "", "", warning, "(full)"},
                      Kernel{"#1 SMP PREEMPT_DYNAMIC", "(none) voluntary full lazy", "quiet preempt=full", "", warning,
                             "hardly preemptible (none)"},
                      Kernel{"#1 SMP PREEMPT_DYNAMIC", "", "quiet preempt=lazy", "CONFIG_PREEMPT_NONE=y", warning,
                             "(lazy)"},
                      Kernel{"#1 SMP PREEMPT_DYNAMIC", "", "", "CONFIG_PREEMPT_NONE=y", warning, "(none)"},
                      Kernel{"#1 SMP PREEMPT_DYNAMIC", "", "", "CONFIG_PREEMPT=y", warning, "(full)"}));

TEST_F(Machine, RealTimeKernelsSayItInAFileOfTheirOwn) {
  file("sys/kernel/realtime", "1");
  EXPECT_EQ(look("preemption").state, ok);
}

// ---- privileges

TEST_F(Machine, FixedPrioritiesNeedTheLimitOrTheCapability) {
  thread("control", 80);
  file("proc/self/status", kNoPrivilege);
  file("proc/self/limits", limits("0", "unlimited"));
  EXPECT_EQ(look("sched_fifo").state, problem);
  EXPECT_THAT(look("sched_fifo").seen, HasSubstr("may not use fixed priorities"));
  file("proc/self/limits", limits("50", "unlimited"));
  EXPECT_EQ(look("sched_fifo").state, problem);
  EXPECT_THAT(look("sched_fifo").seen, HasSubstr("up to 50; the robot asks for 80"));
  file("proc/self/limits", limits("80", "unlimited"));
  EXPECT_EQ(look("sched_fifo").state, ok);
  file("proc/self/limits", limits("0", "unlimited"));
  file("proc/self/status", kRoot);
  EXPECT_EQ(look("sched_fifo").state, ok);
}

TEST_F(Machine, ARobotOfOrdinaryThreadsNeedsNoFixedPriority) {
  thread("slow", 0);
  file("proc/self/status", kNoPrivilege);
  file("proc/self/limits", limits("0", "unlimited"));
  EXPECT_EQ(look("sched_fifo").state, ok);
}

TEST_F(Machine, MemoryIsLockedUpToTheLimit) {
  thread("control", 80);
  demand.locked_bytes = 10'000'000;
  file("proc/self/status", kNoPrivilege);
  file("proc/self/limits", limits("0", "8388608"));
  EXPECT_EQ(look("memory_lock").state, problem);
  EXPECT_THAT(look("memory_lock").seen, HasSubstr("8 MiB can be locked, 10 MiB are asked for"));
  file("proc/self/limits", limits("0", "16777216"));
  EXPECT_EQ(look("memory_lock").state, ok);
  file("proc/self/limits", limits("0", "unlimited"));
  EXPECT_EQ(look("memory_lock").state, ok);
  file("proc/self/limits", limits("0", "65536"));
  file("proc/self/status", kRoot);
  EXPECT_EQ(look("memory_lock").state, ok);
  file("proc/self/status", kNoPrivilege);
  demand = {};
  EXPECT_EQ(look("memory_lock").state, warning) << "without a robot nobody asks for it yet";
}

TEST_F(Machine, TheThrottleIsFineAsTheKernelSetsIt) {
  file("proc/sys/kernel/sched_rt_period_us", "1000000");
  file("proc/sys/kernel/sched_rt_runtime_us", "950000");
  EXPECT_EQ(look("throttling").state, ok);
  EXPECT_THAT(look("throttling").seen, HasSubstr("frozen for 50 ms of every 1000 ms"));
  file("proc/sys/kernel/sched_rt_runtime_us", "-1");
  EXPECT_EQ(look("throttling").state, ok);
  file("proc/sys/kernel/sched_rt_runtime_us", "500000");
  EXPECT_EQ(look("throttling").state, warning);
  file("proc/sys/kernel/sched_rt_runtime_us", "0");
  EXPECT_EQ(look("throttling").state, problem);
}

TEST_F(Machine, AControlGroupWithoutRealTimeBudgetIsNamed) {
  file("proc/sys/kernel/sched_rt_period_us", "1000000");
  file("proc/sys/kernel/sched_rt_runtime_us", "950000");
  file("proc/self/cgroup", "9:name=systemd:/user\n3:cpu,cpuacct:/robots\n0::/user.slice");
  file("sys/fs/cgroup/cpu,cpuacct/robots/cpu.rt_runtime_us", "0");
  EXPECT_EQ(look("throttling").state, problem);
  EXPECT_THAT(look("throttling").seen, HasSubstr("control group"));
  file("sys/fs/cgroup/cpu,cpuacct/robots/cpu.rt_runtime_us", "100000");
  EXPECT_EQ(look("throttling").state, ok);
}

// ---- clocks and timers

TEST_F(Machine, TimersNeedHighResolution) {
  file("proc/timer_list", "Timer List Version: v0.10\n  .hres_active    : 1");
  EXPECT_EQ(look("hres_timers").state, ok);
  file("proc/timer_list", "Timer List Version: v0.10\n  .hres_active    : 0");
  EXPECT_EQ(look("hres_timers").state, problem);
  std::filesystem::remove(root_ / "proc/timer_list");
  file("proc/sys/kernel/osrelease", "6.6.1");
  file("boot/config-6.6.1", "CONFIG_HIGH_RES_TIMERS=y");
  EXPECT_EQ(look("hres_timers").state, ok);
  file("boot/config-6.6.1", "# CONFIG_HIGH_RES_TIMERS is not set");
  EXPECT_EQ(look("hres_timers").state, problem);
}

TEST_F(Machine, ASlowClockSourceIsNamed) {
  const std::string path = "sys/devices/system/clocksource/clocksource0/current_clocksource";
  for (const char* fast : {"tsc", "arch_sys_counter", "kvm-clock"}) {
    file(path, fast);
    EXPECT_EQ(look("clock_source").state, ok) << fast;
  }
  for (const char* slow : {"hpet", "acpi_pm", "jiffies"}) {
    file(path, slow);
    EXPECT_EQ(look("clock_source").state, warning) << slow;
    EXPECT_THAT(look("clock_source").seen, HasSubstr(slow));
  }
}

TEST_F(Machine, EnlargedTimerSlackIsNamed) {
  file("proc/self/timerslack_ns", "50000");
  EXPECT_EQ(look("timer_slack").state, ok);
  file("proc/self/timerslack_ns", "5000000");
  EXPECT_EQ(look("timer_slack").state, warning);
  EXPECT_THAT(look("timer_slack").seen, HasSubstr("5000 us"));
}

// ---- processors

TEST_F(Machine, EveryThreadsProcessorsMustBeUsable) {
  file("proc/self/status", kRoot);  // 0-1
  cpus(4);
  thread("control", 80, {0, 1});
  EXPECT_EQ(look("cpus").state, ok);
  thread("vision", 40, {1, 2, 3});
  EXPECT_EQ(look("cpus").state, problem);
  EXPECT_THAT(look("cpus").seen, HasSubstr("thread vision asks for 2,3"));
  file("proc/self/status", "Cpus_allowed_list:\t0-7");
  EXPECT_EQ(look("cpus").state, ok);
  file("sys/devices/system/cpu/online", "0-2");
  EXPECT_THAT(look("cpus").seen, HasSubstr("thread vision asks for 3"));
}

TEST_F(Machine, GovernorsThatFollowTheLoadAreNamedWithTheirProcessors) {
  cpus(12);
  EXPECT_EQ(look("governor").state, ok) << "no scaling at all";
  for (int i = 0; i < 12; ++i)
    file("sys/devices/system/cpu/cpu" + std::to_string(i) + "/cpufreq/scaling_governor", "performance");
  EXPECT_EQ(look("governor").state, ok);
  for (int i : {2, 10, 11})
    file("sys/devices/system/cpu/cpu" + std::to_string(i) + "/cpufreq/scaling_governor", "powersave");
  EXPECT_EQ(look("governor").state, warning);
  EXPECT_THAT(look("governor").seen, HasSubstr("processors 2,10,11 follows their load (powersave)"));
}

TEST_F(Machine, DeepIdleStatesMatterWhereNobodyMayForbidThem) {
  cpus(2);
  const std::string state = "sys/devices/system/cpu/cpu1/cpuidle/state3/";
  file("sys/devices/system/cpu/cpu1/cpuidle/state0/latency", "0");
  file(state + "latency", "133");
  file(state + "name", "C6");
  EXPECT_EQ(look("idle_states").state, warning);
  EXPECT_THAT(look("idle_states").seen, HasSubstr("133 us (C6)"));
  file("dev/cpu_dma_latency", "");
  EXPECT_EQ(look("idle_states").state, ok) << "a run forbids them";
  std::filesystem::remove(root_ / "dev/cpu_dma_latency");
  file(state + "disable", "1");
  EXPECT_EQ(look("idle_states").state, ok) << "switched off";
}

TEST_F(Machine, IsolatedProcessorsAreThereForWhoAsksForThem) {
  file("proc/self/status", kRoot);  // 0-1
  cpus(4);
  thread("control", 80, {2, 3});
  EXPECT_EQ(look("cpus").state, problem);
  EXPECT_EQ(look("isolation").state, warning);
  EXPECT_THAT(look("isolation").seen, HasSubstr("on 2,3 everything else runs, too"));
  EXPECT_THAT(look("isolation").advice, HasSubstr("isolcpus=2,3 nohz_full=2,3"));
  file("sys/devices/system/cpu/isolated", "3");
  EXPECT_THAT(look("isolation").seen, HasSubstr("on 2 everything else"));
  file("sys/devices/system/cpu/isolated", "2-3");
  EXPECT_EQ(look("cpus").state, ok);
  EXPECT_EQ(look("isolation").state, ok);
  EXPECT_THAT(look("isolation").seen, ::testing::Not(HasSubstr("without a tick")));
  file("sys/devices/system/cpu/nohz_full", "2-3");
  EXPECT_THAT(look("isolation").seen, HasSubstr("isolated and without a tick"));
  file("sys/devices/system/cpu/online", "0-2");
  EXPECT_THAT(look("cpus").seen, HasSubstr("thread control asks for 3")) << "isolated, and off";
}

TEST_F(Machine, OrdinaryThreadsNeedNoProcessorForThemselves) {
  thread("slow", 0, {1});
  thread("control", 80);
  EXPECT_EQ(look("isolation").state, ok);
}

// ---- interrupts

TEST_F(Machine, ForeignInterruptsOnTheRobotsProcessorsAreNamed) {
  thread("control", 80, {3});
  irq(30, "eth0", "0-2");
  irq(31, "can0", "3");
  EXPECT_EQ(look("irq_affinity").state, ok) << "its own device may be near";
  irq(32, "mmc0", "0-3");
  EXPECT_EQ(look("irq_affinity").state, warning);
  EXPECT_THAT(look("irq_affinity").seen, HasSubstr("32 (mmc0) on 0-3"));
  EXPECT_THAT(look("irq_affinity").seen, ::testing::Not(HasSubstr("eth0")));
  file("proc/irq/32/effective_affinity_list", "0");
  EXPECT_EQ(look("irq_affinity").state, ok) << "where it really goes counts";
}

TEST_F(Machine, AThreadAboveTheInterruptThreadOfItsDeviceStarvesItself) {
  irq_thread("51", "irq/45-can0", 50);
  irq_thread("52", "irq/46-nvme0q1", 50);
  thread("control", 80);
  thread("slow", 10);
  const SystemCheck check = look("irq_threads");
  EXPECT_EQ(check.state, problem);
  EXPECT_THAT(check.seen, HasSubstr("thread control (80) is not below can0 (50)"));
  EXPECT_THAT(check.advice, HasSubstr("chrt -f -p 81 51"));
  EXPECT_THAT(check.advice, ::testing::Not(HasSubstr("52"))) << "a disk's is none of the robot's";
  irq_thread("51", "irq/45-can0", 85);
  EXPECT_EQ(look("irq_threads").state, ok);
  EXPECT_THAT(look("irq_threads").seen, HasSubstr("can0 at 85"));
}

TEST_F(Machine, InterruptThreadsMatterToThreadsThatReadDevicesOnly) {
  irq_thread("51", "irq/79-fe205000.i2c", 50);
  demand.threads.push_back({"planner", 80, {}, false});
  EXPECT_EQ(look("irq_threads").state, ok);
  thread("imu", 60);
  EXPECT_EQ(look("irq_threads").state, problem);
}

TEST_F(Machine, DevicesAreKnownByWordsNotByLetters) {
  thread("control", 80);
  irq_thread("51", "irq/45-scanner", 50);  // "can" inside of a word
  EXPECT_EQ(look("irq_threads").state, ok);
  for (const char* name :
       {"irq/45-mcp251xf", "irq/45-spi0.0", "irq/9-fe804000.i2c", "irq/45-unicam", "irq/7-xhci_hcd"}) {
    irq_thread("51", name, 50);
    EXPECT_EQ(look("irq_threads").state, problem) << name;
  }
}

TEST(SystemFiles, CpuListsAreReadAndWritten) {
  EXPECT_THAT(cpu_list("0-2,5"), ElementsAre(0, 1, 2, 5));
  EXPECT_THAT(cpu_list("3"), ElementsAre(3));
  EXPECT_THAT(cpu_list(""), ElementsAre());
  EXPECT_THAT(cpu_list("x,1-"), ElementsAre());
  EXPECT_EQ(to_text({0, 1, 2, 3, 7}), "0-3,7");
  EXPECT_EQ(to_text({4, 5}), "4,5");
}

TEST(SystemFiles, TheLiveMachineIsLookedAtAsItIs) {
  const SystemFiles live("/");
  EXPECT_TRUE(live.is_live());
  EXPECT_TRUE(live.text("proc/version").value_or("").starts_with("Linux"));
  const auto checks = check_system(live, {});
  EXPECT_EQ(checks.size(), 13u);
  for (const auto& c : checks) EXPECT_FALSE(c.seen.empty()) << c.id;
}

}  // namespace
}  // namespace sinew::hal::system_check_test
