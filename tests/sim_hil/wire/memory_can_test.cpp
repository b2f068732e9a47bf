// The bus in memory: who gets frames, which are counted, which are lost.
#include "sim_hil/wire/memory_can.hpp"

#include <gtest/gtest.h>

#include "wire/can_bytes.hpp"

namespace sinew::sim_hil::memory_can_test {
namespace {

TEST(MemoryCan, OthersGetAFrameInItsOrderAndTheSenderDoesNot) {
  hal::ManualClock clock;
  clock.set({42});
  MemoryCan wire(500'000, &clock);
  MemoryCanPort &a = wire.attach(), &b = wire.attach(), &c = wire.attach();
  ASSERT_TRUE(a.send(wire::can_frame(1, {1}), hal::kNever));
  ASSERT_TRUE(a.send(wire::can_frame(2, {2}), hal::kNever));
  msg::CanFrame frame;
  for (MemoryCanPort* port : {&b, &c}) {
    ASSERT_TRUE(*port->read(frame));
    EXPECT_EQ(frame.id, 1u);
    EXPECT_EQ(frame.stamp.ns, 42);
    ASSERT_TRUE(*port->read(frame));
    EXPECT_EQ(frame.id, 2u);
    EXPECT_FALSE(*port->read(frame));
  }
  EXPECT_FALSE(*a.read(frame));
  EXPECT_EQ(a.bit_rate(), 500'000u);
}

TEST(MemoryCan, BitsAreThoseOfTheWire) {
  MemoryCan wire;
  MemoryCanPort &a = wire.attach(), &b = wire.attach();
  (void)a.send(wire::can_frame(1, 8), hal::kNever);
  (void)a.send(wire::can_frame(1, 8, true), hal::kNever);
  EXPECT_EQ(wire.frames(), 2u);
  EXPECT_EQ(wire.bits(), 135u + 160u) << "of 8 bytes with the most stuff bits: Tindell and Burns 1994";
  EXPECT_EQ(a.stats().sent_bits, wire.bits());
  EXPECT_EQ(b.stats().received_bits, wire.bits());
}

TEST(MemoryCan, LosesWhatItIsToldTo) {
  MemoryCan wire;
  MemoryCanPort &a = wire.attach(), &b = wire.attach();
  wire.lose([](const msg::CanFrame& frame) { return frame.id == 7; });
  ASSERT_TRUE(a.send(wire::can_frame(7, 0), hal::kNever)) << "the sender does not notice";
  ASSERT_TRUE(a.send(wire::can_frame(8, 0), hal::kNever));
  msg::CanFrame frame;
  ASSERT_TRUE(*b.read(frame));
  EXPECT_EQ(frame.id, 8u);
}

TEST(MemoryCan, FiltersAndFullQueuesAreAsOnAController) {
  MemoryCan wire;
  MemoryCanPort &a = wire.attach(), &b = wire.attach();
  const hal::CanFilter only{0x100, 0x700, false};
  ASSERT_TRUE(b.set_filters({&only, 1}));
  (void)a.send(wire::can_frame(0x123, 0), hal::kNever);
  (void)a.send(wire::can_frame(0x223, 0), hal::kNever);
  (void)a.send(wire::can_frame(0x123, 0, true), hal::kNever);
  EXPECT_EQ(b.stats().received, 1u);
  for (int i = 0; i < 5000; ++i) (void)a.send(wire::can_frame(0x101, 0), hal::kNever);
  EXPECT_EQ(b.stats().received, 4096u);
  EXPECT_EQ(b.stats().rx_lost, 905u);
}

TEST(MemoryCan, BusThatIsGoneSaysSoAndComesBackEmpty) {
  MemoryCan wire;
  MemoryCanPort &a = wire.attach(), &b = wire.attach();
  (void)a.send(wire::can_frame(1, 0), hal::kNever);
  wire.connect(false);
  const auto refused = a.send(wire::can_frame(1, 0), hal::kNever);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, hal::Errc::closed);
  msg::CanFrame frame;
  EXPECT_FALSE(b.read(frame));
  EXPECT_EQ(b.stats().state, hal::CanState::stopped);
  wire.connect(true);
  const auto read = b.read(frame);
  ASSERT_TRUE(read);
  EXPECT_FALSE(*read);
}

}  // namespace
}  // namespace sinew::sim_hil::memory_can_test
