// A plant that is lost and comes back, and a plant on another machine: its clock, and the time without it.
#include "hal/scaled_os.hpp"
#include "hal/wide.hpp"
#include "listener_rig.hpp"

namespace sinew::sim_hil::relink_test {
namespace {

using hal::Errc;
using hal::system_os;

/// A plant behind a listener, on a thread: one part of the test after the other, each with its own connection.
class ReturningPlant {
 public:
  using Part = std::function<void(PlantLink&)>;
  explicit ReturningPlant(std::vector<Part> parts, std::vector<PlantDescription> plants = {}) {
    if (plants.empty()) plants.assign(parts.size(), small_plant());
    thread_ = std::move(*system_os().start_thread({"plant", 0, {}, 1 << 18}, [this, parts, plants] {
      for (std::size_t i = 0; i < parts.size(); ++i) {
        auto caller = rig_.plant_listener->wait_runtime(kLong);
        if (!caller) return;
        auto frames = std::move(*hal::create_shared_memory("frames", PlantLink::frame_memory_bytes(plants[i])));
        std::string why;
        auto link = PlantLink::accept(std::move(*caller), plants[i], frames.get(), why);
        if (link && (*link)->wait_start()) parts[i](**link);
        link = hal::Error{};  // hangs up
        rig_.plant_listener->let_go();
      }
    }));
  }
  ~ReturningPlant() { thread_->join(); }
  Connect connect() {
    return [this] { return hal::connect_stream(rig_.endpoint(), 100ms); };
  }

