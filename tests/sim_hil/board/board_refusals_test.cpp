// A plant that breaks the protocol is refused, in words.
#include "../memory_stream.hpp"
#include "rig.hpp"

namespace sinew::sim_hil::board_refusals_test {
namespace {

using hal::Errc;

/// A board that hears what is scripted after a proper Welcome.
class Scripted {
 public:
  Scripted() {
    Welcome w;
    w.step = 1ms, w.plant = "script", w.devices = small_plant().devices;
    EXPECT_TRUE(writer.add(Type::welcome, 0, Time{}, w));
  }
  hal::Result<Time> run() {
    auto stream = std::make_unique<MemoryStream>(std::vector(writer.pending().begin(), writer.pending().end()), 100);
    wire = stream.get();
    SimBoardOptions options;
    options.clock = &clock;
    auto opened = SimBoard::open(std::move(stream), options, why);
    if (!opened) return opened.error();
    board = std::move(*opened);
    return board->next_grant({});
  }
  hal::ManualClock clock;
  MessageWriter writer{1 << 16};
  std::unique_ptr<SimBoard> board;
  MemoryStream* wire = nullptr;
  std::string why;
};

std::string offence(void (*commit)(MessageWriter&)) {
  Scripted s;
  commit(s.writer);
  const auto end = s.run();
  if (end) return "accepted";
  EXPECT_EQ(end.error().code, Errc::bad_data);
  s.board->bye("any");
  const std::string said(reinterpret_cast<const char*>(s.wire->written.data()), s.wire->written.size());
  EXPECT_NE(said.find(end.error().where), std::string::npos) << "the plant is told why";
  return end.error().where;
}

TEST(SimBoardRefuses, SamplesOfUnknownDevices) {
  EXPECT_EQ(offence([](MessageWriter& w) { ASSERT_TRUE(w.add(Type::imu, 1, Time{}, Sample<msg::ImuSample>{})); }),
            "sample of a device that the Welcome does not list");
  EXPECT_EQ(offence([](MessageWriter& w) { ASSERT_TRUE(w.add(Type::baro, 77, Time{}, Sample<msg::BaroSample>{})); }),
            "sample of a device that the Welcome does not list");
}

TEST(SimBoardRefuses, SamplesThatGoBackInTime) {
  EXPECT_EQ(offence([](MessageWriter& w) {
              Sample<msg::ImuSample> s;
              s.ready = Time{50};
              ASSERT_TRUE(w.add(Type::imu, kImu, Time{2}, s));
              ASSERT_TRUE(w.add(Type::imu, kImu, Time{1}, s));
            }),
            "samples of a device go back in time");
}

TEST(SimBoardRefuses, FramesThatTheWelcomeDidNotAnnounce) {
  EXPECT_EQ(offence([](MessageWriter& w) {
              FrameInfo f;
              f.width = 8, f.height = 8, f.format = msg::PixelFormat::yuyv;
              ASSERT_TRUE(w.add(Type::frame, kCamera, Time{}, f, 128));
            }),
            "frame is not what the Welcome announced");
  EXPECT_EQ(offence([](MessageWriter& w) {
              FrameInfo f;
              f.width = 16, f.height = 8, f.format = msg::PixelFormat::yuyv, f.slot = 0, f.generation = 1;
              ASSERT_TRUE(w.add(Type::frame, kCamera, Time{}, f));
            }),
            "frame is in a slot that does not exist");
}

TEST(SimBoardRefuses, MessagesOutOfPlace) {
  EXPECT_EQ(offence([](MessageWriter& w) { ASSERT_TRUE(w.add(Type::clock, 0, Time{}, ClockInfo{})); }),
            "message does not belong here");
  EXPECT_EQ(offence([](MessageWriter& w) { ASSERT_TRUE(w.add(Type::start, 0, Time{})); }),
            "message goes in the wrong direction");
}

TEST(SimBoardRefuses, GrantsThatGoBackInTime) {
  Scripted s;
  ASSERT_TRUE(s.writer.add(Type::grant, 0, Time{5}));
  ASSERT_TRUE(s.writer.add(Type::grant, 0, Time{4}));
  ASSERT_EQ(*s.run(), Time{5});
  EXPECT_STREQ(s.board->next_grant(Time{5}).error().where, "grants go back in time");
}

TEST(SimBoardRefuses, APlantOfAnotherVersion) {
  MessageWriter w(4096);
  Welcome welcome;
  welcome.version = 3, welcome.step = 1ms, welcome.plant = "future";
  ASSERT_TRUE(w.add(Type::welcome, 0, Time{}, welcome));
  hal::ManualClock clock;
  SimBoardOptions options;
  options.clock = &clock;
  std::string why;
  auto board =
      SimBoard::open(std::make_unique<MemoryStream>(std::vector(w.pending().begin(), w.pending().end())), options, why);
  ASSERT_FALSE(board);
  EXPECT_EQ(why, "plant speaks version 3 of the simulator protocol, this runtime 1");
}

TEST(SimBoardRefuses, APlantThatRefuses) {
  MessageWriter w(4096);
  ASSERT_TRUE(w.add_text(Type::bye, Time{}, "busy with another robot"));
  hal::ManualClock clock;
  SimBoardOptions options;
  options.clock = &clock;
  std::string why;
  auto board =
      SimBoard::open(std::make_unique<MemoryStream>(std::vector(w.pending().begin(), w.pending().end())), options, why);
  ASSERT_FALSE(board);
  EXPECT_EQ(board.error().code, Errc::closed);
  EXPECT_EQ(why, "plant refused: busy with another robot");
}

TEST(SimBoardRefuses, ToOpenWithoutAClock) {
  std::string why;
  EXPECT_EQ(SimBoard::open(std::make_unique<MemoryStream>(std::vector<std::byte>{}), {}, why).error().code,
            Errc::bad_argument);
}

}  // namespace
}  // namespace sinew::sim_hil::board_refusals_test
