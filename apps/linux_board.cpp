#include "apps/linux_board.hpp"

#include <algorithm>

#include "drivers/driver_list.hpp"
#include "hal/linux/connectors.hpp"
#ifdef SINEW_HAVE_LIBCAMERA
#include "hal/linux/libcamera/libcamera_camera.hpp"
#endif

namespace sinew::app {
namespace {

#ifdef SINEW_HAVE_LIBCAMERA
hal::Result<std::unique_ptr<hal::Camera>> open_libcamera(const hal::CameraSpec& spec, hal::Os& os, std::string& why) {
  auto camera = hal::open_libcamera_camera(spec, os, why);
  if (!camera) return camera.error();
  return std::unique_ptr<hal::Camera>(std::move(*camera));
}
#else
constexpr hal::LibcameraOpener* open_libcamera = nullptr;
#endif

}  // namespace

bool uses_linux_board(const rt::GraphSpec& robot) {
  return robot.board == "linux" || std::any_of(robot.device_boards.begin(), robot.device_boards.end(),
                                               [](const auto& device) { return device.second.value == "linux"; });
}

std::vector<rt::Problem> check_linux_devices(const RobotFile& robot) {
  return drivers::check_devices(robot.devices, drivers::all_drivers());
}

hal::Result<std::unique_ptr<LinuxBoard>> LinuxBoard::open(const RobotFile& robot, hal::Os& os, std::string& why) {
  auto connectors = hal::LinuxConnectors::open(os, why, open_libcamera);
  if (!connectors) return connectors.error();
  std::unique_ptr<LinuxBoard> board(new LinuxBoard);
  board->connectors_ = std::move(*connectors);
  board->board_ =
      std::make_unique<drivers::DeviceBoard>(robot.devices, drivers::all_drivers(), *board->connectors_, os);
  return board;
}

LinuxBoard::~LinuxBoard() = default;

hal::Status LinuxBoard::start() { return board_->start(); }

}  // namespace sinew::app
