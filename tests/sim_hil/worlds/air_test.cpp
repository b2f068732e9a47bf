// Datagrams between robots through the simulated air: who hears what, when, and from which seed.
#include "sim_hil/worlds/air.hpp"

#include <gtest/gtest.h>

namespace sinew::plant::air_test {
namespace {

using namespace std::chrono_literals;
using hal::Time;

constexpr Time kEnd{std::int64_t{1} << 60};

std::vector<std::uint8_t> text(std::uint32_t number, std::size_t size = 200) {
  std::vector<std::uint8_t> bytes(size);
  for (std::size_t i = 0; i < 4; ++i) bytes[i] = static_cast<std::uint8_t>(number >> (8 * i));
  return bytes;
}

std::uint32_t number_of(const msg::Datagram& d) {
  return static_cast<std::uint32_t>(d.data[0]) | static_cast<std::uint32_t>(d.data[1]) << 8;
}

Time ms(std::int64_t n) { return Time{n * 1'000'000}; }

/// Station 0 says `count` datagrams, one each 10 ms.
void talk(Air& air, std::uint32_t count, std::size_t station = 0) {
  for (std::uint32_t i = 0; i < count; ++i) air.send(station, ms(10 * i), text(i), ms(10 * i));
}

std::vector<std::uint32_t> heard(Air& air, std::size_t station, Time until = kEnd) {
  std::vector<std::uint32_t> numbers;
  while (const msg::Datagram* d = air.receive(station, until)) numbers.push_back(number_of(*d));
  return numbers;
}

TEST(Air, EachMateHearsADatagramOnceAndTheSenderDoesNot) {
  Air air({}, 3, 1);
  air.send(1, ms(5), text(77), ms(5));
  EXPECT_EQ(air.receive(1, kEnd), nullptr);
  for (const std::size_t mate : {0u, 2u}) {
    const msg::Datagram* d = air.receive(mate, kEnd);
    ASSERT_NE(d, nullptr);
    EXPECT_EQ(d->sender, 2u) << "the number of a robot is its place, counted from 1";
    EXPECT_EQ(d->size, 200u);
    EXPECT_EQ(number_of(*d), 77u);
    EXPECT_EQ(air.receive(mate, kEnd), nullptr);
  }
}

TEST(Air, ArrivalIsTheTimeOnTheMediumAndTheDelay) {
  Air air({.delay = 3ms, .bits_per_s = 1e6}, 2, 1);
  air.send(0, ms(10), text(1), ms(10));
  const auto on_the_medium = hal::Duration{(200 + Air::kOverheadBytes) * 8 * 1000};  // 1 us a bit
  EXPECT_EQ(air.receive(1, ms(13)), nullptr) << "nothing is heard before its time";
  const msg::Datagram* d = air.receive(1, kEnd);
  ASSERT_NE(d, nullptr);
  EXPECT_EQ((d->stamp - ms(13)).count(), on_the_medium.count());
}

TEST(Air, RobotsThatSendAtOnceWaitForEachOther) {
  Air air({.delay = 1ms, .bits_per_s = 1e6}, 3, 1);
  air.send(0, ms(10), text(1), ms(10));
  air.send(1, ms(10), text(2), ms(10));
  const Time first = air.receive(2, kEnd)->stamp, second = air.receive(2, kEnd)->stamp;
  EXPECT_EQ((second - first).count(), (200 + Air::kOverheadBytes) * 8 * 1000);
}

TEST(Air, WhatFindsTheMediumBusyForTooLongIsLostAndCounted) {
  Air air({.bits_per_s = 100e3}, 2, 1);  // 21 ms each
  for (std::uint32_t i = 0; i < 30; ++i) air.send(0, ms(1), text(i), ms(1));
  EXPECT_EQ(air.counts(0).sent, 10u);
  EXPECT_EQ(air.counts(0).tx_lost, 20u);
  EXPECT_EQ(heard(air, 1).size(), 10u);
}

TEST(Air, LosesItsShareByTheSeed) {
  Air air({.loss = 0.3}, 2, 5), same({.loss = 0.3}, 2, 5), other({.loss = 0.3}, 2, 6);
  for (Air* a : {&air, &same, &other}) talk(*a, 500);
  const auto first = heard(air, 1);
  EXPECT_NEAR(static_cast<double>(first.size()), 350, 35);
  EXPECT_EQ(first, heard(same, 1));
  EXPECT_NE(first, heard(other, 1));
  EXPECT_EQ(air.counts(1).rx_lost + air.counts(1).heard, 500u);
}

TEST(Air, TheTrafficOfOthersChangesNoLoss) {
  Air quiet({.loss = 0.3}, 3, 5), busy({.loss = 0.3}, 3, 5);
  talk(quiet, 300);
  for (std::uint32_t i = 0; i < 300; ++i) {
    busy.send(0, ms(10 * i), text(i), ms(10 * i));
    busy.send(2, ms(10 * i + 3), text(1000 + i), ms(10 * i + 3));
  }
  auto of_first = heard(busy, 1);
  std::erase_if(of_first, [](std::uint32_t n) { return n >= 1000; });
  EXPECT_EQ(of_first, heard(quiet, 1));
}

TEST(Air, JitterLetsDatagramsOvertakeEachOther) {
  Air air({.jitter = 100ms}, 2, 1);
  talk(air, 100);
  const auto order = heard(air, 1);
  EXPECT_EQ(order.size(), 100u);
  EXPECT_FALSE(std::ranges::is_sorted(order));
}

TEST(Air, NothingArrivesBeforeWhatIsGrantedAlready) {
  Air air({.delay = 1ms}, 2, 1);
  air.send(0, ms(10), text(1), ms(40));  // sent late, by a runtime in real time
  EXPECT_GT(air.receive(1, kEnd)->stamp, ms(40));
}

TEST(Air, BeyondTheRangeNothingArrives) {
  Air air({.range_m = 5}, 2, 1);
  air.move(1, {3, 4, 0});
  talk(air, 1);
  EXPECT_EQ(heard(air, 1).size(), 1u);
  air.move(1, {3, 4, 0.1});
  talk(air, 1);
  EXPECT_EQ(heard(air, 1).size(), 0u);
  EXPECT_EQ(air.counts(1).out_of_reach, 1u);
}

TEST(Air, ASplitKeepsTheHalvesApartWhileItLasts) {
  Air air({.split_from = ms(100), .split_until = ms(200)}, 4, 1);
  talk(air, 30);  // one each 10 ms
  const auto beside = heard(air, 1), beyond = heard(air, 2);
  EXPECT_EQ(beside.size(), 30u);
  EXPECT_EQ(beyond.size(), 20u);
  EXPECT_EQ(std::ranges::count_if(beyond, [](std::uint32_t n) { return n >= 10 && n < 20; }), 0);
}

TEST(Air, AListenerKeepsABoundedNumberUnderWay) {
  Air air({.delay = 10s, .bits_per_s = 1e9}, 2, 1);
  for (std::uint32_t i = 0; i < 1000; ++i) air.send(0, ms(i), text(i), ms(i));
  EXPECT_EQ(heard(air, 1).size(), Air::kMostUnderWay);
  EXPECT_EQ(air.counts(1).rx_full, 1000 - Air::kMostUnderWay);
}

TEST(Air, BytesBeyondADatagramAreZeroAlsoBehindALongerOne) {
  Air air({}, 2, 1);
  air.send(0, ms(1), std::vector<std::uint8_t>(msg::kMaxDatagramBytes, 0xFF), ms(1));
  air.send(0, ms(2), text(5, 10), ms(2));
  EXPECT_EQ(air.receive(1, kEnd)->data.back(), 0xFF);
  const msg::Datagram* d = air.receive(1, kEnd);
  EXPECT_EQ(number_of(*d), 5u);
  EXPECT_TRUE(std::ranges::all_of(std::span(d->data).subspan(10), [](std::uint8_t b) { return b == 0; }));
}

TEST(Air, HasTheOptionsOfItsTable) {
  const WorldInfo world{"test", {}, kSharedWorldOptions};
  const AirOptions usual = air_options(world, {}), none = air_options({}, {});
  EXPECT_EQ(usual.delay, none.delay) << "a default that the table and the air's struct both have";
  EXPECT_EQ(usual.bits_per_s, none.bits_per_s);
  EXPECT_EQ(usual.range_m, none.range_m);
  const AirOptions set = air_options(world, {{"air_loss", 0.25},
                                             {"air_delay_ms", 200},
                                             {"air_jitter_ms", 7},
                                             {"air_kbps", 64},
                                             {"air_range_m", 12},
                                             {"air_split_at_s", 3},
                                             {"air_split_s", 2}});
  EXPECT_EQ(set.loss, 0.25);
  EXPECT_EQ(set.delay, 200ms);
  EXPECT_EQ(set.jitter, 7ms);
  EXPECT_EQ(set.bits_per_s, 64e3);
  EXPECT_EQ(set.range_m, 12);
  EXPECT_EQ(set.split_from, ms(3000));
  EXPECT_EQ(set.split_until, ms(5000));
}

}  // namespace
}  // namespace sinew::plant::air_test