 private:
  DoorRig rig_;
  std::unique_ptr<hal::Thread> thread_;
};

SimBoardOptions coming_back(Connect connect, Duration relink_for = kLong) {
  SimBoardOptions o;
  o.mode = Mode::free_running;
  o.clock = &system_os();
  o.os = &system_os();
  o.late_after = 1h;
  o.connect = std::move(connect);
  o.relink_for = relink_for;
  return o;
}

std::unique_ptr<SimBoard> meet(const SimBoardOptions& options) {
  std::string why;
  auto stream = options.connect();
  EXPECT_TRUE(stream);
  auto board = SimBoard::open(std::move(*stream), options, why);
  EXPECT_TRUE(board) << why;
  return board ? std::move(*board) : nullptr;
}

template <class Done>
bool until(Done done) {
  const Time give_up = system_os().now() + kLong;
  while (!done())
    if (system_os().now() > give_up)
      return false;
    else
      system_os().sleep_until(system_os().now() + 200us);
  return true;
}

/// Sends one sample and keeps the line open until `hang_up`.
ReturningPlant::Part one_sample(Duration stamp, double gyro_x, std::atomic<bool>& hang_up) {
  return [=, &hang_up](PlantLink& plant) {
    ASSERT_TRUE(plant.start_clock(at(stamp), system_os().now()));
    ASSERT_TRUE(plant.send(kImu, imu_sample(stamp, gyro_x), at(stamp)));
    while (!hang_up && plant.exchange()) system_os().sleep_until(system_os().now() + 1ms);
  };
}

TEST(SimRelink, PlantThatComesBackIsTakenUpAgainAndTheRunGoesOn) {
  std::atomic<bool> lose{false}, end{false}, commanded{false};
  // The second one is a plant started anew: its time begins at 0 again.
  ReturningPlant plant({one_sample(5s, 1, lose), [&](PlantLink& link) {
                          one_sample(1ms, 2, end)(link);
                          commanded = link.stats().commands > 0;
                        }});
  std::atomic<bool> in_reach{true};
  const Connect connect = [&, reach = plant.connect()]() -> hal::Result<std::unique_ptr<hal::Stream>> {
    if (!in_reach) return hal::Error{Errc::closed, "out of reach"};
    return reach();
  };
  {
    const auto board = meet(coming_back(connect));
    hal::Imu* imu = *board->sensor<msg::ImuSample>("imu");
    hal::Actuators* motors = *board->actuators("motors");
    ASSERT_TRUE(board->start());
    msg::ImuSample first, second;
    ASSERT_TRUE(until([&] { return *imu->read(first); }));
    EXPECT_EQ(first.gyro_radps.x, 1);
    EXPECT_TRUE(motors->write(hover(0.5, system_os().now() - Time{}), 1s));
    EXPECT_EQ(board->link_trouble(), "");
    in_reach = false;  // until the outage has been seen
    lose = true;
    bool refused = false, told = false;
    ASSERT_TRUE(until([&] {
      const hal::Status sent = motors->write(hover(0.5, system_os().now() - Time{}), 1s);
      refused |= !sent && sent.error().code == Errc::closed;
      told |= !board->link_trouble().empty();
      if (refused && told) in_reach = true;
      const auto got = imu->read(second);
      EXPECT_TRUE(got) << "no sample is normal, an error would stop the module";
      return got && *got;
    }));
    EXPECT_TRUE(refused);
    EXPECT_TRUE(told);
    EXPECT_EQ(second.gyro_radps.x, 2);
    EXPECT_GT(second.stamp, first.stamp) << "on the runtime's clock time goes forward";
    EXPECT_TRUE(until([&] { return static_cast<bool>(motors->write(hover(0.5, system_os().now() - Time{}), 1s)); }));
    EXPECT_FALSE(board->ended());
    const SimStats stats = board->stats();
    ASSERT_EQ(stats.outages.size(), 1u);
    EXPECT_GT(stats.outages[0].length, 0ns);
    EXPECT_NE(stats.outages[0].why.find("connection to plant 'small' lost"), std::string::npos) << stats.outages[0].why;
    EXPECT_EQ(stats.devices[kImu].lost, 0u) << "the outage says it";
    system_os().sleep_until(system_os().now() + 20ms);
    end = true;
  }
}

TEST(SimRelink, FramesInSharedMemoryGoOnAndAnOldOneIsStillWhole) {
  std::atomic<bool> lose{false}, end{false};
  const auto frames_of = [](std::uint8_t value, std::atomic<bool>& over) {
    return [=, &over](PlantLink& link) {
      ASSERT_TRUE(link.start_clock(at(0s), system_os().now()));
      ASSERT_TRUE(link.frames_in_shared_memory());
      const FrameSlot slot = link.begin_frame(kCamera);
      for (auto& p : slot.pixels) p = value;
      ASSERT_TRUE(link.send_frame(kCamera, slot, {at(33ms), at(33ms), 0, 1}));
      while (!over && link.exchange()) system_os().sleep_until(system_os().now() + 1ms);
    };
  };
  ReturningPlant plant({frames_of(11, lose), frames_of(22, end)});
  const auto board = meet(coming_back(plant.connect()));
  hal::Camera* camera = *board->camera("camera");
  ASSERT_TRUE(board->start());
  ASSERT_TRUE(until([&] { return board->stats().devices[kCamera].samples == 1; }));
  lose = true;
  ASSERT_TRUE(until([&] { return board->stats().devices[kCamera].samples == 2; }));
  ImageBox image(256);  // the first one is in the memory of the plant that is gone
  ASSERT_TRUE(*camera->read(*image));
  EXPECT_EQ(image.pixels().front(), 11);
  ASSERT_TRUE(until([&] { return *camera->read(*image); })) << "a frame is counted before it can be read";
  EXPECT_EQ(image.pixels().back(), 22);
  EXPECT_EQ(board->stats().devices[kCamera].lost, 0u);
  end = true;
}

TEST(SimRelink, PlantThatComesBackAsAnotherEndsTheRunAndSaysWhatDiffers) {
  std::atomic<bool> lose{true};
  PlantDescription other = small_plant();
  other.devices[kMotors].channels = 6;
  ReturningPlant plant({one_sample(1ms, 1, lose), [](PlantLink&) {}}, {small_plant(), other});
  const auto board = meet(coming_back(plant.connect()));
  ASSERT_TRUE(board->start());
  ASSERT_TRUE(until([&] { return board->ended(); }));
  EXPECT_EQ(board->end_reason(), "plant 'small' came back as another: actuators 'motors': channels 6 instead of 4");
}

TEST(SimRelink, PlantThatStaysAwayEndsTheRunWithBothReasons) {
  auto rig = std::make_unique<DoorRig>();
  const std::string endpoint = rig->endpoint();
  auto thread = system_os().start_thread({"plant", 0, {}, 1 << 18}, [&] {
    auto caller = rig->plant_listener->wait_runtime(kLong);
    std::string why;
    auto link = PlantLink::accept(std::move(*caller), small_plant(), nullptr, why);
    ASSERT_TRUE((*link)->wait_start());
    ASSERT_TRUE((*link)->start_clock(at(0s), system_os().now()));
    rig.reset();  // nobody listens any more, and then the line breaks
  });
  const auto board = meet(coming_back([=] { return hal::connect_stream(endpoint, 1ms); }, 200ms));
  hal::Imu* imu = *board->sensor<msg::ImuSample>("imu");
  ASSERT_TRUE(board->start());
  ASSERT_TRUE(until([&] { return board->ended(); }));
  EXPECT_NE(board->end_reason().find("lost: closed: peer closed the connection"), std::string::npos);
  EXPECT_NE(board->end_reason().find("looked for it in vain"), std::string::npos) << board->end_reason();
  msg::ImuSample s;
  EXPECT_EQ(imu->read(s).error().code, Errc::closed);
  EXPECT_EQ(board->stats().outages.size(), 1u);
}

TEST(SimRelink, PlantThatSaysByeIsNotLookedFor) {
  ReturningPlant plant({[](PlantLink& link) {
    ASSERT_TRUE(link.start_clock(at(0s), system_os().now()));
    link.bye("battery empty");
  }});
  const auto board = meet(coming_back(plant.connect()));
  ASSERT_TRUE(board->start());
  ASSERT_TRUE(until([&] { return board->ended(); }));
  EXPECT_EQ(board->end_reason(), "battery empty");
  EXPECT_TRUE(board->stats().outages.empty());
}

TEST(SimRelink, ByeEndsTheSearch) {
  std::atomic<bool> lose{true};
  auto plant = std::make_unique<ReturningPlant>(std::vector{one_sample(1ms, 1, lose)});
  const auto board = meet(coming_back(plant->connect(), 1h));
  ASSERT_TRUE(board->start());
  ASSERT_TRUE(until([&] { return !board->link_trouble().empty(); }));
  board->bye("enough");  // would take an hour
  EXPECT_TRUE(board->ended());
}

TEST(SimRelink, DifferenceNamesTheFirstThingThatDoesNotFit) {
  const auto welcome = [](PlantDescription plant) {
    Welcome w;
    w.devices = std::move(plant.devices);
    return w;
  };
  const Welcome before = welcome(small_plant());
  EXPECT_EQ(difference(before, before), "");
  auto now = before;
  now.devices.pop_back();
  EXPECT_EQ(difference(before, now), "no actuators 'motors'");
  now = before;
  now.devices[kCamera].width = 32;
  EXPECT_EQ(difference(before, now), "camera 'camera': width 32 instead of 16");
  now = before;
  now.devices[kImu].period = 2ms;
  EXPECT_EQ(difference(before, now), "imu 'imu': period in ns 2000000 instead of 1000000");
  now = before;
  std::swap(now.devices[kRange], now.devices[kBaro]);
  EXPECT_EQ(difference(before, now), "baro 'baro' is new or in another place");
  now = before;
  now.devices.push_back(now.devices[0]), now.devices.back().name = "imu2";
  EXPECT_EQ(difference(before, now), "imu 'imu2' is new or in another place");
}

// ---- a plant on another machine: TCP, and a host clock that is elsewhere and drifts

class RemotePlant {
 public:
  explicit RemotePlant(bool side_lines) {
    auto listener = hal::listen_stream("tcp:127.0.0.1:0");
    EXPECT_TRUE(listener);
    endpoint_ = (*listener)->endpoint();
    if (side_lines)
      plant_listener_ =
          std::move(*PlantListener::open(host_, std::move(*listener), small_plant(), {"listener", 0, {}, 1 << 18}));
    else
      listener_ = std::move(*listener);
    thread_ = std::move(*system_os().start_thread({"plant", 0, {}, 1 << 18}, [this] { run(); }));
  }
  ~RemotePlant() {
    over_ = true;
    thread_->join();
  }
  Connect connect() const {
    return [endpoint = endpoint_] { return hal::connect_stream(endpoint, kLong); };
  }
  /// This machine's clock when the clock of the plant's host showed `t`.
  Time here(Time t) const { return host_.unscaled(t); }

