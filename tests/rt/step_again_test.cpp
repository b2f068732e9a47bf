// Steps executed again from a record: the same bytes, from the beginning and from any saved state; differences are
// noticed.
#include <gtest/gtest.h>

#include <cmath>

#include "again_robot.hpp"
#include "graph_fixture.hpp"
#include "memory_record.hpp"
#include "rt/saved_state.hpp"
#include "rt/trap.hpp"

namespace sinew::rt::step_again_test {
namespace {

constexpr Duration kRun = 400ms;

/// One run with everything in it, and its record.
class StepAgainTest : public ::testing::Test {
 protected:
  void SetUp() override {
    FakeActuators& motors = board_.add("motors", clock_);
    graph_ = std::make_unique<Graph>(spec, types);
    for (const Problem& p : graph_->check({.virtual_time = true})) FAIL() << to_string(p, "test");
    ASSERT_TRUE(graph_->configure(board_, {.first_sequence = kNearWrap}));
    record = std::make_unique<MemoryRecord>(*graph_, 6ms);
    const auto set_gain = [this](double gain) { EXPECT_TRUE(graph_->set_param("mixed", "gain", gain)); };
    const auto enable = [this](const char* m, bool on) { EXPECT_TRUE(graph_->set_enabled(m, on)); };
    grants_.at(Time{}, [this] { EXPECT_TRUE(graph_->arm()); });  // refused: no command yet
    grants_.at(Time{15'000'000}, [this] { EXPECT_TRUE(graph_->arm()); });
    grants_.at(Time{18'000'000}, [this] { EXPECT_TRUE(graph_->disarm()); });  // while it is live
    grants_.at(Time{19'500'000}, [this] { EXPECT_TRUE(graph_->arm()); });
    grants_.at(Time{50'000'000}, [=] { set_gain(2.5); });
    grants_.at(Time{101'000'000}, [=] { enable("mixed", false); });
    grants_.at(Time{121'000'000}, [=] { set_gain(0.5); });  // while it stands still
    grants_.at(Time{141'000'000}, [=] {
      enable("mixed", true);  // its reset looks at the gain: the order counts
      set_gain(0.7);
    });
    grants_.at(Time{161'000'000}, [=] { enable("sampler", false); });  // a failsafe acts
    grants_.at(Time{231'000'000}, [=] { enable("sampler", true); });
    grants_.at(Time{240'000'000}, [this] { EXPECT_TRUE(graph_->disarm()); });
    grants_.at(Time{260'000'000}, [=] { enable("shaky", true); });  // its faults had stopped it
    for (const std::int64_t t : {290, 295, 300, 305})
      grants_.at(Time{t * 1'000'000}, [this] { EXPECT_TRUE(graph_->arm()); });
    grants_.at(Time{310'000'000}, [this] {
      Pair wish;
      wish.number = 77;
      for (int i = 0; i < 2; ++i) EXPECT_TRUE(graph_->publish("operator.wish", std::as_bytes(std::span(&wish, 1))));
    });
    grants_.at(Time{350'000'000}, [&motors] { motors.refuses = true; });
    grants_.at(Time{360'000'000}, [&motors] { motors.refuses = false; });
    grants_.end = Time{kRun.count()};
    DiscreteOptions options;
    options.observer = record.get();
    options.fault_limit = 5;
    executor_ = std::make_unique<DiscreteExecutor>(*graph_, clock_, grants_, options);
    ASSERT_TRUE(executor_->run());
  }
  std::uint32_t id(const char* module) const { return graph_->find_module(module); }
  const ModuleStats& stats(const char* module) { return executor_->runner().module_stats(id(module)); }
  std::vector<KeptEntry>& of(const char* module) { return record->of(id(module)); }
  const std::vector<Declaration::State>& members(const char* module) const {
    return graph_->modules()[id(module)].declaration.states;
  }
  std::optional<Departure> again(const char* module, std::size_t begin = 0, std::size_t end = SIZE_MAX) {
    RunAgain run(spec, types);
    EXPECT_TRUE(run.configured());
    return run.run(id(module), of(module), begin, end);
  }
  std::size_t first(const char* module, Request::Kind kind, int which = 0) {
    for (std::size_t i = 0; i < of(module).size(); ++i)
      if (of(module)[i].request && of(module)[i].request->kind == kind && which-- == 0) return i;
    ADD_FAILURE() << module << " has no such request";
    return 0;
  }

  GraphSpec spec = test_spec();
  ModuleTypes types = test_types();
  std::unique_ptr<MemoryRecord> record;

