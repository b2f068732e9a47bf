// What a recording says of its robot.
#include "apps/bag/recorded_about.hpp"

#include <gtest/gtest.h>

#include "../../record/memory_file.hpp"
#include "record/run/run_messages.hpp"
#include "record/writer.hpp"
#include "rt/module.hpp"

namespace sinew::app::recorded_about_test {
namespace {

class Gain final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override {
    d.param("gain", gain_, {.unit = "1/s", .min = 0, .max = 10});
    d.param("count", count_);
    d.param("label", label_);
    d.param("newer", newer_);
  }
  rt::StepStatus step(const rt::Step&) noexcept override { return rt::StepStatus::ok; }

 private:
  double gain_ = 1, newer_ = 0;
  std::int64_t count_ = 0;
  std::string label_;
};

constexpr const char* kRobot = R"(robot = { name = "bench", board = "none" }

[[thread]]
name = "control"
period_us = 5000
priority = 10
order = ["gain"]

[module]
gain = { type = "test::Gain" }
)";

class Recorded : public testing::Test {
 protected:
  Recorded() {
    types.add<Gain>("test::Gain");
    auto opened = record::Writer::open(std::make_unique<record::MemoryOutput>(disk_), {});
    writer = std::move(*opened);
    const auto add = [this](const char* name, record::Texts texts) {
      EXPECT_TRUE(writer->add_metadata({name, std::move(texts)}));
    };
    add("sinew.run", {{"robot", "bench"}, {"board", "linux"}, {"virtual_time", "false"}});
    add("sinew.threads", {{"000", "control"}});
    add("sinew.modules", {{"000", "gain"}, {"001", "lost"}});
    add("sinew.graph", {{"000", "module in 000"}, {"000.000", "out gain.out"}, {"001", "module in 000"}});
    add("sinew.params", {{"gain.gain", "7"}, {"gain.count", "3"}, {"gain.label", "\"a b\""}, {"lost.kp", "1"}});
  }
  void request(std::int64_t at_ns, rt::Request::Kind kind, double value, bool refused = false) {
    if (!channel_) {
      const record::RecordSchema& schema = record::request_schema();
      channel_ =
          *writer->add_channel(record::kRequestsTopic, "cdr", *writer->add_schema(schema.name, "ros2msg", schema.text));
    }
    record::LoggedRequest logged;
    logged.request.kind = kind;
    logged.request.value = value;
    logged.effect.refused = refused;
    logged.now = rt::Time{at_ns};
    record::Buffer to;
    record::encode(to, logged);
    const auto at = static_cast<std::uint64_t>(at_ns);
    EXPECT_TRUE(writer->write(*channel_, {0, at, at}, to.bytes()));
  }
  RecordedAbout read() {
    EXPECT_TRUE(writer->finish());
    record::FileProblem why;
    reader_ = record::Reader::open(std::make_unique<record::MemoryInput>(disk_.bytes), why);
    return recorded_about(*reader_, "run.mcap", types);
  }
  static rt::ParamValue value(const RecordedAbout& about, std::string_view name, std::int64_t at_ns) {
    for (const auto& p : about.params_at(rt::Time{at_ns}))
      if (p.declared->name == name) return p.value;
    return false;
  }

  rt::ModuleTypes types;
  std::unique_ptr<record::Writer> writer;

 private:
  record::Disk disk_;
  std::optional<std::uint16_t> channel_;
  std::unique_ptr<record::Reader> reader_;
};

TEST_F(Recorded, ParametersHaveTheValueOfTheirTime) {
  ASSERT_TRUE(writer->attach({0, 0, "robot.toml", "text/plain", kRobot}));
  request(100, rt::Request::Kind::set_param, 8.5);
  request(200, rt::Request::Kind::set_param, 9, true);
  request(300, rt::Request::Kind::disable, 1);
  request(400, rt::Request::Kind::set_param, 2);
  const RecordedAbout about = read();
  EXPECT_EQ(value(about, "gain", 99), rt::ParamValue(7.0)) << "a number, though it was written as an integer";
  EXPECT_EQ(value(about, "gain", 100), rt::ParamValue(8.5));
  EXPECT_EQ(value(about, "gain", 399), rt::ParamValue(8.5)) << "what was refused changed nothing";
  EXPECT_EQ(value(about, "gain", 400), rt::ParamValue(2.0));
  EXPECT_EQ(value(about, "count", 400), rt::ParamValue(std::int64_t{3}));
  EXPECT_EQ(value(about, "label", 400), rt::ParamValue(std::string("a b")));
}

TEST_F(Recorded, ParametersThatTheRecordedProgramDidNotHaveAreLeftOut) {
  ASSERT_TRUE(writer->attach({0, 0, "robot.toml", "text/plain", kRobot}));
  const RecordedAbout about = read();
  EXPECT_EQ(about.params_at(rt::Time{}).size(), 3u) << "\"newer\" has no recorded value";
  EXPECT_EQ(about.thread_of, (std::vector<std::uint32_t>{0, 0}));
  EXPECT_EQ(about.board, "linux");
}

TEST_F(Recorded, AFileWithoutARobotFileHasNamesOnly) {
  const RecordedAbout about = read();
  EXPECT_EQ(about.graph, nullptr);
  EXPECT_TRUE(about.params_at(rt::Time{}).empty());
  EXPECT_EQ(about.threads, std::vector<std::string>{"control"});
  EXPECT_EQ(about.modules.size(), 2u);
}

TEST_F(Recorded, ARobotFileOfAnotherVersionCostsOnlyWhatItSays) {
  ASSERT_TRUE(
      writer->attach({0, 0, "robot.toml", "text/plain",
                      "robot = { name = \"bench\", colour = 7 }\n[module]\ngain = { type = \"gone::Gain\" }\n"}));
  const RecordedAbout about = read();
  EXPECT_TRUE(about.params_at(rt::Time{}).empty());
  EXPECT_EQ(about.robot, "bench");
}

}  // namespace
}  // namespace sinew::app::recorded_about_test