  static constexpr double kDrift = 100e-6;
  hal::Wide<std::int64_t> zero_ns;  // plant host's clock at plant time 0

 private:
  void run() {
    Caller caller;
    if (plant_listener_) {
      auto came = plant_listener_->wait_runtime(kLong);
      if (!came) return;
      caller = std::move(*came);
    } else {
      caller.stream = std::move(*listener_->accept(kLong));
      std::string why;
      if (!hear_hello(caller, "small", why)) return;
    }
    std::string why;
    auto link = PlantLink::accept(std::move(caller), small_plant(), nullptr, why);
    if (!link || !(*link)->wait_start()) return;
    const Time zero = host_.now();
    zero_ns.store(zero.ns);
    if (!(*link)->start_clock(at(0s), zero)) return;
    while (!over_) {
      const Duration stamp = host_.now() - zero;
      if (!(*link)->send(kImu, imu_sample(stamp), at(stamp)) || !(*link)->exchange()) return;
      host_.sleep_until(host_.now() + 1ms);
    }
  }

  hal::ScaledOs host_{system_os(), 1 + kDrift, Time{-1'000'000'000'000'000}};
  std::string endpoint_;
  std::unique_ptr<PlantListener> plant_listener_;
  std::unique_ptr<hal::Listener> listener_;
  std::atomic<bool> over_{false};
  std::unique_ptr<hal::Thread> thread_;
};

TEST(SimRemote, StampsOfADriftingClockLieWithinTheBoundOfTheExchanges) {
  RemotePlant plant(true);
  const auto board = meet(coming_back(plant.connect()));
  hal::Imu* imu = *board->sensor<msg::ImuSample>("imu");
  ASSERT_TRUE(board->start());
  EXPECT_GE(board->stats().clock.exchanges, 1u) << "a burst before the start";
  Time last{};
  int read = 0;
  ASSERT_TRUE(until([&] {
    msg::ImuSample s;
    while (*imu->read(s)) {
      ++read;
      EXPECT_GE(s.stamp, last);
      last = s.stamp;
    }
    return board->stats().clock.exchanges >= 22;
  }));
  const SimStats stats = board->stats();
  EXPECT_TRUE(stats.remote);
  EXPECT_TRUE(stats.clock.followed);
  EXPECT_GT(read, 100);
  // Plant time t is host time zero + t there, whose instant here is known to this test.
  const Time plant_time = last - stats.clock_offset;
  const Duration miss = plant.here(Time{plant.zero_ns.load()} + (plant_time - Time{})) - last;
  EXPECT_LE(std::abs(miss.count()), stats.clock.worst_bound.count() + 1000);
  EXPECT_EQ(stats.clock.rejected, 0u);
}

TEST(SimRemote, PlantWithoutSideLinesKeepsTheFirstOffsetAndAGrowingBound) {
  RemotePlant plant(false);
  SimBoardOptions options = coming_back(plant.connect());
  const auto board = meet(options);
  ASSERT_TRUE(board->start());
  const Duration first = board->stats().clock.worst_bound;
  EXPECT_GT(first, 0ns);
  EXPECT_TRUE(until([&] { return board->stats().clock.worst_bound > first + 100us; })) << "500 ppm of what has passed";
  EXPECT_FALSE(board->stats().clock.followed);
  EXPECT_EQ(board->stats().clock.exchanges, 0u);
}

}  // namespace
}  // namespace sinew::sim_hil::relink_test
