// The plant's listener: one runtime at a time, and side lines beside it.
#include "listener_rig.hpp"

namespace sinew::sim_hil::plant_listener_test {
namespace {

using hal::Errc;

TEST(PlantListener, StopLineIsObeyedBesideARuntimeThatHangs) {
  DoorRig rig;
  auto hanging = rig.connect();
  say_hello(*hanging);
  auto caller = rig.plant_listener->wait_runtime(kLong);
  ASSERT_TRUE(caller);
  auto link = PlantLink::accept(std::move(*caller), small_plant(), nullptr, rig.why);
  ASSERT_TRUE(link) << rig.why;
  auto line = rig.side_line();
  EXPECT_EQ(line->plant(), "small");
  EXPECT_FALSE(rig.plant_listener->stopped());
  EXPECT_TRUE(line->stop());
  EXPECT_TRUE(rig.plant_listener->stopped()) << "the answer comes after the deed";
  EXPECT_TRUE(line->stop()) << "once more does no harm";
}

TEST(PlantListener, StopLineMayBeOpenBeforeAnyRuntimeComes) {
  DoorRig rig;
  auto line = rig.side_line();
  EXPECT_TRUE(line->stop());
  EXPECT_TRUE(rig.plant_listener->stopped());
}

TEST(PlantListener, SecondRuntimeIsTurnedAwayUntilTheFirstIsLetGo) {
  DoorRig rig;
  auto first = rig.connect();
  say_hello(*first);
  ASSERT_TRUE(rig.plant_listener->wait_runtime(kLong));
  auto second = rig.connect();
  say_hello(*second);
  EXPECT_EQ(next_word(*second), "this plant serves a runtime already");
  EXPECT_EQ(rig.plant_listener->wait_runtime(1ms).error().code, Errc::timeout);
  rig.plant_listener->let_go();
  Hello hello;
  hello.robot = "third";
  auto third = rig.connect();
  say_hello(*third, hello);
  auto caller = rig.plant_listener->wait_runtime(kLong);
  ASSERT_TRUE(caller);
  EXPECT_EQ(caller->hello.robot, "third");
}

Hello from(const char* robot) {
  Hello hello;
  hello.robot = robot;
  return hello;
}

TEST(PlantListener, LetsEachOfSeveralRobotsInByItsNameInAnyOrder) {
  DoorRig rig(small_plant(), {"ant", "bee"});
  auto second = rig.connect();
  say_hello(*second, from("bee"));
  EXPECT_EQ(rig.plant_listener->wait_runtime(kLong, 1)->hello.robot, "bee");
  EXPECT_EQ(rig.plant_listener->wait_runtime(1ms, 0).error().code, Errc::timeout);
  auto first = rig.connect();
  say_hello(*first, from("ant"));
  EXPECT_EQ(rig.plant_listener->wait_runtime(kLong, 0)->hello.robot, "ant");
}

TEST(PlantListener, RefusesARobotThatItDoesNotHaveOrHasAlready) {
  DoorRig rig(small_plant(), {"ant", "bee"});
  auto stranger = rig.connect();
  say_hello(*stranger, from("cow"));
  EXPECT_EQ(next_word(*stranger), "this plant has no robot 'cow'; it has: ant, bee");
  auto first = rig.connect();
  say_hello(*first, from("ant"));
  ASSERT_TRUE(rig.plant_listener->wait_runtime(kLong, 0));
  auto again = rig.connect();
  say_hello(*again, from("ant"));
  EXPECT_EQ(next_word(*again), "this plant serves robot 'ant' already");
  rig.plant_listener->let_go(0);
  auto back = rig.connect();
  say_hello(*back, from("ant"));
  EXPECT_TRUE(rig.plant_listener->wait_runtime(kLong, 0));
}

TEST(PlantListener, AStopLineInARobotsNameStopsThatRobotAndAnyOtherAllOfThem) {
  DoorRig rig(small_plant(), {"ant", "bee"});
  EXPECT_TRUE(rig.side_line("bee")->stop());
  EXPECT_FALSE(rig.plant_listener->stopped(0));
  EXPECT_TRUE(rig.plant_listener->stopped(1));
  EXPECT_TRUE(rig.side_line("referee")->stop());
  EXPECT_TRUE(rig.plant_listener->stopped(0));
}

TEST(PlantListener, StrangersHinderNobody) {
  DoorRig rig;
  auto silent = rig.connect();
  auto garbage = rig.connect();
  ASSERT_TRUE(garbage->write(std::as_bytes(std::span("GET / HTTP/1.1\r\nHost: plant\r\n\r\n"))));
  EXPECT_NE(next_word(*garbage).find("no Hello from the runtime"), std::string::npos);
  auto line = rig.side_line();
  EXPECT_TRUE(line->compare_clocks(hal::system_os()));
  auto runtime = rig.connect();
  say_hello(*runtime);
  EXPECT_TRUE(rig.plant_listener->wait_runtime(kLong));
  EXPECT_EQ(rig.plant_listener->side_lines(), 1u);
  EXPECT_GE(rig.plant_listener->turned_away(), 1u);
}

TEST(PlantListener, MoreConnectionsThanItServesAreTurnedAwayWithWords) {
  DoorRig rig;
  std::vector<std::unique_ptr<SideLine>> lines;
  for (std::size_t i = 0; i < PlantListener::kMaxLines; ++i) lines.push_back(rig.side_line());
  EXPECT_EQ(next_word(*rig.connect()), "too many connections to this plant");
  lines.pop_back();  // and when one has left, another is served
  const Time give_up = hal::system_os().now() + kLong;
  while (!SideLine::open(rig.connect(), "late", kLong, rig.why) && hal::system_os().now() < give_up) {
  }
  EXPECT_LT(hal::system_os().now(), give_up);
}

TEST(PlantListener, SideLineThatBreaksTheProtocolHearsWhy) {
  DoorRig rig;
  auto stream = rig.connect();
  MessageWriter out(kMaxSmallBytes);
  Hello hello;
  hello.mode = Mode::side_line;
  ASSERT_TRUE(out.add(Type::hello, 0, Time{}, hello) && out.add(Type::start, 0, Time{}));
  ASSERT_TRUE(stream->write(out.pending()));
  MessageReceiver in(Sender::plant);
  Message message;
  std::string words;
  while (words.empty()) {
    auto next = in.next(message);
    ASSERT_TRUE(next);
    if (*next && message.header.type == Type::bye) words = decode_text(message.payload);
    if (*next) continue;
    auto n = stream->read(in.space());
    ASSERT_TRUE(n);
    in.filled(*n);
  }
  EXPECT_EQ(words, "side line ended: bad data: message does not belong on a side line (3)");
}

TEST(SideLine, FourTimeStampsStandInTheirOrder) {
  DoorRig rig;
  auto line = rig.side_line();
  for (int i = 0; i < 20; ++i) {
    auto e = line->compare_clocks(hal::system_os());  // on one machine both clocks are one
    ASSERT_TRUE(e);
    EXPECT_LE(e->asked, e->received);
    EXPECT_LE(e->received, e->answered);
    EXPECT_LE(e->answered, e->arrived);
  }
}

TEST(SideLine, PlantThatHasEndedIsClosed) {
  DoorRig rig;
  auto line = rig.side_line();
  rig.plant_listener.reset();
  EXPECT_EQ(line->stop().error().code, Errc::closed);
}

TEST(SideLine, PlantThatDoesNotAnswerIsATimeoutAndTheStopHasBeenSent) {
  auto ends = hal::stream_pair();
  ASSERT_TRUE(ends);
  hal::Stream& plant = *ends->second;
  Welcome welcome;
  welcome.step = 1ms, welcome.plant = "deaf";
  MessageWriter out(kMaxSmallBytes);
  ASSERT_TRUE(out.add(Type::welcome, 0, Time{}, welcome));
  ASSERT_TRUE(plant.write(out.pending()));
  std::string why;
  auto line = SideLine::open(std::move(ends->first), "parent", 20ms, why);
  ASSERT_TRUE(line) << why;
  EXPECT_EQ((*line)->stop().error().code, Errc::timeout);
  MessageReceiver in(Sender::runtime);
  auto n = plant.read(in.space());
  ASSERT_TRUE(n);
  in.filled(*n);
  Message message;
  ASSERT_TRUE(*in.next(message));
  ASSERT_TRUE(*in.next(message));
  EXPECT_EQ(message.header.type, Type::stop);
  EXPECT_EQ(message.header.device, kAllGroups);
}

TEST(SideLine, PlantWithoutADoorSaysThatItTakesNone) {
  auto ends = hal::stream_pair();
  ASSERT_TRUE(ends);
  std::string why, plant_why;
  auto plant = hal::system_os().start_thread({"plant", 0, {}, 1 << 18}, [&] {
    EXPECT_FALSE(PlantLink::accept(std::move(ends->second), small_plant(), nullptr, plant_why));
  });
  EXPECT_FALSE(SideLine::open(std::move(ends->first), "parent", kLong, why));
  EXPECT_EQ(why, "plant refused: this plant waits for a runtime and takes no side line");
}

}  // namespace
}  // namespace sinew::sim_hil::plant_listener_test
