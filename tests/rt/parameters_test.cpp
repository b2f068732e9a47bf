// Parameters before the start and between steps, and the mailbox that brings them there.
#include "rt/parameters.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "graph_fixture.hpp"

namespace sinew::rt {
namespace {

using hal::Errc;

struct AllKinds final : Module {
  void declare(Declaration& d) override {
    d.param("on", on);
    d.param("count", count, {.min = -3, .max = 3});
    d.param("gain", gain, {.unit = "rad/s", .min = 0.5, .max = 2.0});
    d.param("positive", positive, {.min = 0.0});
    d.param("any", any, {.unit = "m"});
    d.param("label", label);
  }
  Status step(const Step& step) noexcept override {
    if (step.number < 8) gains[step.number] = gain;
    return Status::ok;
  }
  bool on = true;
  std::int64_t count = 1;
  double gain = 1.0, positive = 1.0, any = 0.0;
  std::string label = "x";
  std::array<double, 8> gains{};
};

class Parameters : public ::testing::Test {
 protected:
  Parameters() {
    module.declare(declaration);
    g.types.add("test::all", [this] {
      auto m = std::make_unique<AllKinds>();
      all = m.get();
      return m;
    });
    ModuleSpec m;
    m.name = "all";
    m.type = "test::all";
    m.exec = {ExecModel::Kind::constant, 10us, {}, 1.0};
    g.spec.modules.push_back(m);
    g.periodic("t", 1, 1ms, {"all"});
  }
  const Declaration::Param& param(std::string_view name) { return *find_param(declaration, name); }
  AllKinds module;
  Declaration declaration;
  GraphRig g;
  AllKinds* all = nullptr;  // the one in the graph
};

TEST_F(Parameters, SayWhatTheyAllow) {
  EXPECT_EQ(allowed_values(param("on")), "true or false");
  EXPECT_EQ(allowed_values(param("count")), "an integer from -3 to 3");
  EXPECT_EQ(allowed_values(param("gain")), "a number from 0.5 to 2 rad/s");
  EXPECT_EQ(allowed_values(param("positive")), "a number from 0 up");
  EXPECT_EQ(allowed_values(param("any")), "a number in m");
  EXPECT_EQ(allowed_values(param("label")), "a string");
}

TEST_F(Parameters, AcceptTheirTypeAndRangeOnly) {
  EXPECT_TRUE(accepts(param("gain"), 0.5));
  EXPECT_TRUE(accepts(param("gain"), std::int64_t{2})) << "an integer is a number too";
  EXPECT_FALSE(accepts(param("gain"), 2.0001));
  EXPECT_FALSE(accepts(param("gain"), std::numeric_limits<double>::quiet_NaN()));
  EXPECT_FALSE(accepts(param("any"), std::numeric_limits<double>::infinity()));
  EXPECT_FALSE(accepts(param("gain"), true));
  EXPECT_FALSE(accepts(param("count"), 1.0)) << "a number is no integer";
  EXPECT_FALSE(accepts(param("count"), std::int64_t{4}));
  EXPECT_FALSE(accepts(param("on"), std::int64_t{1}));
  EXPECT_FALSE(accepts(param("label"), true));
}

TEST_F(Parameters, OfTheRobotFileAreSetBeforeConfigure) {
  g.spec.modules[0].params = {{"gain", {std::int64_t{2}, 0}}, {"label", {std::string("left"), 0}}, {"on", {false, 0}}};
  ASSERT_EQ(g.build(), "");
  EXPECT_EQ(all->gain, 2.0);
  EXPECT_EQ(all->label, "left");
  EXPECT_FALSE(all->on);
  EXPECT_EQ(all->count, 1) << "default";
}

/// Grants one millisecond at a time and lets the test do something before each.
struct SteppedGrant final : hal::GrantSource {
  std::function<void(int)> before;
  int count = 0;
  hal::Result<Time> next_grant(Time done) override {
    before(count++);
    return done + 1ms;
  }
};

TEST_F(Parameters, ChangeBetweenTwoStepsAndTellFromWhichOne) {
  ASSERT_EQ(g.build(), "");
  hal::Result<Ticket> ticket = hal::Error{};
  SteppedGrant grants;
  grants.before = [&](int n) {
    if (n == 3) ticket = g.graph->set_param("all", "gain", 1.75);
  };
  DiscreteExecutor executor(*g.graph, g.clock, grants, {.duration = 7500us});
  ASSERT_TRUE(executor.run());
  ASSERT_TRUE(ticket);
  // Three grants: 1, 2, 3 ms, steps 0..3 have run.
  EXPECT_EQ(all->gains, (std::array<double, 8>{1, 1, 1, 1, 1.75, 1.75, 1.75, 1.75}));
  EXPECT_EQ(g.graph->taken_at(*ticket), 4u);
}

TEST_F(Parameters, AreRefusedWithTheReason) {
  ASSERT_EQ(g.build(), "");
  std::string why;
  EXPECT_EQ(g.graph->set_param("all", "gain", 5.0, &why).error().code, Errc::bad_argument);
  EXPECT_EQ(why, "5: a number from 0.5 to 2 rad/s");
  EXPECT_EQ(g.graph->set_param("all", "gian", 1.0, &why).error().code, Errc::not_found);
  EXPECT_EQ(why, "all has no parameter gian");
  EXPECT_EQ(g.graph->set_param("none", "gain", 1.0, &why).error().code, Errc::not_found);
  EXPECT_EQ(why, "no module none");
  EXPECT_EQ(g.graph->set_param("all", "label", std::string("y"), &why).error().code, Errc::not_supported);
  EXPECT_EQ(why, "a text is set before the start only");
}

TEST_F(Parameters, OfAFullMailboxAreRefused) {
  ASSERT_EQ(g.build(), "");
  for (int i = 0; i < 64; ++i) ASSERT_TRUE(g.graph->set_param("all", "gain", 1.0));
  EXPECT_EQ(g.graph->set_param("all", "gain", 1.0).error().code, Errc::busy);
  g.run(500us);
  EXPECT_TRUE(g.graph->set_param("all", "gain", 1.0));
}

TEST(Enabling, ResetsTheModuleAndDisablingStopsIt) {
  GraphRig g;
  std::vector<std::uint32_t> numbers;
  numbers.reserve(100);
  g.module("m", {}, {}, [&](Probe&, const Step& step) {
    numbers.push_back(step.number);
    return Status::ok;
  });
  g.periodic("t", 1, 1ms, {"m"});
  ASSERT_EQ(g.build(), "");
  const int resets = g.probes["m"]->resets;
  SteppedGrant grants;
  grants.before = [&](int n) {
    if (n == 2) {
      EXPECT_TRUE(g.graph->set_enabled("m", false));
    }
    if (n == 5) {
      EXPECT_TRUE(g.graph->set_enabled("m", true));
    }
  };
  DiscreteExecutor executor(*g.graph, g.clock, grants, {.duration = 7500us});
  ASSERT_TRUE(executor.run());
  EXPECT_EQ(numbers, (std::vector<std::uint32_t>{0, 1, 2, 0, 1}));
  EXPECT_EQ(g.probes["m"]->resets, resets + 1);
  EXPECT_FALSE(g.graph->set_enabled("none", true));
}

TEST(Enabling, AModuleThatTheFileDisablesDoesNotStep) {
  GraphRig g;
  g.module("m", {}).enabled = false;
  g.module("other", {});
  g.periodic("t", 1, 1ms, {"m", "other"});
  ASSERT_EQ(g.build(), "");
  g.run(4500us);
  EXPECT_EQ(g.runner().module_stats(0).steps.value(), 0u);
  EXPECT_EQ(g.runner().module_stats(1).steps.value(), 5u);
}

TEST(Mailbox, EveryPostOfEveryThreadIsTakenOnceAndInOrder) {
  Mailbox box(16);
  constexpr std::int64_t kEach = 20'000;
  const auto poster = [&box](std::uint32_t id) {
    for (std::int64_t i = 0; i < kEach;) {
      Request r;
      r.module = id;
      r.value = i;
      if (box.post(r))
        ++i;
      else
        std::this_thread::yield();
    }
  };
  std::thread a(poster, 0), b(poster, 1);
  std::array<std::int64_t, 2> next{};
  while (next[0] + next[1] < 2 * kEach) {
    const Request* r = box.take();
    if (!r) {
      std::this_thread::yield();
      continue;
    }
    EXPECT_EQ(std::get<std::int64_t>(r->value), next[r->module]);
    ++next[r->module];
    box.done(7);
  }
  a.join();
  b.join();
  EXPECT_EQ(box.take(), nullptr);
}

TEST(Mailbox, ATicketTellsTheStepUntilItsCellIsUsedAgain) {
  Mailbox box(2);
  const auto first = box.post({});
  ASSERT_TRUE(first);
  EXPECT_FALSE(box.taken_at(*first)) << "waits";
  ASSERT_TRUE(box.take());
  box.done(5);
  EXPECT_EQ(box.taken_at(*first), 5u);
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(box.post({}));
    ASSERT_TRUE(box.take());
    box.done(6);
  }
  EXPECT_FALSE(box.taken_at(*first)) << "forgotten";
}

}  // namespace
}  // namespace sinew::rt
