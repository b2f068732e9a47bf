// Every problem that Graph::check() knows, by its exact text and line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "msg/all.hpp"
#include "rt/graph.hpp"
#include "topic_fixture.hpp"

namespace sinew::rt::graph_check_test {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class Maker final : public Module {
 public:
  void declare(Declaration& d) override {
    d.out("pair", out_);
    d.param("rate_hz", rate_hz_, {.unit = "Hz", .min = 1.0, .max = 100.0});
    d.param("label", label_);
    d.param("count_min", count_min_, {.min = 2});
    d.param("fast", fast_);
  }
  StepStatus step(const Step&) noexcept override { return StepStatus::ok; }

 private:
  Out<Pair> out_;
  double rate_hz_ = 10;
  std::string label_;
  std::int64_t count_min_ = 2;
  bool fast_ = false;
};

class User final : public Module {
 public:
  void declare(Declaration& d) override {
    d.in("pair", in_);
    d.in("extra", extra_, {.optional = true});
    d.out("result", out_);
  }
  StepStatus step(const Step&) noexcept override { return StepStatus::ok; }

 private:
  In<Pair> in_;
  In<Pair> extra_;
  Out<msg::ActuatorCommand> out_;
};

/// Writes a topic whose type is that of its readers, and one named as a whole.
class Hearer final : public Module {
 public:
  void declare(Declaration& d) override { d.out("mate/pair", out_); }
  StepStatus step(const Step&) noexcept override { return StepStatus::ok; }
  AnyOut out_;
};

class LoopUser final : public Module {
 public:
  void declare(Declaration& d) override {
    d.in("pair", in_, {.previous = true});
    d.out("result", out_);
  }
  StepStatus step(const Step&) noexcept override { return StepStatus::ok; }

 private:
  In<Pair> in_;
  Out<msg::ActuatorCommand> out_;
};

class Viewer final : public Module {
 public:
  void declare(Declaration& d) override {
    d.out("image", out_);
    d.best_effort();
  }
  StepStatus step(const Step&) noexcept override { return StepStatus::ok; }

 private:
  Out<msg::Image> out_;
};

class TwoPorts final : public Module {
 public:
  void declare(Declaration& d) override {
    d.out("same", a_);
    d.out("same", b_);
  }
  StepStatus step(const Step&) noexcept override { return StepStatus::ok; }

 private:
  Out<Pair> a_, b_;
};

class DriverOfNothing final : public DriverModule {
 public:
  void declare(Declaration& d) override { d.raw("raw", raw_); }
  StepStatus step(const Step&) noexcept override { return StepStatus::ok; }

 private:
  Raw<Pair> raw_;
};

class ThreeChannels final : public Module {
 public:
  void declare(Declaration& d) override { d.out("command", out_, {.channels = 3}); }
  StepStatus step(const Step&) noexcept override { return StepStatus::ok; }