 private:
  hal::ManualClock clock_;
  FakeBoard board_;
  ScriptedGrants grants_;
  std::unique_ptr<Graph> graph_;
  std::unique_ptr<DiscreteExecutor> executor_;
};

constexpr const char* kModules[] = {"guardian", "sampler", "mixed", "shaky", "commander", "forgetful", "operator"};

TEST_F(StepAgainTest, TheRecordHasEverythingInIt) {
  EXPECT_EQ(record->steps(id("commander")), 400u);
  EXPECT_GT(stats("mixed").stale.value(), 0u);
  EXPECT_EQ(stats("shaky").stops.value(), 2u);
  EXPECT_EQ(of("mixed")[first("mixed", Request::Kind::enable)].effect.step, 0u) << "it was reset";
  EXPECT_EQ(of("shaky")[first("shaky", Request::Kind::enable)].effect.step, 0u);
  EXPECT_TRUE(of("guardian")[first("guardian", Request::Kind::arm, 0)].effect.refused);
  EXPECT_FALSE(of("guardian")[first("guardian", Request::Kind::arm, 1)].effect.refused);
  EXPECT_EQ(of("operator")[first("operator", Request::Kind::message, 1)].message.size(), sizeof(Pair));
  std::uint32_t dropped = 0, nan = 0, device = 0, refused = 0, acted = 0, origins = 0;
  for (const KeptEntry& e : of("mixed")) {
    if (e.request) continue;
    dropped += e.in[0].dropped;
    for (const SlotHeader* h : e.out[3]) nan += std::isnan(static_cast<const Pair*>(h->message())->value[0]);
    for (const SlotHeader* h : e.out[2]) origins += h->origin_ns[0] != kNoOrigin.ns;
  }
  for (const KeptEntry& e : of("sampler")) device += e.step.device_state != 0;
  for (const KeptEntry& e : of("guardian")) {
    if (e.request) continue;
    acted |= static_cast<const msg::SafetyState*>(e.out[2][0]->message())->acted;
    refused += e.step.device_state != 0;
  }
  EXPECT_GT(dropped, 0u);
  EXPECT_GT(nan, 0u);
  EXPECT_GT(device, 0u);
  EXPECT_GT(refused, 0u) << "the motors refused commands";
  EXPECT_NE(acted, 0u) << "a failsafe has acted";
  EXPECT_GT(origins, 0u);
}

TEST_F(StepAgainTest, EveryModuleDoesTheSameAgainFromTheBeginning) {
  for (const char* module : kModules) {
    const auto departure = again(module);
    EXPECT_FALSE(departure) << module << ", entry " << departure->entry << ": " << departure->what;
  }
}

TEST_F(StepAgainTest, EveryModuleThatDeclaresItsStateDoesTheSameFromEverySavedOne) {
  for (const char* module : kModules) {
    if (std::string_view(module) == "forgetful") continue;
    const auto saved = record->saved(id(module));
    EXPECT_GE(saved.size(), 5u) << module;
    for (const std::size_t at : saved) {
      const auto departure = again(module, at + 1);
      EXPECT_FALSE(departure) << module << " from " << at << ", entry " << departure->entry << ": " << departure->what;
    }
  }
}

TEST_F(StepAgainTest, AModuleThatForgetsToDeclareItsStateIsExactFromTheBeginningAlone) {
  const auto saved = record->saved(id("forgetful"));
  const auto departure = again("forgetful", saved[1] + 1);
  ASSERT_TRUE(departure);
  EXPECT_EQ(departure->entry, saved[1] + 1);
  EXPECT_EQ(departure->what, "out.number");
}

TEST_F(StepAgainTest, AMemberThatWasForgottenWouldBeFound) {
  std::vector<std::string> not_noticed;
  for (const char* module : kModules)
    for (std::size_t i = 0; i < members(module).size(); ++i)
      if (!forgetting_is_noticed(spec, types, *record, id(module), i))
        not_noticed.push_back(module + (" " + std::to_string(i)));
  // Of `stuck` and `value` the sequence, and any_ of `value`, spare a second look at the same message. good_published
  // decides about the very next command alone, which none of the saved states hits.
  const std::vector<std::string> harmless{"guardian 4", "guardian 6", "guardian 9", "guardian 10"};
  EXPECT_EQ(not_noticed, harmless);
}

TEST_F(StepAgainTest, ARecordedOutputWithOneBitFlippedIsNamed) {
  const msg::TypeInfo& type = msg::type_info<Pair>();
  math::Random random(1, 2, 3);
  std::uint32_t tried = 0;
  for (std::size_t i = 0; i < of("mixed").size(); i += 3) {
    const KeptEntry& e = of("mixed")[i];
    if (e.request || e.out[2].empty()) continue;
    auto* bytes = static_cast<std::uint8_t*>(const_cast<SlotHeader*>(e.out[2][0])->message());
    const std::uint32_t bit = random.next_u32() % (type.size * 8);
    Pair before;
    std::memcpy(&before, bytes, sizeof before);
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1u << bit % 8);
    const std::string field = msg::first_difference(type, &before, bytes)->path;
    const auto departure = again("mixed");
    ASSERT_TRUE(departure) << "entry " << i << ", bit " << bit;
    EXPECT_EQ(departure->entry, i);
    EXPECT_EQ(departure->what, "out." + field);
    std::memcpy(bytes, &before, sizeof before);
    ++tried;
  }
  EXPECT_GT(tried, 10u);
  EXPECT_FALSE(again("mixed"));
}

TEST_F(StepAgainTest, ARecordedInputWithOneBitFlippedIsNoticedInTheStepThatReadIt) {
  std::uint32_t tried = 0;
  for (std::size_t i = 0; i < of("mixed").size(); ++i) {
    const KeptEntry& e = of("mixed")[i];
    if (e.request || e.in[0].messages.empty() || e.step.status != StepStatus::ok) continue;
    auto* message = static_cast<Pair*>(const_cast<SlotHeader*>(e.in[0].messages.back())->message());
    message->number ^= 1u << i % 20;
    const auto departure = again("mixed");
    ASSERT_TRUE(departure);
    EXPECT_EQ(departure->entry, i);
    EXPECT_EQ(departure->what, "out.value[0]");
    message->number ^= 1u << i % 20;
    ++tried;
  }
  EXPECT_GT(tried, 10u);
}

TEST_F(StepAgainTest, EveryFactOfARecordedStepCounts) {
  std::size_t at = 0;  // a step of Mixed that held news and published
  while (of("mixed")[at].request || !of("mixed")[at].in[1].updated || of("mixed")[at].step.status != StepStatus::ok ||
         of("mixed")[at].step.number == 0)
    ++at;
  const KeptEntry right = of("mixed")[at];
  const auto noticed = [&](const char* field, auto change) {
    change(of("mixed")[at]);
    const auto departure = again("mixed");
    ASSERT_TRUE(departure) << field;
    EXPECT_EQ(departure->entry, at);
    EXPECT_EQ(departure->what, field);
    of("mixed")[at] = right;
  };
  noticed("out.stamp", [](KeptEntry& e) { e.step.now.ns += 1; });
  noticed("out.value[3]", [](KeptEntry& e) { e.step.dt += 1us; });
  noticed("out: instants", [](KeptEntry& e) { e.step.completed.ns += 1; });
  noticed("out.number", [](KeptEntry& e) { e.in[1].updated = false; });
  noticed("out.value[1]", [](KeptEntry& e) { e.in[0].dropped += 1; });
  noticed("status", [](KeptEntry& e) { e.step.status = StepStatus::stale; });
  noticed("out.value[2]", [](KeptEntry& e) { e.step.number += 105; });  // its random numbers
  spec.seed = 43;
  EXPECT_EQ(again("mixed")->what, "out.value[2]");
}

TEST_F(StepAgainTest, TheDeviceStateOfTheRecordIsTheOneThatTheStepSees) {
  for (KeptEntry& e : of("sampler")) {
    if (e.step.device_state == 0) continue;
    e.step.device_state += 1;
    EXPECT_EQ(again("sampler")->what, "out.number");
    return;
  }
}

TEST_F(StepAgainTest, ARequestThatIsLeftOutIsNoticed) {
  const std::pair<const char*, Request::Kind> requests[] = {
      {"mixed", Request::Kind::set_param}, {"guardian", Request::Kind::disarm}, {"operator", Request::Kind::message}};
  for (const auto& [module, kind] : requests) {
    const std::size_t at = first(module, kind);
    const KeptEntry kept = of(module)[at];
    of(module).erase(of(module).begin() + static_cast<std::ptrdiff_t>(at));
    EXPECT_TRUE(again(module)) << module;
    of(module).insert(of(module).begin() + static_cast<std::ptrdiff_t>(at), kept);
    EXPECT_FALSE(again(module)) << module;
  }
  KeptEntry& arm = of("guardian")[first("guardian", Request::Kind::arm)];
  arm.effect.refused = !arm.effect.refused;
  EXPECT_EQ(again("guardian")->what, "another effect of a request");
}

TEST_F(StepAgainTest, AnEnabledModuleIsResetAlsoWhenTheRequestIsNotInTheRecord) {
  of("shaky").erase(of("shaky").begin() + static_cast<std::ptrdiff_t>(first("shaky", Request::Kind::enable)));
  EXPECT_FALSE(again("shaky"));
}

TEST_F(StepAgainTest, WhatDoesNotFitTheModuleIsRefusedAndNothingIsRun) {
  RunAgain run(spec, types);
  StepAgain& mixed = run.module(id("mixed"));
  const KeptEntry& e = of("mixed")[0];
  std::vector<StepAgain::Input> in(e.in.size());
  EXPECT_EQ(mixed.step(e.step, std::span(in).first(2)).error().code, hal::Errc::bad_data);
  const std::vector<const SlotHeader*> five(5, of("sampler")[0].out[1][0]);
  in[0].messages = five;
  EXPECT_EQ(mixed.step(e.step, in).error().code, hal::Errc::bad_data) << "the queue is 4 deep";
  in[0].messages = {};
  in[2].messages = std::span(five).first(1);
  EXPECT_EQ(mixed.step(e.step, in).error().code, hal::Errc::bad_data) << "an output";

  Request request;
  request.index = 9;
  EXPECT_EQ(mixed.take(request, {}).error().code, hal::Errc::bad_data);
  request.index = 0;
  request.value = 11.0;
  EXPECT_EQ(mixed.take(request, {}).error().code, hal::Errc::bad_data) << "beyond its range";
  request.kind = Request::Kind::arm;
  EXPECT_EQ(mixed.take(request, {}).error().code, hal::Errc::bad_argument);
  request.kind = Request::Kind::message;
  EXPECT_EQ(run.module(id("operator")).take(request, {}).error().code, hal::Errc::bad_data) << "no bytes";
  EXPECT_FALSE(run.run(id("mixed"), of("mixed"), 0, SIZE_MAX)) << "nothing of it has left a trace";
}

TEST_F(StepAgainTest, AStateOfAnotherSizeChangesNothing) {
  RunAgain run(spec, types);
  StepAgain& mixed = run.module(id("mixed"));
  std::vector<std::byte> before(mixed.state_bytes()), after = before;
  mixed.save_state(before);
  const auto& saved = *of("mixed")[record->saved(id("mixed"))[2]].state;
  EXPECT_EQ(mixed.restore_state(std::span(saved).first(saved.size() - 1)).error().code, hal::Errc::bad_data);
  mixed.save_state(after);
  EXPECT_EQ(after, before);
  EXPECT_TRUE(mixed.restore_state(saved));
  mixed.save_state(after);
  EXPECT_NE(after, before);
}

TEST_F(StepAgainTest, TheLayoutOfAStateIsThatOfItsTypesAndSizes) {
  const auto layout = [](auto... members) {
    Declaration d;
    d.state(members...);
    return SavedState(d).layout();
  };
  const std::vector<int> two(2), three(3);
  EXPECT_EQ(layout(1.5, two), layout(2.5, two));
  EXPECT_NE(layout(1.5, two), layout(two, 1.5));
  EXPECT_NE(layout(two), layout(three));
  EXPECT_NE(layout(1.5), layout(std::int64_t{1})) << "of the same size";
}

TEST_F(StepAgainTest, RestoringLeavesParametersAsTheyAre) {
  RunAgain run(spec, types);
  const Declaration::Param& gain = run.graph().modules()[id("mixed")].declaration.params[0];
  ASSERT_TRUE(run.module(id("mixed")).restore_state(*of("mixed")[record->saved(id("mixed")).back()].state));
  EXPECT_EQ(*std::get<double*>(gain.target), 1.0) << "in the record it is 0.7 by then";
}

TEST(StatePadding, ATypeWithAByteWithoutAValueIsSeenByTheCompiler) {
  struct Behind {
    double sum;
    bool odd;
  };
  struct Between {
    std::uint8_t odd;
    std::uint16_t news;
  };
  struct Inside {
    std::array<Between, 3> ring;
  };
  class Closed {
   public:
    double all() const { return sum_ + odd_ + news_; }

   private:
    double sum_ = 0;
    std::uint32_t odd_ = 0, news_ = 0;
  };
  static_assert(!kHasNoPadding<Behind> && !kHasNoPadding<Between> && !kHasNoPadding<Inside>);
  static_assert(kHasNoPadding<Closed> && kHasNoPadding<double> && kHasNoPadding<std::array<bool, 3>>);
  static_assert(!std::has_unique_object_representations_v<Closed>, "so the standard's own answer is of no use");
}

TEST_F(StepAgainTest, SavingAStateAllocatesNothing) {
  RunAgain run(spec, types);
  for (const char* module : kModules) {
    std::vector<std::byte> room(run.module(id(module)).state_bytes());
    const trap::Scope scope("saving");
    run.module(id(module)).save_state(room);
  }
}

}  // namespace
}  // namespace sinew::rt::step_again_test
