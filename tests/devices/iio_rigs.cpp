// The kernel's IIO as a tree of files and a pipe, read by the real driver.
#include <cerrno>
#include <cmath>

#include <gtest/gtest.h>

#include "../hal/linux/devices/temp_folder.hpp"
#include "hal/linux/devices/iio_imu.hpp"
#include "hal/linux/devices/serial.hpp"
#include "rig.hpp"
#include "sim_hil/wire/iio_tree.hpp"

namespace sinew::test {
namespace {

class IioRig final : public Rig {
 public:
  IioRig() {
    device = measures = "imu";
    names = {"mpu6050", "/sys/bus/iio/devices", "/dev/iio:device0"};
    kernel.group = "iio";
    specs.devices.push_back(table(device, "iio", {{"name", std::string("mpu6050")}, {"root", folder_.path()}}));
    connectors.open_iio = [this](const hal::IioSpec& spec, std::string& why) {
      return hal::open_iio_imu(os, spec, why);
    };
    plug();
  }
  std::vector<Way> ways(Fault fault) const override {
    if (fault == Fault::absent) return {{.label = "no such device"}, {.label = "another one is there"}};
    if (fault == Fault::garbage) return {{.label = "values"}, {.label = "values and stamps"}, {.label = "its files"}};
    return {{}};
  }
  void inject(Fault fault, std::size_t way) override {
    fault_ = fault, way_ = way;
    if (fault == Fault::absent || fault == Fault::unplugged) tree_.reset();
    if (fault == Fault::absent && way == 1) plug("bmi160");
    if (fault == Fault::denied) kernel.refuse(folder_.path() + "/dev/iio:device0", EACCES);
    // industrialio-buffer.c: a second open() of the node is refused.
    if (fault == Fault::busy) {
      kernel.refuse(folder_.path() + "/dev/iio:device0", EBUSY);
      tree_->set_file("buffer/enable", "1");
    }
    if (fault == Fault::garbage && way == 2) {
      tree_.reset();
      plug();
      tree_->set_file("in_accel_scale", "fast");
    }
  }
  void heal() override {
    if (fault_ == Fault::busy) {
      EXPECT_TRUE(tree_->enabled()) << "the other program's stream was stopped";
    }
    if (fault_ == Fault::absent || (fault_ == Fault::garbage && way_ == 2)) tree_.reset();
    fault_.reset();
    kernel.refuse(folder_.path() + "/dev/iio:device0", 0);
    if (!tree_) plug();
  }
  void advance(Time now) override {
    for (; next_ <= now; next_ = next_ + 5ms) measure(next_);
  }
  std::string as_on_a_robot(std::string text) const override {
    for (std::size_t at; (at = text.find(folder_.path())) != std::string::npos;) text.erase(at, folder_.path().size());
    return text;
  }

 private:
  void plug(const std::string& name = "mpu6050") {
    sim_hil::IioTreeSpec spec;
    spec.root = folder_.path();
    spec.name = name;
    auto tree = sim_hil::IioTree::make(spec);
    if (!tree) return;  // the test's own folder: the cell then fails
    tree_ = std::move(*tree);
    if (auto pipe = hal::make_pipe(tree_->buffer_path())) tree_->attach(std::move(*pipe));
  }
  void measure(Time now) {
    ++number_;
    if (!tree_ || fault_ == Fault::silent || (fault_ == Fault::slow && number_ % 64 != 0)) return;
    const double w = fault_ == Fault::stuck ? 0 : std::sin(7 * msg::seconds(now - Time{}));
    if (fault_ == Fault::garbage && way_ < 2) return noise(now);
    const msg::ImuSample sample{now, {0.1 + 0.05 * w, -0.2, 0.3}, {1, -2 + 0.1 * w, 9.81}};
    // Lost when nobody reads, as in the kernel.
    (void)tree_->feed(sample);
    if (fault_ == Fault::duplicate) (void)tree_->feed(sample);
  }
  void noise(Time now) {
    std::vector<std::uint8_t> scan(tree_->scan_bytes());
    for (std::uint8_t& b : scan) {
      random_ = random_ * 1664525 + 1013904223;
      b = static_cast<std::uint8_t>(random_ >> 24);
    }
    if (way_ == 0)
      for (std::size_t i = 0; i < 8; ++i)
        scan[scan.size() - 8 + i] = static_cast<std::uint8_t>(static_cast<std::uint64_t>(now.ns) >> (8 * i));
    if (tree_->enabled()) (void)tree_->feed_raw(scan);
  }

  hal::test::TempFolder folder_;
  std::unique_ptr<sim_hil::IioTree> tree_;
  std::optional<Fault> fault_;
  std::size_t way_ = 0;
  Time next_{1'000'000'000};
  int number_ = 0;
  std::uint32_t random_ = 1;
};

}  // namespace

std::vector<RigKind> iio_rigs() {
  return {{"iio", "`iio`", [] { return std::make_unique<IioRig>(); }}};
}

}  // namespace sinew::test
