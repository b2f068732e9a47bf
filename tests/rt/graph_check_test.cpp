// Every problem of a graph, its exact text, and all of them in one run.
#include <gmock/gmock.h>

#include "graph_fixture.hpp"

namespace sinew::rt {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

void writes(Declaration& d, Probe& p) { d.out("out", p.out); }
void reads(Declaration& d, Probe& p) { d.in("in", p.in); }

/// Good as it stands: src -> ctl in thread control, vis in a thread of its own, motors behind the guardian.
class GraphCheck : public ::testing::Test {
 protected:
  GraphRig g;
  void SetUp() override {
    g.module("src", writes);
    g.module("ctl",
             [](Declaration& d, Probe& p) {
               d.in("in", p.in);
               d.out("command", p.command);
               d.param("gain", p.gain, {.unit = "rad", .min = 0.0, .max = 2.0});
             },
             {{"in", "src.out"}})
        .params["gain"] = {1.5, 103};
    g.module("vis", reads, {{"in", "src.out"}});
    g.periodic("control", 80, 1ms, {"src", "ctl"});
    g.on_topic("vision", 40, "src.out", {"vis"}).timeout = 100ms;
    g.motors("ctl.command");
    g.spec.chains.push_back({"c", {"src.out", 0}, {"guardian.motors", 0}, 5ms, 60});
  }
  ModuleSpec& module(const std::string& name) {
    for (ModuleSpec& m : g.spec.modules)
      if (m.name == name) return m;
    std::abort();
  }
};

TEST_F(GraphCheck, AGoodGraphHasNoProblems) { EXPECT_THAT(g.problems(), IsEmpty()); }

TEST_F(GraphCheck, UnknownModuleTypeListsTheKnownOnes) {
  module("vis").type = "test::Vision";
  EXPECT_THAT(g.problems(), ElementsAre("r:102: module.vis.type: \"test::Vision\": a known module type: test::ctl "
                                        "test::src test::vis"));
}

TEST_F(GraphCheck, AModuleIsInOneThread) {
  g.module("idle", writes);
  g.spec.threads[1].order.push_back({"ctl", 0});
  EXPECT_THAT(g.problems(),
              ElementsAre("r:101: module.ctl: in threads control vision: named once, in the order of one thread",
                          "r:103: module.idle: in no thread: named in the order of one thread"));
}

TEST_F(GraphCheck, AnUnknownNameInOrderListsTheModules) {
  g.spec.threads[0].order.push_back({"mixer", 17});
  EXPECT_THAT(g.problems(), ElementsAre("r:17: thread.control.order: \"mixer\": a module: guardian src ctl vis"));
}

TEST_F(GraphCheck, AThreadHasModules) {
  g.periodic("empty", 1, 1ms, {});
  EXPECT_THAT(g.problems(), ElementsAre("r:12: thread.empty.order: []: at least one module"));
}

TEST_F(GraphCheck, AnUnboundInputNamesItsCandidates) {
  module("vis").in.clear();
  EXPECT_THAT(g.problems(), ElementsAre("r:102: module.vis.in.in: missing: a topic of Pair: src.out"));
}

TEST_F(GraphCheck, AnOptionalInputMayStayUnbound) {
  g.module("free", [](Declaration& d, Probe& p) { d.in("in", p.in, {.optional = true}); });
  g.spec.threads[1].order.push_back({"free", 0});
  EXPECT_THAT(g.problems(), IsEmpty());
}

TEST_F(GraphCheck, AnUnknownTopicNamesTheCandidates) {
  module("vis").in["in"] = {"src.oot", 33};
  EXPECT_THAT(g.problems(), ElementsAre("r:33: module.vis.in.in: \"src.oot\": a topic of Pair: src.out"));
}

TEST_F(GraphCheck, AnInputThatTheModuleDoesNotHaveIsNamed) {
  module("vis").in["picture"] = {"src.out", 34};
  module("src").in["in"] = {"src.out", 35};
  EXPECT_THAT(g.problems(), ElementsAre("r:34: module.vis.in.picture: \"src.out\": an input of test::vis: in",
                                        "r:35: module.src.in.in: \"src.out\": test::src has no inputs"));
}

TEST_F(GraphCheck, ATypeMismatchNamesBothTypes) {
  module("vis").in["in"] = {"ctl.command", 36};
  EXPECT_THAT(g.problems(),
              ElementsAre("r:36: module.vis.in.in: \"ctl.command\" of ActuatorCommand: a topic of Pair: src.out"));
}

TEST_F(GraphCheck, ATopicHasOneWriter) {
  g.module("src", writes);
  const auto problems = g.problems();
  EXPECT_THAT(problems,
              UnorderedElementsAre("r:103: module.src: \"src\": a name that no other module has",
                                   "r:103: topic.src.out: two writers: one writer; give the modules different names"));
}

TEST_F(GraphCheck, PortNamesOfAModuleDiffer) {
  g.module("twice", [](Declaration& d, Probe& p) {
    d.out("out", p.out);
    d.out("out", p.second);
  });
  g.spec.threads[0].order.push_back({"twice", 0});
  EXPECT_THAT(g.problems(), UnorderedElementsAre(
                                "r:103: module.twice: \"out\": port names of test::twice that differ; two writers of "
                                "one topic are not possible",
                                "r:103: topic.twice.out: two writers: one writer; give the modules different names"));
}

TEST_F(GraphCheck, AnInputFromALaterModuleIsDeclaredPrevious) {
  g.spec.threads[0].order = {{"ctl", 0}, {"src", 0}};
  EXPECT_THAT(g.problems(),
              ElementsAre("r:101: module.ctl.in.in: \"src.out\": a topic of another thread or of a module "
                          "before ctl in thread control; this input is not declared `previous`"));
}

TEST_F(GraphCheck, PreviousIsOnlyForLaterModulesOfTheThread) {
  const auto previous = [](Declaration& d, Probe& p) { d.in("in", p.in, {.previous = true}); };
  g.module("near", previous, {{"in", "src.out"}});
  g.module("far", previous, {{"in", "src.out"}});
  g.spec.threads[0].order.push_back({"near", 0});
  g.spec.threads[1].order.push_back({"far", 0});
  EXPECT_THAT(g.problems(),
              ElementsAre("r:103: module.near.in.in: \"src.out\": a topic of near or of a module after it in thread "
                          "control; this input is declared `previous`",
                          "r:104: module.far.in.in: \"src.out\": a topic of far or of a module after it in thread "
                          "vision; this input is declared `previous`"));
}

TEST_F(GraphCheck, AMissingExecutionTimeIsAProblemInVirtualTimeOnly) {
  module("vis").exec = {};
  g.spec.guardian.exec = {};
  EXPECT_THAT(g.problems({.virtual_time = false}), IsEmpty());
  EXPECT_THAT(
      g.problems(),
      ElementsAre(
          "r:0: guardian.exec_us: missing: exec_us, exec_trace_us or exec_measured_factor; virtual time needs one",
          "r:102: module.vis.exec_us: missing: exec_us, exec_trace_us or exec_measured_factor; virtual time needs "
          "one"));
}

TEST_F(GraphCheck, ExecutionTimesAreInRange) {
  module("src").exec = {ExecModel::Kind::constant, 0ns, {}, 1.0};
  module("ctl").exec = {ExecModel::Kind::trace, 0ns, {}, 1.0};
  module("vis").exec = {ExecModel::Kind::measured, 0ns, {}, 0.0};
  EXPECT_THAT(g.problems(),
              ElementsAre("r:100: module.src.exec_us: 0: a number from 0.001 to 3600000000",
                          "r:101: module.ctl.exec_trace_us: []: an array of numbers from 0.001 to 3600000000",
                          "r:102: module.vis.exec_measured_factor: 0: a number from 0.01 to 1000"));
}

TEST_F(GraphCheck, PrioritiesStayBelowTheGuardians) {
  g.spec.guardian.priority = 80;
  EXPECT_THAT(g.problems(),
              ElementsAre("r:10: thread.control.priority: 80: an integer from 0 to 79; the guardian has 80"));
  g.spec.guardian.priority = 100;
  EXPECT_THAT(g.problems(), ElementsAre("r:0: guardian.priority: 100: an integer from 1 to 99"));
}

TEST_F(GraphCheck, PrioritiesAreInRangeWithoutAGuardian) {
  g.spec.actuators.clear();
  g.spec.chains.clear();
  g.spec.threads[0].priority = 99;
  g.spec.threads[1].priority = -1;
  EXPECT_THAT(g.problems(), ElementsAre("r:10: thread.control.priority: 99: an integer from 0 to 98",
                                        "r:11: thread.vision.priority: -1: an integer from 0 to 98"));
}

TEST_F(GraphCheck, ABestEffortModuleIsRefusedInARealTimeThread) {
  g.module("cv", [](Declaration& d, Probe&) { d.best_effort(); });
  g.spec.threads[1].order.push_back({"cv", 0});
  EXPECT_THAT(g.problems(), ElementsAre("r:103: module.cv: best effort, in thread vision of priority 40: a thread of "
                                        "priority 0: test::cv calls libraries that allocate or block"));
  g.spec.threads[1].priority = 0;
  EXPECT_THAT(g.problems(), IsEmpty());
}

TEST_F(GraphCheck, TimesOfAThreadAreInRange) {
  g.spec.threads[0].period = 5us;
  g.spec.threads[0].phase = -1us;
  g.spec.threads[0].timeout = 1ms;
  g.spec.threads[0].overrun = ThreadSpec::Overrun::catch_up;
  g.spec.threads[0].catch_up_max = 0;
  g.spec.threads[0].stack_kib = 4;
  g.spec.threads[1].timeout = 3601s;
  EXPECT_THAT(
      g.problems(),
      ElementsAre(
          "r:10: thread.control.period_us: 5: a number from 10 to 3600000000",
          "r:10: thread.control.phase_us: -1: a number from 0 to 3600000000",
          "r:10: thread.control.timeout_us: 1000: none; a thread with period_us is released by its period alone",
          "r:10: thread.control.catch_up_max: 0: an integer from 1 to 1000",
          "r:10: thread.control.stack_kib: 4: an integer from 16 to 65536",
          "r:11: thread.vision.timeout_us: 3.601e+09: a number from 0 to 3600000000"));
}

TEST_F(GraphCheck, TriggerTopicsAreKnownAndOfOtherThreads) {
  g.spec.threads[1].topics = {{"src.on", 20}};
  g.module("loop", writes);
  g.on_topic("busy", 1, "loop.out", {"loop"});
  g.thread("never", 1, {}).trigger = ThreadSpec::Trigger::topics;
  EXPECT_THAT(g.problems(),
              UnorderedElementsAre(
                  "r:20: thread.vision.trigger: \"src.on\": a topic: guardian.motors src.out ctl.command loop.out",
                  "r:12: thread.busy.trigger: \"loop.out\": a topic that this thread does not write itself",
                  "r:13: thread.never.trigger: missing: a topic: guardian.motors src.out ctl.command loop.out",
                  "r:13: thread.never.order: []: at least one module"));
}

TEST_F(GraphCheck, ADeviceTriggerNamesADriverOfTheThread) {
  g.spec.threads[1].trigger = ThreadSpec::Trigger::device;
  g.spec.threads[1].device_module = "src";
  EXPECT_THAT(g.problems(), ElementsAre("r:11: thread.vision.device: \"src\": a driver module in `order`: vis"));
}

TEST_F(GraphCheck, ADriverWithoutADeviceCannotTrigger) {
  g.spec.threads[1].trigger = ThreadSpec::Trigger::device;
  g.spec.threads[1].device_module = "vis";
  EXPECT_EQ(g.build(), "r:102: module.vis: not ready: not supported: trigger `device`: this module has no device");
}

TEST_F(GraphCheck, NamesAreUniqueAndPlain) {
  g.spec.threads[1].name = "control";
  g.spec.actuators.push_back(g.spec.actuators[0]);
  g.spec.chains.push_back(g.spec.chains[0]);
  g.spec.chains[0].name = "IMU to motors";
  g.spec.topics.push_back({"src.out", 0, 3, 70});
  g.spec.topics.push_back({"src.out", 0, 3, 71});
  EXPECT_THAT(g.problems(), UnorderedElementsAre(
                                "r:11: thread.control: \"control\": a name that no other thread has",
                                "r:0: topic.guardian.motors: two writers: one writer; give the modules different names",
                                "r:50: actuator.motors: \"motors\": a name that no other actuator has",
                                "r:60: chain.IMU to motors: \"IMU to motors\": a name of a-z, 0-9 and _",
                                "r:71: topic.src.out: \"src.out\": a name that no other topic has"));
}

TEST_F(GraphCheck, ActuatorsAreChecked) {
  g.spec.chains.clear();
  ActuatorSpec& a = g.spec.actuators[0];
  a.command = {"src.out", 51};
  a.channels = 9;
  a.min = 11;
  a.rate_per_s = -1;
  a.lease = 0ns;
  EXPECT_THAT(
      g.problems(),
      ElementsAre("r:50: actuator.motors.channels: 9: an integer from 1 to 8",
                  "r:50: actuator.motors.limit: [ 11, 10 ]: [smallest, largest], two numbers in this order",
                  "r:50: actuator.motors.rate_per_s: -1: a number from 0 up; 0: no limit",
                  "r:50: actuator.motors.lease_ms: 0: a number from 0.1 to 10000",
                  "r:51: actuator.motors.command: \"src.out\" of Pair: a topic of ActuatorCommand: ctl.command"));
  g.spec.actuators[0] = {};
  g.motors("mixer.motors");
  g.spec.actuators.erase(g.spec.actuators.begin());
  EXPECT_THAT(g.problems(),
              ElementsAre("r:50: actuator.motors.command: \"mixer.motors\": a topic of ActuatorCommand: ctl.command"));
}

TEST_F(GraphCheck, ChainsLeadFromOneTopicToAnother) {
  g.spec.chains = {{"a", {"src.in", 61}, {"guardian.motor", 62}, 1ms, 60},
                   {"b", {"ctl.command", 0}, {"src.out", 63}, -1ms, 60}};
  EXPECT_THAT(g.problems(),
              UnorderedElementsAre("r:61: chain.a.from: \"src.in\": a topic: guardian.motors src.out ctl.command",
                                   "r:62: chain.a.to: \"guardian.motor\": a topic: guardian.motors src.out ctl.command",
                                   "r:60: chain.b.budget_ms: -1: a number from 0 up; 0: no budget",
                                   "r:63: chain.b.to: \"src.out\": a topic that ctl.command leads to"));
}

TEST_F(GraphCheck, ThereAreAtMostEightChains) {
  for (int i = 0; i < 8; ++i)
    g.spec.chains.push_back({"c" + std::to_string(i), {"src.out", 0}, {"ctl.command", 0}, 1ms, 61 + i});
  EXPECT_THAT(g.problems(), ElementsAre("r:68: chain: 9: at most 8"));
}

TEST_F(GraphCheck, ImagesHaveACapacityAndNothingElseHas) {
  struct Camera final : Module {
    void declare(Declaration& d) override { d.out("image", image); }
    Status step(const Step&) noexcept override { return Status::ok; }
    Out<msg::Image> image;
  };
  g.types.add<Camera>("test::Camera");
  ModuleSpec camera = module("vis");
  camera.name = "camera", camera.type = "test::Camera", camera.in.clear();
  g.spec.modules.push_back(camera);
  g.spec.threads[1].order.push_back({"camera", 0});
  g.spec.topics.push_back({"src.out", 640, 0, 70});
  g.spec.topics.push_back({"cam.image", 640, 0, 71});
  EXPECT_THAT(
      g.problems(),
      ElementsAre("r:70: topic.src.out.image: 640 bytes: none: src.out carries Pair",
                  "r:71: topic.cam.image: \"cam.image\": a topic: guardian.motors src.out ctl.command camera.image",
                  "r:102: topic.camera.image.image: missing: width, height and format: camera.image carries Image"));
}

TEST_F(GraphCheck, ParametersAreKnownOfTheirTypeAndInTheirRange) {
  module("ctl").params = {{"gain", {2.5, 30}}, {"gian", {1.0, 31}}};
  module("src").params = {{"gain", {true, 32}}};
  EXPECT_THAT(g.problems(), ElementsAre("r:30: module.ctl.params.gain: 2.5: a number from 0 to 2 rad",
                                        "r:31: module.ctl.params.gian: 1: a parameter of test::ctl: gain",
                                        "r:32: module.src.params.gain: true: test::src has no parameters"));
  module("src").params.clear();
  module("ctl").params = {{"gain", {std::string("high"), 30}}};
  EXPECT_THAT(g.problems(), ElementsAre("r:30: module.ctl.params.gain: \"high\": a number from 0 to 2 rad"));
}

TEST_F(GraphCheck, CpuNumbersAreThoseOfTheExecutor) {
  g.spec.threads[0].cpus = {1};
  EXPECT_THAT(g.problems(), ElementsAre("r:10: thread.control.cpus: 1: numbers from 0 to 0; robot.virtual_cores is 1"));
  EXPECT_THAT(g.problems({.virtual_time = false, .cpus = 2}), IsEmpty());
  EXPECT_THAT(g.problems({.virtual_time = false, .cpus = 1}),
              ElementsAre("r:10: thread.control.cpus: 1: numbers from 0 to 0"));
  g.spec.virtual_cores = 65;
  EXPECT_THAT(g.problems(), ElementsAre("r:0: robot.virtual_cores: 65: an integer from 1 to 64"));
}

TEST_F(GraphCheck, AllProblemsComeInOneRunSortedByLine) {
  g.spec.threads[0].priority = 120;
  module("vis").in["in"] = {"nothing", 33};
  g.spec.actuators[0].lease = 0ns;
  EXPECT_EQ(g.problems().size(), 3u);
}

TEST_F(GraphCheck, TheSlotsOfATopicAreCountedTermByTerm) {
  ASSERT_EQ(g.build(), "");
  const SlotSum sum = g.graph->slots(g.topic("src.out"));
  EXPECT_EQ(sum.burst, 1u);
  EXPECT_EQ(sum.keep, 1u);
  EXPECT_EQ(sum.pins, 1u) << "vis, in another thread; ctl runs in the writer's own";
  EXPECT_EQ(sum.pending, 0u);
  EXPECT_EQ(sum.total(), 3u);
}

}  // namespace
}  // namespace sinew::rt
