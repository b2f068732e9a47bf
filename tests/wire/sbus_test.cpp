#include "wire/sbus.hpp"

#include <gtest/gtest.h>

#include "bytes.hpp"

namespace sinew::wire::sbus_test {
namespace {

using test::Bytes, test::joined;

// All sixteen channels at 992, packed by hand: 11 bits each, lowest first.
const Bytes kMiddle{0x0F, 0xE0, 0x03, 0x1F, 0xF8, 0xC0, 0x07, 0x3E, 0xF0, 0x81, 0x0F, 0x7C, 0xE0,
                    0x03, 0x1F, 0xF8, 0xC0, 0x07, 0x3E, 0xF0, 0x81, 0x0F, 0x7C, 0x00, 0x00};

Bytes frame_with(std::uint16_t first, bool lost = false, bool failsafe = false) {
  SbusFrame f;
  f.channel.fill(kRcMiddle);
  f.channel[0] = first;
  f.frame_lost = lost;
  f.failsafe = failsafe;
  const auto bytes = encode_sbus(f);
  return {bytes.begin(), bytes.end()};
}

std::vector<SbusFrame> found(SbusScanner& scanner, const Bytes& stream) {
  std::vector<SbusFrame> out;
  for (const std::uint8_t b : stream) scanner.push(b, [&](const SbusFrame& f) { out.push_back(f); });
  return out;
}

TEST(Sbus, SixteenChannelsAreUnpacked) {
  SbusScanner scanner;
  scanner.gap();
  const auto frames = found(scanner, kMiddle);
  ASSERT_EQ(frames.size(), 1u);
  for (const std::uint16_t c : frames[0].channel) EXPECT_EQ(c, 992);
  EXPECT_FALSE(frames[0].failsafe);
}

TEST(Sbus, EachChannelHasItsOwnBits) {
  for (std::size_t i = 0; i < 16; ++i) {
    SbusFrame f;
    f.channel[i] = 0x5A5;
    SbusScanner scanner;
    scanner.gap();
    const auto bytes = encode_sbus(f);
    const auto frames = found(scanner, {bytes.begin(), bytes.end()});
    ASSERT_EQ(frames.size(), 1u);
    EXPECT_EQ(frames[0].channel, f.channel);
  }
}

TEST(Sbus, TheReceiverSaysLostAndFailsafe) {
  SbusScanner scanner;
  scanner.gap();
  const auto frames = found(scanner, joined({frame_with(992, true), frame_with(992, true, true)}));
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_TRUE(frames[0].frame_lost);
  EXPECT_FALSE(frames[0].failsafe);
  EXPECT_TRUE(frames[1].failsafe);
}

TEST(Sbus, FutabasOtherEndsAreTaken) {
  for (const int end : {0x04, 0x14, 0x24, 0x34}) {
    Bytes f = kMiddle;
    f[24] = static_cast<std::uint8_t>(end);
    SbusScanner scanner;
    scanner.gap();
    EXPECT_EQ(found(scanner, f).size(), 1u) << end;
  }
}

TEST(Sbus, WithoutAPauseTheFirstFrameOnlyConfirms) {
  SbusScanner scanner;
  EXPECT_EQ(found(scanner, kMiddle).size(), 0u);
  EXPECT_EQ(scanner.untrusted(), 1u);
  EXPECT_EQ(found(scanner, kMiddle).size(), 1u);
}

TEST(Sbus, AStreamThatIsCutAnywhereMovesNoStickWrongly) {
  const Bytes frame = frame_with(0x0F0);  // a head's bits among the channels
  for (std::size_t cut = 0; cut < frame.size(); ++cut) {
    SbusScanner scanner;
    const Bytes rest(frame.begin() + static_cast<std::ptrdiff_t>(cut), frame.end());
    const auto frames = found(scanner, joined({rest, frame, frame, frame}));
    EXPECT_GE(frames.size(), 2u) << cut;
    for (const SbusFrame& f : frames) {
      EXPECT_EQ(f.channel[0], 0x0F0) << cut;
      EXPECT_EQ(f.channel[1], kRcMiddle) << cut;
    }
  }
}

TEST(Sbus, ALostByteMovesNoStickWrongly) {
  const Bytes frame = frame_with(300);
  for (std::size_t at = 0; at < frame.size(); ++at) {
    Bytes bad = frame;
    bad.erase(bad.begin() + static_cast<std::ptrdiff_t>(at));
    SbusScanner scanner;
    scanner.gap();
    // Receivers leave a pause after each frame, so after the spoiled one, too: the next one is found at once.
    auto frames = found(scanner, bad);
    EXPECT_EQ(frames.size(), 0u);
    scanner.gap();
    frames = found(scanner, frame);
    ASSERT_EQ(frames.size(), 1u) << at;
    EXPECT_EQ(frames[0].channel[0], 300);
  }
}

TEST(RcStick, GoesFromMinusOneToOne) {
  EXPECT_DOUBLE_EQ(rc_stick(172), -1);
  EXPECT_DOUBLE_EQ(rc_stick(992), 0);
  EXPECT_DOUBLE_EQ(rc_stick(1811), 1);
  EXPECT_DOUBLE_EQ(rc_stick(0), -992.0 / 820) << "beyond the stick's full way";
  EXPECT_DOUBLE_EQ(rc_stick(2047), 1.25) << "but not for ever";
  for (const double stick : {-1.0, -0.5, 0.0, 0.5, 1.0}) EXPECT_NEAR(rc_stick(rc_count(stick)), stick, 1e-3);
}

}  // namespace
}  // namespace sinew::wire::sbus_test
