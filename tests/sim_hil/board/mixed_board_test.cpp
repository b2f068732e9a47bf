// A robot on several boards: each device from its own, in virtual time too.
#include "hal/mixed_board.hpp"

#include "../../dataset/dataset_fixture.hpp"
#include "dataset/dataset_board.hpp"
#include "rig.hpp"

namespace sinew::sim_hil::mixed_board_test {
namespace {

using hal::Errc;

/// Says which device it was asked for.
class NamedBoard final : public hal::EmptyBoard {
 public:
  hal::Result<hal::Device*> open_sensor(hal::SensorKind, std::string_view name) override { return asked_for(name); }
  hal::Result<hal::Radio*> radio(std::string_view name) override { return asked_for(name); }
  hal::Result<hal::Actuators*> actuators(std::string_view name) override { return asked_for(name); }
  std::vector<std::string> asked;

 private:
  hal::Error asked_for(std::string_view name) {
    asked.emplace_back(name);
    return {Errc::not_found, "a name is all there is"};
  }
};

TEST(MixedBoard, HandsEachNamedDeviceToItsBoardAndAllOthersToTheFirst) {
  NamedBoard first, second;
  hal::MixedBoard mixed(first);
  mixed.assign("motors", second);
  mixed.assign("wings", second);
  EXPECT_FALSE(mixed.sensor<msg::ImuSample>("imu"));
  EXPECT_FALSE(mixed.actuators("motors"));
  mixed.assign("air", second);
  EXPECT_FALSE(mixed.radio("air"));
  EXPECT_EQ(first.asked, std::vector<std::string>{"imu"});
  EXPECT_EQ(second.asked, (std::vector<std::string>{"motors", "air"}));
  EXPECT_EQ(mixed.unused(), std::vector<std::string>{"wings"}) << "nobody has wings";
}

TEST(MixedBoard, RecordedCameraFliesOnASimulatedRobotInVirtualTime) {
  dataset::test::Folder folder;
  folder.write("imu0.csv", dataset::test::imu_csv(9));
  folder.write("cam0/" + dataset::test::image_name(2'000'000), dataset::test::grey_png(10));
  folder.write("cam0/" + dataset::test::image_name(22'000'000), dataset::test::grey_png(20));
  Rig rig([](PlantLink& plant) {
    for (int ms = 0; ms <= 50; ++ms) {
      ASSERT_TRUE(plant.send(kImu, imu_sample(ms * 1ms, ms), at(ms * 1ms)));
      if (!plant.grant(at(ms * 1ms))) return;
    }
  });
  std::string why;
  auto record = dataset::DatasetBoard::open({.folder = folder.path(), .clock = &rig.clock}, why);
  ASSERT_TRUE(record) << why;
  hal::MixedBoard mixed(*rig.board);
  mixed.assign("camera", **record);
  hal::Imu* imu = *mixed.sensor<msg::ImuSample>("imu");
  hal::Camera* camera = *mixed.camera("camera");
  ASSERT_TRUE(mixed.actuators("motors"));
  EXPECT_TRUE(mixed.unused().empty());
  ImageBox image(4096);
  msg::ImuSample sample;
  std::vector<std::pair<std::int64_t, int>> seen;  // stamp in ms, grey level
  int imu_samples = 0;
  for (auto until = rig.board->next_grant({}); until && *until < at(30ms); until = rig.board->next_grant(*until)) {
    rig.clock.set(*until);
    while (*imu->read(sample))
      imu_samples += static_cast<std::int64_t>(sample.gyro_radps.x) == (sample.stamp - Time{}) / 1ms;
    while (camera->ready_at() <= *until && *camera->read(*image))
      seen.emplace_back((image->stamp - Time{}) / 1ms, image.pixels().front());
  }
  EXPECT_EQ(imu_samples, 30) << "of the plant";
  EXPECT_EQ(seen, (std::vector<std::pair<std::int64_t, int>>{{2, 10}, {22, 20}})) << "of the record, on the same clock";
}

}  // namespace
}  // namespace sinew::sim_hil::mixed_board_test