 private:
  Out<msg::ActuatorCommand> out_;
};

ModuleTypes all_types() {
  ModuleTypes types;
  types.add<Maker>("test::Maker");
  types.add<User>("test::User");
  types.add<LoopUser>("test::LoopUser");
  types.add<Viewer>("test::Viewer");
  types.add<ThreeChannels>("test::ThreeChannels");
  types.add<TwoPorts>("test::TwoPorts");
  types.add<DriverOfNothing>("test::DriverOfNothing");
  types.add<Hearer>("test::Hearer");
  return types;
}

/// A robot without faults: maker (line 11) and user (line 12) in thread control (line 5), motors (line 20), one chain
/// (line 30). Each test breaks it.
class GraphCheckTest : public ::testing::Test {
 protected:
  GraphCheckTest() {
    spec.threads.push_back(thread("control", {"maker", "user"}, 5));
    spec.modules.push_back(module("maker", "test::Maker", 11));
    spec.modules.push_back(module("user", "test::User", 12));
    spec.modules[1].in["pair"] = {"maker.pair", 13};
    ActuatorSpec a;
    a.name = "motors";
    a.command = {"user.result", 21};
    a.channels = 4;
    a.max = 1;
    a.lease = 20ms;
    a.line = 20;
    spec.actuators.push_back(a);
    spec.chains.push_back({"chain", {"maker.pair", 31}, {"user.result", 32}, 5ms, 30});
    spec.guardian.line = 40;
  }
  static ThreadSpec thread(const std::string& name, const std::vector<std::string>& order, int line) {
    ThreadSpec t;
    t.name = name;
    t.priority = 80;
    t.period = 1ms;
    for (const auto& m : order) t.order.push_back({m, line + 1});
    t.line = line;
    return t;
  }
  static ModuleSpec module(const std::string& name, const std::string& type, int line) {
    ModuleSpec m;
    m.name = name;
    m.type = type;
    m.exec = {ExecModel::Kind::constant, 10us, {}, 1.0};
    m.line = line;
    return m;
  }
  ThreadSpec& control() { return spec.threads[0]; }
  ModuleSpec& maker() { return spec.modules[0]; }
  ModuleSpec& user() { return spec.modules[1]; }
  ActuatorSpec& motors() { return spec.actuators[0]; }
  std::vector<std::string> problems(const CheckOptions& options = {true, 0}) const {
    std::vector<std::string> texts;
    for (const Problem& p : Graph(spec, all_types()).check(options)) texts.push_back(to_string(p, "r.toml"));
    return texts;
  }
  GraphSpec spec;
};

TEST_F(GraphCheckTest, ARobotWithoutFaultsHasNoProblems) {
  EXPECT_THAT(problems(), IsEmpty());
  EXPECT_THAT(problems({}), IsEmpty());
}

// ---- names and threads

TEST_F(GraphCheckTest, NoThreadAtAll) {
  GraphSpec empty;
  spec = empty;
  EXPECT_THAT(problems(), ElementsAre("r.toml: thread: missing: at least one [[thread]]"));
}

TEST_F(GraphCheckTest, NamesAreOfAFewLettersAndUnique) {
  control().name = "Control loop";
  spec.modules.push_back(maker());
  spec.modules.back().line = 15;
  spec.chains.push_back(spec.chains[0]);
  spec.chains.back().line = 35;
  EXPECT_THAT(problems(),
              ElementsAre("r.toml:5: thread.Control loop: \"Control loop\": a name of a-z, 0-9 and _",
                          "r.toml:15: module.maker: \"maker\": a name that no other module has",
                          "r.toml:15: topic.maker.pair: two writers: one writer; give the modules different names",
                          "r.toml:35: chain.chain: \"chain\": a name that no other chain has"));
}

TEST_F(GraphCheckTest, TwoThreadsOrActuatorsOfOneName) {
  spec.threads.push_back(thread("control", {"third"}, 50));
  spec.modules.push_back(module("third", "test::Maker", 51));
  spec.actuators.push_back(motors());
  spec.actuators.back().line = 60;
  EXPECT_THAT(problems(),
              ::testing::IsSupersetOf({"r.toml:50: thread.control: \"control\": a name that no other thread has",
                                       "r.toml:60: actuator.motors: \"motors\": a name that no other actuator has"}));
}

TEST_F(GraphCheckTest, ATopicSectionThatIsThereTwice) {
  spec.topics.push_back({"maker.pair", 0, 0, 50});
  spec.topics.push_back({"maker.pair", 0, 0, 52});
  EXPECT_THAT(problems(), ElementsAre("r.toml:52: topic.maker.pair: \"maker.pair\": a name that no other topic has"));
}

TEST_F(GraphCheckTest, PrioritiesStayBelowTheGuardian) {
  control().priority = 99;
  spec.threads.push_back(thread("idle", {"third"}, 50));
  spec.threads.back().priority = -1;
  spec.modules.push_back(module("third", "test::Maker", 55));
  EXPECT_THAT(problems(),
              ElementsAre("r.toml:5: thread.control.priority: 99: an integer from 0 to 98; the guardian has 99",
                          "r.toml:50: thread.idle.priority: -1: an integer from 0 to 98; the guardian has 99"));
  spec.guardian.priority = 80;
  control().priority = 80;
  spec.threads[1].priority = 0;
  EXPECT_THAT(problems(),
              ElementsAre("r.toml:5: thread.control.priority: 80: an integer from 0 to 79; the guardian has 80"));
}

TEST_F(GraphCheckTest, WithoutActuatorsPrioritiesGoTo98) {
  spec.actuators.clear();
  control().priority = 99;
  EXPECT_THAT(problems(), ElementsAre("r.toml:5: thread.control.priority: 99: an integer from 0 to 98"));
}

TEST_F(GraphCheckTest, TheGuardianNeedsAPriorityOfItsOwn) {
  spec.guardian.priority = 0;
  control().priority = 0;
  EXPECT_THAT(problems(), ElementsAre("r.toml:40: guardian.priority: 0: an integer from 1 to 99"));
}

TEST_F(GraphCheckTest, PeriodPhaseAndTimeoutHaveRanges) {
  control().period = 9us;
  control().phase = -1us;
  control().timeout = 5us;
  EXPECT_THAT(problems(), ElementsAre("r.toml:5: thread.control.period_us: 9: a number from 10 to 3600000000",
                                      "r.toml:5: thread.control.phase_us: -1: a number from 0 to 3600000000",
                                      "r.toml:5: thread.control.timeout_us: 5: none; a thread with period_us is "
                                      "released by its period alone"));
  control().period = 3601s;
  control().phase = 0s;
  control().timeout = -2us;
  EXPECT_THAT(problems(), ElementsAre("r.toml:5: thread.control.period_us: 3.601e+09: a number from 10 to 3600000000",
                                      "r.toml:5: thread.control.timeout_us: -2: a number from 0 to 3600000000"));
}

TEST_F(GraphCheckTest, CatchUpIsBounded) {
  control().overrun = ThreadSpec::Overrun::catch_up;
  control().catch_up_max = 0;
  EXPECT_THAT(problems(), ElementsAre("r.toml:5: thread.control.catch_up_max: 0: an integer from 1 to 1000"));
}

TEST_F(GraphCheckTest, StacksHaveARange) {
  control().stack_kib = 8;
  EXPECT_THAT(problems(), ElementsAre("r.toml:5: thread.control.stack_kib: 8: an integer from 16 to 65536"));
}

TEST_F(GraphCheckTest, TriggerTopicsExistAndAreWrittenElsewhere) {
  control().trigger = ThreadSpec::Trigger::topics;
  EXPECT_THAT(problems(), ElementsAre("r.toml:5: thread.control.trigger: missing: a topic: guardian.motors "
                                      "guardian.state maker.pair user.result"));
  control().topics = {{"maker.pear", 7}, {"maker.pair", 8}};
  EXPECT_THAT(
      problems(),
      ElementsAre("r.toml:7: thread.control.trigger: \"maker.pear\": a topic: guardian.motors guardian.state "
                  "maker.pair user.result; did you mean maker.pair?",
                  "r.toml:8: thread.control.trigger: \"maker.pair\": a topic that this thread does not write itself"));
}

TEST_F(GraphCheckTest, TheTriggerDeviceBelongsToADriverOfTheThread) {
  control().trigger = ThreadSpec::Trigger::device;
  control().device_module = "maker";
  EXPECT_THAT(problems(), ElementsAre("r.toml:5: thread.control.device: \"maker\": a driver module in `order`; there "
                                      "is none"));
  spec.modules.push_back(module("imu", "test::DriverOfNothing", 15));
  control().order.push_back({"imu", 6});
  EXPECT_THAT(problems(), ElementsAre("r.toml:5: thread.control.device: \"maker\": a driver module in `order`: imu"));
}

TEST_F(GraphCheckTest, CpusExist) {
  control().cpus = {0, 2};
  spec.guardian.cpus = {-1};
  spec.virtual_cores = 2;
  EXPECT_THAT(problems({true, 0}),
              ElementsAre("r.toml:5: thread.control.cpus: 2: numbers from 0 to 1; robot.virtual_cores is 2",
                          "r.toml:40: guardian.cpus: -1: numbers from 0 to 1; robot.virtual_cores is 2"));
  EXPECT_THAT(problems({false, 2}), ElementsAre("r.toml:5: thread.control.cpus: 2: numbers from 0 to 1",
                                                "r.toml:40: guardian.cpus: -1: numbers from 0 to 1"));
  EXPECT_THAT(problems({false, 0}), ElementsAre("r.toml:40: guardian.cpus: -1: numbers from 0 to 1023"));
}

TEST_F(GraphCheckTest, VirtualCoresHaveARange) {
  spec.virtual_cores = 65;
  EXPECT_THAT(problems(), ElementsAre("r.toml: robot.virtual_cores: 65: an integer from 1 to 64"));
}

TEST_F(GraphCheckTest, OrderNamesModulesThatExist) {
  control().order.push_back({"usre", 9});
  spec.threads.push_back(thread("empty", {}, 50));
  EXPECT_THAT(problems(),
              ElementsAre("r.toml:9: thread.control.order: \"usre\": a module: guardian maker user; did you mean "
                          "user?",
                          "r.toml:50: thread.empty.order: []: at least one module"));
}

// ---- modules

TEST_F(GraphCheckTest, AModuleTypeThatNobodyKnows) {
  maker().type = "test::Makre";
  EXPECT_THAT(
      problems(),
      ::testing::Contains(
          "r.toml:11: module.maker.type: \"test::Makre\": a known module type: "
          "test::DriverOfNothing test::Hearer test::LoopUser test::Maker test::ThreeChannels test::TwoPorts test::User "
          "test::Viewer; did you mean test::Maker?"));
}

TEST_F(GraphCheckTest, AModuleIsInOneThread) {
  spec.modules.push_back(module("lost", "test::Maker", 15));
  spec.threads.push_back(thread("second", {"maker"}, 50));
  EXPECT_THAT(problems(),
              ElementsAre("r.toml:11: module.maker: in threads control second: named once, in the order of one thread",
                          "r.toml:15: module.lost: in no thread: named in the order of one thread"));
}

TEST_F(GraphCheckTest, AModuleIsOnceInItsThread) {
  control().order.push_back({"maker", 9});
  EXPECT_THAT(problems(), ElementsAre("r.toml:11: module.maker: in threads control control: named once, in the order "
                                      "of one thread"));
}

TEST_F(GraphCheckTest, BestEffortHasNoPlaceInARealTimeThread) {
  spec.modules.push_back(module("view", "test::Viewer", 15));
  spec.topics.push_back({"view.image", 1024, 0, 16});
  control().order.push_back({"view", 6});
  EXPECT_THAT(problems(), ElementsAre("r.toml:15: module.view: best effort, in thread control of priority 80: a "
                                      "thread of priority 0: test::Viewer calls libraries that allocate or block"));
  control().order.pop_back();
  spec.threads.push_back(thread("view", {"view"}, 50));
  spec.threads.back().priority = 0;
  EXPECT_THAT(problems(), IsEmpty());
}

TEST_F(GraphCheckTest, VirtualTimeNeedsExecutionTimes) {
  maker().exec = {};
  user().exec.constant = 0ns;
  spec.guardian.exec.constant = 3601s;
  EXPECT_THAT(problems(), ElementsAre("r.toml:11: module.maker.exec_us: missing: exec_us, exec_trace_us, "
                                      "exec_quantiles_us or exec_measured_factor; "
                                      "virtual time needs one",
                                      "r.toml:12: module.user.exec_us: 0: a number from 0.001 to 3600000000",
                                      "r.toml:40: guardian.exec_us: 3.601e+09: a number from 0.001 to 3600000000"));
  EXPECT_THAT(problems({}), IsEmpty()) << "real time needs none";
}

TEST_F(GraphCheckTest, TracesAndMeasuredFactorsHaveRanges) {
  maker().exec = {ExecModel::Kind::trace, {}, {}, 1.0};
  user().exec = {ExecModel::Kind::measured, {}, {}, 0.0};
  EXPECT_THAT(problems(), ElementsAre("r.toml:11: module.maker.exec_trace_us: []: an array of numbers from 0.001 to "
                                      "3600000000",
                                      "r.toml:12: module.user.exec_measured_factor: 0: a number from 0.01 to 1000"));
  maker().exec.trace = {1us, 0us};
  user().exec.factor = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(problems(), ElementsAre("r.toml:11: module.maker.exec_trace_us: a number out of range: an array of "
                                      "numbers from 0.001 to 3600000000",
                                      "r.toml:12: module.user.exec_measured_factor: nan: a number from 0.01 to 1000"));
}

TEST_F(GraphCheckTest, QuantilesOfExecutionTimesRiseToOne) {
  const auto problems_with = [&](std::vector<ExecModel::Quantile> quantiles) {
    maker().exec = {ExecModel::Kind::quantiles, {}, {}, 1.0, std::move(quantiles)};
    return problems();
  };
  EXPECT_THAT(problems_with({{0.5, 12us}, {0.99, 30us}, {1.0, 30us}}), IsEmpty());
  EXPECT_THAT(problems_with({}), ElementsAre("r.toml:11: module.maker.exec_quantiles_us: []: pairs [share, us], both "
                                             "rising, shares from 0 to 1, the last one 1"));
  using Quantiles = std::vector<ExecModel::Quantile>;
  for (const Quantiles& wrong : {Quantiles{{0.5, 12us}},
                                 {{0.5, 12us}, {0.5, 13us}, {1.0, 14us}},
                                 {{-0.1, 1us}, {1.0, 2us}},
                                 {{0.5, 12us}, {1.0, 11us}},
                                 {{0.5, 0us}, {1.0, 11us}}})
    EXPECT_THAT(problems_with(wrong),
                ElementsAre("r.toml:11: module.maker.exec_quantiles_us: not a distribution: pairs [share, us], both "
                            "rising, shares from 0 to 1, the last one 1"));
}

TEST_F(GraphCheckTest, ParametersExistAndAreInTheirRange) {
  maker().params["rate_hz"] = {ParamValue(0.5), 14};
  maker().params["count_min"] = {ParamValue(std::int64_t{1}), 15};
  maker().params["fast"] = {ParamValue(std::int64_t{1}), 16};
  maker().params["label"] = {ParamValue(2.0), 17};
  maker().params["rate"] = {ParamValue(2.0), 18};
  user().params["gain"] = {ParamValue(true), 19};
  EXPECT_THAT(problems(),
              ElementsAre("r.toml:14: module.maker.params.rate_hz: 0.5: a number from 1 to 100 Hz",
                          "r.toml:15: module.maker.params.count_min: 1: an integer from 2 up",
                          "r.toml:16: module.maker.params.fast: 1: true or false",
                          "r.toml:17: module.maker.params.label: 2: a string",
                          "r.toml:18: module.maker.params.rate: 2: a parameter of test::Maker: rate_hz label "
                          "count_min fast; did you mean "
                          "rate_hz?",
                          "r.toml:19: module.user.params.gain: true: test::User has no parameters"));
}

TEST_F(GraphCheckTest, ANumberThatIsNoneIsNoParameter) {
  maker().params["rate_hz"] = {ParamValue(std::numeric_limits<double>::quiet_NaN()), 14};
  maker().params["count_min"] = {ParamValue(2.5), 15};
  EXPECT_THAT(problems(), ElementsAre("r.toml:14: module.maker.params.rate_hz: nan: a number from 1 to 100 Hz",
                                      "r.toml:15: module.maker.params.count_min: 2.5: an integer from 2 up"));
}

// ---- bindings and topics

TEST_F(GraphCheckTest, InputsAreBoundToTopicsThatExist) {
  user().in.clear();
  EXPECT_THAT(problems(), ::testing::Contains("r.toml:12: module.user.in.pair: missing: a topic of Pair: maker.pair"));
  user().in["pair"] = {"maker.pear", 13};
  EXPECT_THAT(
      problems(),
      ::testing::Contains(
          "r.toml:13: module.user.in.pair: \"maker.pear\": a topic of Pair: maker.pair; did you mean maker.pair?"));
}

TEST_F(GraphCheckTest, InputsHaveTheTypeOfTheirTopic) {
  user().in["extra"] = {"user.result", 14};
  EXPECT_THAT(problems(), ElementsAre("r.toml:14: module.user.in.extra: \"user.result\" of ActuatorCommand: a topic "
                                      "of Pair: maker.pair"));
}

TEST_F(GraphCheckTest, AnInputThatTheModuleDoesNotHave) {
  user().in["pear"] = {"maker.pair", 14};
  maker().in["pair"] = {"maker.pair", 15};
  EXPECT_THAT(problems(),
              ElementsAre("r.toml:14: module.user.in.pear: \"maker.pair\": an input of test::User: pair extra",
                          "r.toml:15: module.maker.in.pair: \"maker.pair\": test::Maker has no inputs"));
}

TEST_F(GraphCheckTest, ATopicOfALaterModuleIsDeclaredPrevious) {
  std::swap(control().order[0], control().order[1]);
  EXPECT_THAT(problems(),
              ElementsAre("r.toml:13: module.user.in.pair: \"maker.pair\": a topic of another thread or of a module "
                          "before user in thread control; this input is not declared `previous`"));
  user().type = "test::LoopUser";
  EXPECT_THAT(problems(), IsEmpty());
}

TEST_F(GraphCheckTest, PreviousIsForLaterModulesOnly) {
  user().type = "test::LoopUser";
  EXPECT_THAT(problems(),
              ElementsAre("r.toml:13: module.user.in.pair: \"maker.pair\": a topic of user or of a module after it in "
                          "thread control; this input is declared `previous`"));
}

TEST_F(GraphCheckTest, TwoWritersOfOneTopic) {
  spec.modules.push_back(module("twice", "test::TwoPorts", 15));
  control().order.push_back({"twice", 6});
  EXPECT_THAT(problems(),
              ElementsAre("r.toml:15: module.twice: \"same\": port names of test::TwoPorts that differ; two writers of "
                          "one topic are not possible",
                          "r.toml:15: topic.twice.same: two writers: one writer; give the modules different names"));
}

TEST_F(GraphCheckTest, ImagesHaveACapacity) {
  spec.modules.push_back(module("view", "test::Viewer", 15));
  spec.threads.push_back(thread("view", {"view"}, 50));
  spec.threads.back().priority = 0;
  EXPECT_THAT(problems(), ElementsAre("r.toml:15: topic.view.image.image: missing: width, height and format: "
                                      "view.image carries Image"));
}

TEST_F(GraphCheckTest, TopicSectionsNameTopicsAndImagesOnly) {
  spec.topics.push_back({"maker.pear", 0, 0, 50});
  spec.topics.push_back({"maker.pair", 300, 0, 51});
  EXPECT_THAT(
      problems(),
      ElementsAre("r.toml:50: topic.maker.pear: \"maker.pear\": a topic: guardian.motors guardian.state maker.pair "
                  "user.result; did you mean maker.pair?",
                  "r.toml:51: topic.maker.pair.image: 300 bytes: none: maker.pair carries Pair"));
}

TEST_F(GraphCheckTest, ExternalTopicsHaveANameATypeAndAThread) {
  const auto external = [](std::string name, int line, std::string type, std::string thread) {
    return TopicSpec{std::move(name), 0, 0, line, ExternalSpec{std::move(type), std::move(thread)}};
  };
  spec.topics = {external("operator.link", 50, "OperatorLink", "control"),
                 external("mine.pair", 51, "Pair", "control")};
  EXPECT_THAT(problems(), IsEmpty()) << "a type of a module's port is known too";
  std::string types;
  for (const msg::TypeInfo* t : msg::all_types()) types += " " + std::string(t->name);
  spec.topics = {external("operator", 50, "OperatorLink", "control"),
                 external("other.link", 51, "Imag", "control"),
                 external("third.link", 52, "", "guardian"),
                 external("fourth.link", 53, "OperatorLink", ""),
                 external("fifth.a", 54, "OperatorLink", "control"),
                 external("fifth.b", 55, "OperatorLink", "sense"),
                 external("maker.link", 56, "OperatorLink", "control"),
                 external("eye.image", 57, "Image", "control")};
  EXPECT_THAT(
      problems(),
      ElementsAre("r.toml:11: module.maker: in threads control control: named once, in the order of one thread",
                  "r.toml:50: topic.operator: \"operator\": a name as source.port, each of a-z, 0-9 and _",
                  "r.toml:51: topic.other.link.type: \"Imag\": a message type:" + types + "; did you mean Image?",
                  "r.toml:52: topic.third.link.type: missing: a message type:" + types,
                  "r.toml:52: topic.third.link.thread: \"guardian\": a thread: control",
                  "r.toml:53: topic.fourth.link.thread: missing: a thread: control",
                  "r.toml:55: topic.fifth.b.thread: \"sense\": a thread: control",
                  "r.toml:55: topic.fifth.b.thread: \"sense\": \"control\", as of fifth.a: topics of one source come "
                  "in with one thread",
                  "r.toml:56: module.maker: \"maker\": a name that no other module has",
                  "r.toml:57: topic.eye.image.image: missing: width, height and format: eye.image carries Image"));
}

// ---- actuators and chains

TEST_F(GraphCheckTest, ActuatorsHaveACommandOfTheirType) {
  motors().command = {"user.resutl", 21};
  EXPECT_THAT(problems(), ElementsAre("r.toml:21: actuator.motors.command: \"user.resutl\": a topic of "
                                      "ActuatorCommand: user.result; did you mean user.result?"));
  motors().command = {"maker.pair", 21};
  EXPECT_THAT(problems(), ElementsAre("r.toml:21: actuator.motors.command: \"maker.pair\" of Pair: a topic of "
                                      "ActuatorCommand: user.result"));
}

TEST_F(GraphCheckTest, ActuatorsHaveAsManyChannelsAsTheModuleThatCommandsThem) {
  maker().type = "test::ThreeChannels";
  spec.modules.pop_back();
  spec.threads[0].order.pop_back();
  spec.chains.clear();
  motors().command = {"maker.command", 21};
  motors().channels_line = 22;
  EXPECT_THAT(problems(), ElementsAre("r.toml:22: actuator.motors.channels: 4: 3, as maker.command of "
                                      "test::ThreeChannels has"));
  motors().channels = 3;
  EXPECT_THAT(problems(), ElementsAre());
}

TEST(ProblemText, HasNoLineWhereTheFileSaysNothing) {
  EXPECT_EQ(to_string(Problem{7, "a.b", "1", "2"}, "r.toml"), "r.toml:7: a.b: 1: 2");
  EXPECT_EQ(to_string(Problem{0, "thread", "missing", "one"}, "r.toml"), "r.toml: thread: missing: one");
}

TEST_F(GraphCheckTest, ActuatorsHaveLimitsAndALease) {
  motors().channels = 9;
  motors().min = 2;
  motors().rate_per_s = -1;
  motors().lease = 50us;
  EXPECT_THAT(problems(),
              ElementsAre("r.toml:20: actuator.motors.channels: 9: an integer from 1 to 8",
                          "r.toml:20: actuator.motors.limit: [ 2, 1 ]: [smallest, largest], two numbers in this order",
                          "r.toml:20: actuator.motors.rate_per_s: -1: a number from 0 up; 0: no limit",
                          "r.toml:20: actuator.motors.lease_ms: 0.05: a number from 0.1 to 10000"));
}

TEST_F(GraphCheckTest, ThereAreAsManyLimitsAsChannels) {
  motors().channel_limits = {{-1, 1}, {0, 2}, {3, 2}};
  EXPECT_THAT(
      problems(),
      ElementsAre("r.toml:20: actuator.motors.limit: 3 ranges: [smallest, largest] for all channels, or " +
                      std::to_string(motors().channels) + " of them, one for each",
                  "r.toml:20: actuator.motors.limit: [ 3, 2 ]: [smallest, largest], two numbers in this order"));
}

TEST_F(GraphCheckTest, ChainsJoinTopicsThatLeadToEachOther) {
  spec.chains[0].from = {"maker.pear", 31};
  spec.chains[0].to = {"", 32};
  spec.chains[0].budget = -1ms;
  EXPECT_THAT(
      problems(),
      ElementsAre("r.toml:30: chain.chain.budget_ms: -1: a number from 0 up; 0: no budget",
                  "r.toml:31: chain.chain.from: \"maker.pear\": a topic: guardian.motors guardian.state maker.pair "
                  "user.result; did you mean maker.pair?",
                  "r.toml:32: chain.chain.to: \"\": a topic: guardian.motors guardian.state maker.pair user.result"));
  spec.chains[0] = {"chain", {"user.result", 31}, {"maker.pair", 32}, 5ms, 30};
  EXPECT_THAT(problems(), ElementsAre("r.toml:32: chain.chain.to: \"maker.pair\": a topic that user.result leads to"));
}

TEST_F(GraphCheckTest, ChainsAreEightAtMost) {
  for (int i = 1; i < 9; ++i) {
    spec.chains.push_back(spec.chains[0]);
    spec.chains.back().name = "chain" + std::to_string(i);
    spec.chains.back().line = 30 + i;
  }
  EXPECT_THAT(problems(), ElementsAre("r.toml:38: chain: 9: at most 8"));
}

TEST_F(GraphCheckTest, ActuatorGroupsAreThirtyOneAtMost) {
  for (int i = 1; i < 32; ++i) {
    spec.actuators.push_back(motors());
    spec.actuators.back().name = "motors" + std::to_string(i);
    spec.actuators.back().line = 100 + i;
  }
  EXPECT_THAT(problems(), ElementsAre("r.toml:131: actuator: 32: at most 31"));
}

// ---- ground truth

/// What a simulator knows: its topic has the module's name.
class Truth final : public Module {
 public:
  void declare(Declaration& d) override { d.out("", out_); }
  StepStatus step(const Step&) noexcept override { return StepStatus::ok; }

