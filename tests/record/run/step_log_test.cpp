#include "record/run/step_log.hpp"

#include "../../rt/graph_fixture.hpp"
#include "modules.hpp"

namespace sinew::record {
namespace {

using namespace std::chrono_literals;

struct Told final : StepLog::Visitor {
  void step(const LoggedStep& s) override { steps.push_back(s); }
  void request(const LoggedRequest& r) override { requests.push_back(r); }
  void lost(std::uint32_t thread, std::uint64_t entries) override { gaps.emplace_back(thread, entries); }
  std::vector<LoggedStep> steps;
  std::vector<LoggedRequest> requests;
  std::vector<std::pair<std::uint32_t, std::uint64_t>> gaps;
};

class StepLogTest : public ::testing::Test {
 protected:
  StepLogTest() {
    robot.add<Numbers>("numbers");
    robot.periodic("t", 1, 1ms, {"numbers"});
    robot.build();
  }
  rt::StepRecord record(std::uint32_t number) const {
    rt::StepRecord r;
    r.number = number;
    r.ports = &ports;
    return r;
  }
  struct NoPorts final : rt::StepPorts {
    const rt::InputBase* input(std::uint32_t) const noexcept override { return nullptr; }
    std::span<const rt::SlotHeader* const> published(std::uint32_t) const noexcept override { return {}; }
    std::size_t state_bytes() const noexcept override { return 0; }
    void save_state(std::span<std::byte>) const noexcept override {}
    virtual ~NoPorts() = default;
  } ports;
  rt::Robot robot;
};

TEST_F(StepLogTest, GoesRoundItsRingForEver) {
  StepLog log(robot.graph(), 20ms);
  Told told;
  for (std::uint32_t n = 0; n < 10'000; ++n) {
    log.completed(record(n));
    if (n % 3 == 0) log.read(0, told);
  }
  log.read(0, told);
  ASSERT_EQ(told.steps.size(), 10'000u);
  for (std::uint32_t n = 0; n < 10'000; ++n) {
    ASSERT_EQ(told.steps[n].number, n);
    ASSERT_EQ(told.steps[n].order, n);
  }
  EXPECT_TRUE(told.gaps.empty());
}

TEST_F(StepLogTest, WhatFindsNoRoomIsCountedWhereItIsMissing) {
  StepLog log(robot.graph(), 20ms);
  Told told;
  const auto fill = [&] {
    for (std::uint32_t n = 0; n < 100; ++n) log.completed(record(n));
  };
  fill();
  log.read(0, told);
  const std::size_t fit = told.steps.size();
  ASSERT_LT(fit, 100u);
  EXPECT_TRUE(told.gaps.empty()) << "what is missing is at the end, where more may come";
  log.completed(record(1000));
  log.read(0, told);
  ASSERT_EQ(told.gaps.size(), 1u);
  EXPECT_EQ(told.gaps[0].second, 100 - fit);
  ASSERT_EQ(told.steps.size(), fit + 1);
  EXPECT_EQ(told.steps.back().number, 1000u);
  EXPECT_EQ(told.steps.back().order, 100u);
  fill();
  log.read(0, told, true);
  ASSERT_EQ(told.gaps.size(), 2u) << "nothing follows: now it is told";
}

TEST_F(StepLogTest, RequestsStandAmongTheSteps) {
  StepLog log(robot.graph(), 20ms);
  Told told;
  rt::Request request;
  request.kind = rt::Request::Kind::set_period;
  request.value = std::int64_t{5};
  log.completed(record(0));
  log.taken(request, {3, false}, rt::Time{77});
  log.completed(record(1));
  log.read(0, told);
  ASSERT_EQ(told.steps.size(), 2u);
  ASSERT_EQ(told.requests.size(), 1u);
  EXPECT_EQ(told.steps[0].order, 0u);
  EXPECT_EQ(told.requests[0].order, 1u);
  EXPECT_EQ(told.steps[1].order, 2u);
  EXPECT_EQ(told.requests[0].request.value, request.value);
  EXPECT_EQ(told.requests[0].effect, (rt::Effect{3, false}));
  EXPECT_EQ(told.requests[0].now, rt::Time{77});
}

}  // namespace
}  // namespace sinew::record
