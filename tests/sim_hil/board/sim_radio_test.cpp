// Datagrams between the board and a plant.
#include "rig.hpp"

namespace sinew::sim_hil::sim_radio_test {
namespace {

using hal::Errc;

template <class M>
std::vector<M> drain(hal::Sensor<M>& device) {
  std::vector<M> all;
  for (M m; *device.read(m);) all.push_back(m);
  return all;
}

TEST(SimLockstep, ARadioHearsWhenItArrivesAndSaysWithItsCommit) {
  std::vector<PlantLink::Sent> said;
  Rig rig(
      [&](PlantLink& plant) {
        msg::Datagram d;
        d.stamp = at(3ms), d.sender = 2, d.size = 2, d.data[0] = 7;
        ASSERT_TRUE(plant.send(kRadio, d, d.stamp));
        ASSERT_TRUE(plant.grant(at(10ms)));
        ASSERT_TRUE(plant.grant(at(20ms)));
        said.assign(plant.sent().begin(), plant.sent().end());
        plant.forget_sent();
        EXPECT_TRUE(plant.sent().empty());
      },
      {}, plant_with_radio());
  hal::Radio* radio = *rig.board->radio("radio");
  ASSERT_TRUE(rig.board->next_grant({}));
  EXPECT_EQ(radio->ready_at(), at(3ms));
  msg::Datagram d;
  rig.clock.set(at(3ms));
  ASSERT_TRUE(*radio->read(d));
  EXPECT_EQ(d.stamp, at(3ms));
  EXPECT_EQ(d.sender, 2u);
  EXPECT_EQ(d.bytes().size(), 2u);
  EXPECT_EQ(d.data[0], 7);
  rig.clock.set(at(5ms));
  const std::uint8_t hello[] = {'h', 'i'};
  EXPECT_TRUE(radio->send(hello));
  EXPECT_EQ(radio->send({}).error().code, Errc::bad_argument);
  EXPECT_EQ(radio->send(std::vector<std::uint8_t>(1201)).error().code, Errc::bad_argument);
  ASSERT_TRUE(rig.board->next_grant(at(10ms)));
  EXPECT_FALSE(rig.board->next_grant(at(20ms)));
  const hal::RadioStats stats = radio->stats();
  rig.finish();
  ASSERT_EQ(said.size(), 1u);
  EXPECT_EQ(said[0].commit, at(5ms));
  EXPECT_EQ(said[0].datagram.size, 2u);
  EXPECT_EQ(said[0].datagram.data[1], 'i');
  EXPECT_EQ(stats.received, 1u);
  EXPECT_EQ(stats.sent, 1u);
  EXPECT_EQ(stats.sent_bytes, 2u);
}

TEST(SimLockstep, DatagramsThatNobodyReadsAreLostOldestFirstAndCounted) {
  Rig rig(
      [](PlantLink& plant) {
        for (std::uint8_t i = 0; i < 100; ++i) {
          msg::Datagram d;
          d.stamp = at(1ms), d.size = 1, d.data[0] = i;
          ASSERT_TRUE(plant.send(kRadio, d, d.stamp));
        }
        static_cast<void>(plant.grant(at(1ms)));
      },
      {}, plant_with_radio());
  hal::Radio* radio = *rig.board->radio("radio");
  ASSERT_TRUE(rig.board->next_grant({}));
  rig.clock.set(at(1ms));
  const auto heard = drain(*radio);
  ASSERT_EQ(heard.size(), 64u);
  EXPECT_EQ(heard[0].data[0], 36);
  EXPECT_EQ(heard[0].lost, 36u);
  EXPECT_EQ(heard[1].lost, 0u);
  EXPECT_EQ(radio->stats().rx_lost, 36u);
}

}  // namespace
}  // namespace sinew::sim_hil::sim_radio_test