 private:
  Out<Pair> out_;
};

TEST_F(GraphCheckTest, NothingInARobotActsByTheSimulatorsTruth) {
  ModuleTypes types = all_types();
  types.add<Truth>("test::Truth");
  spec.modules.push_back(module("ground_truth", "test::Truth", 0));
  spec.threads.push_back(thread("truth", {"ground_truth"}, 50));
  const auto told = [&] {
    std::vector<std::string> texts;
    for (const Problem& p : Graph(spec, types).check({true, 0})) texts.push_back(to_string(p, "r.toml"));
    return texts;
  };
  EXPECT_THAT(told(), IsEmpty());
  EXPECT_NE(Graph(spec, types).find_topic("ground_truth"), kNone) << "a port without a name";
  user().in["extra"] = {"ground_truth", 25};
  spec.failsafes = {{.name = "off", .topic = {"ground_truth.state", 61}, .time = 50ms, .line = 60}};
  const std::string why =
      "another topic: ground_truth is the simulator's truth, for reports only; a robot has none to act by";
  EXPECT_THAT(told(), ElementsAre("r.toml:25: module.user.in.extra: \"ground_truth\": " + why,
                                  "r.toml:61: failsafe.off.topic: \"ground_truth.state\": " + why));
}

// ---- failsafes

TEST_F(GraphCheckTest, AFailsafeNeedsATopicOfSomebodyElse) {
  spec.failsafes = {{.name = "lost", .topic = {"maker.pear", 61}, .time = 50ms, .line = 60},
                    {.name = "own", .topic = {"guardian.motors", 0}, .time = 50ms, .line = 63},
                    {.name = "lost", .topic = {"maker.pair", 0}, .time = 50ms, .line = 65}};
  EXPECT_THAT(problems(),
              ElementsAre("r.toml:61: failsafe.lost.topic: \"maker.pear\": a topic: guardian.motors guardian.state "
                          "maker.pair user.result; did you mean maker.pair?",
                          "r.toml:63: failsafe.own.topic: \"guardian.motors\": a topic that the guardian does not "
                          "write itself",
                          "r.toml:65: failsafe.lost: \"lost\": a name that no other failsafe has"));
}

TEST_F(GraphCheckTest, AFailsafesFieldIsANumberOfItsMessageWithALimit) {
  using Kind = FailsafeSpec::Kind;
  const double inf = std::numeric_limits<double>::infinity();
  spec.failsafes = {
      {.name = "a", .topic = {"maker.pair", 0}, .kind = Kind::value, .field = {"value", 61}, .below = 1.0, .line = 60},
      {.name = "b", .topic = {"maker.pair", 0}, .kind = Kind::value, .field = {"number", 0}, .line = 62},
      {.name = "c",
       .topic = {"maker.pair", 0},
       .kind = Kind::value,
       .field = {"number", 0},
       .below = 2.0,
       .above = 1.0,
       .line = 64},
      {.name = "d", .topic = {"maker.pair", 0}, .kind = Kind::value, .field = {"number", 0}, .above = inf, .line = 66}};
  EXPECT_THAT(problems(),
              ElementsAre("r.toml:61: failsafe.a.field: \"value\": a number of Pair: stamp number reserved value[0]",
                          "r.toml:62: failsafe.b: no limit: below, above or both",
                          "r.toml:64: failsafe.c.below: 2: a number up to `above`, 1",
                          "r.toml:66: failsafe.d: inf: finite numbers for below and above"));
}

TEST_F(GraphCheckTest, FailsafeTimesHaveARange) {
  using Kind = FailsafeSpec::Kind;
  spec.failsafes = {{.name = "a", .topic = {"maker.pair", 0}, .kind = Kind::silent, .time = 0ms, .line = 60},
                    {.name = "b", .topic = {"maker.pair", 0}, .kind = Kind::stuck, .time = 3601s, .line = 61},
                    {.name = "c", .topic = {"maker.pair", 0}, .time = 1ms, .stop_after = Duration{-1ms}, .line = 62}};
  EXPECT_THAT(problems(), ElementsAre("r.toml:60: failsafe.a.silent_ms: 0: a number from 1 to 3600000",
                                      "r.toml:61: failsafe.b.stuck_ms: 3601000: a number from 1 to 3600000",
                                      "r.toml:62: failsafe.c.then_after_ms: -1: a number from 0 to 3600000"));
}

TEST_F(GraphCheckTest, FailsafesAreSixteenAtMostAndNeedAGuardian) {
  for (int i = 0; i < 17; ++i)
    spec.failsafes.push_back(
        {.name = "f" + std::to_string(i), .topic = {"maker.pair", 0}, .time = 1ms, .line = 60 + i});
  EXPECT_THAT(problems(), ElementsAre("r.toml:76: failsafe: 17: at most 16"));
  spec.failsafes.resize(1);
  spec.actuators.clear();
  spec.chains.clear();
  EXPECT_THAT(problems(), ElementsAre("r.toml:60: failsafe.f0: without an actuator: at least one [actuator.NAME]; "
                                      "without one there is no guardian to act"));
}

TEST_F(GraphCheckTest, AnActuatorGroupIsNotCalledState) {
  motors().name = "state";
  spec.chains.clear();
  EXPECT_THAT(problems(), ::testing::Contains("r.toml:20: actuator.state: \"state\": another name; guardian.state is "
                                              "the guardian's own topic"));
}

// ---- topics of mates

TEST_F(GraphCheckTest, ARemoteTopicHasTheTypeOfItsReadersWhoSayHowOldItMayBe) {
  control().order.insert(control().order.begin(), {"hearer", 6});
  spec.modules.push_back(module("hearer", "test::Hearer", 50));
  EXPECT_THAT(problems(), ElementsAre("r.toml:50: topic.mate/pair: no type: an input that has a type and reads it"));
  user().in["extra"] = {"mate/pair", 14};
  EXPECT_THAT(problems(),
              ElementsAre("r.toml:14: module.user.in.extra.max_age_ms: missing: a number from 1 to 3600000: a "
                          "mate may fall silent, and an older message is then not there"));
  user().max_age["extra"] = 100ms;
  EXPECT_THAT(problems(), IsEmpty());
  const Graph graph(spec, all_types());
  EXPECT_EQ(graph.topics()[graph.find_topic("mate/pair")].type, &msg::type_info<Pair>());
  EXPECT_EQ(dynamic_cast<const Hearer&>(*graph.modules()[graph.find_module("hearer")].module).out_.type(),
            &msg::type_info<Pair>());
}

TEST_F(GraphCheckTest, OnlyWhatIsHeldCanExpire) {
  user().max_age["pair"] = 0ms;
  EXPECT_THAT(problems(), ElementsAre("r.toml:13: module.user.in.pair.max_age_ms: 0: a number from 1 to 3600000"));
}

// ---- all at once

TEST_F(GraphCheckTest, EveryProblemComesInOneRunInTheOrderOfTheLines) {
  control().priority = 120;
  control().order.push_back({"nobody", 6});
  maker().params["rate_hz"] = {ParamValue(0.5), 12};
  user().in["pair"] = {"maker.pear", 13};
  motors().lease = 0ms;
  spec.chains[0].from = {"maker.pear", 31};
  EXPECT_THAT(
      problems(),
      ElementsAre(
          "r.toml:5: thread.control.priority: 120: an integer from 0 to 98; the guardian has 99",
          "r.toml:6: thread.control.order: \"nobody\": a module: guardian maker user",
          "r.toml:12: module.maker.params.rate_hz: 0.5: a number from 1 to 100 Hz",
          "r.toml:13: module.user.in.pair: \"maker.pear\": a topic of Pair: maker.pair; did you mean maker.pair?",
          "r.toml:20: actuator.motors.lease_ms: 0: a number from 0.1 to 10000",
          "r.toml:31: chain.chain.from: \"maker.pear\": a topic: guardian.motors guardian.state maker.pair "
          "user.result; did you mean maker.pair?"));
}

}  // namespace
}  // namespace sinew::rt::graph_check_test
