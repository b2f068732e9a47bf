#include "drivers/board/kernel_drivers.hpp"

#include <algorithm>
#include <array>

#include "drivers/calibrated_imu.hpp"
#include "drivers/device_place.hpp"
#include "drivers/key_number.hpp"

namespace sinew::drivers {
namespace {

constexpr double kMaxImuHz = 32000, kMaxCameraHz = 1000;
constexpr int kMaxGrabWindow = 15, kMaxGrabSide = 16384;  // grab/grab_memory.hpp

/// Claims each device in `name`, which lists two where an accelerometer and a gyroscope are joined.
void claim_devices(DeviceKeys& keys, const hal::IioSpec& spec) {
  for (std::string_view rest = spec.name; !rest.empty();) {
    const std::size_t end = std::min(rest.find(','), rest.size());
    keys.claim("name", place_under("IIO device " + std::string(rest.substr(0, end)), spec.root));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
}

DeviceOpener read_iio(DeviceKeys& keys, const DeviceSpecs&) {
  hal::IioSpec spec;
  keys.read("name", spec.name, "the name of an IIO device, e.g. \"mpu6050\"",
            {.doc = "as in /sys/bus/iio/devices/*/name, its label, or \"iio:deviceN\"", .required = true});
  keys.read("root", spec.root, "the path of a folder", {.doc = "with sys/ and dev/ of the machine: a simulated one"});
  claim_devices(keys, spec);
  keys.read("rate_hz", spec.rate_hz, 0, kMaxImuHz,
            {.unit = "Hz", .doc = "samples a second, as far as the device has it; 0: as it is set"});
  keys.read("trigger", spec.trigger, "the name of a trigger",
            {.doc = "as in /sys/bus/iio/devices/trigger*/name", .otherwise = "as it is set"});
  bool buffered = true;
  if (keys.read("buffered", buffered,
                {.doc = "every sample, from the kernel's buffer; false: polls the newest one, `rate_hz` times a second",
                 .otherwise = "true if the device can; if not, and with `rate_hz`: false"}))
    spec.buffered = buffered;
  if (spec.buffered == false && spec.rate_hz <= 0)
    keys.problem("rate_hz", "a number above 0, at most " + key_number(kMaxImuHz) + "; required with buffered = false");
  keys.read_integer("buffer_length", spec.buffer_length, 2, 65536, {.doc = "samples that the kernel holds"});
  spec.fifo_priority = 88;  // above the loops that wait for it
  keys.read_integer("priority", spec.fifo_priority, 0, 99, {.doc = "SCHED_FIFO of its thread; 0: an ordinary one"});
  const ImuCalibration calibration = ImuCalibration::read(keys);
  return [spec, calibration](DeviceContext& context, std::string& why) -> hal::Result<OpenedDevice> {
    auto imu = context.connectors.iio_imu(spec, why);
    if (!imu) return imu.error();
    return opened_imu(std::move(*imu), calibration);
  };
}

hal::CameraSpec read_camera(DeviceKeys& keys, std::string_view path_is) {
  hal::CameraSpec spec;
  keys.read("path", spec.path, path_is, {.doc = "which camera", .required = true});
  keys.read_integer("width", spec.width, 16, msg::kMaxImageWidth,
                    {.unit = "px", .doc = "of the pictures in the topic"});
  keys.read_integer("height", spec.height, 16, msg::kMaxImageHeight,
                    {.unit = "px", .doc = "of the pictures in the topic"});
  keys.read_choice("format", spec.format, msg::kPixelFormats,
                   {.doc = "of the pictures in the topic, which the driver or we turn into it"});
  keys.read("rate_hz", spec.rate_hz, 0.1, kMaxCameraHz,
            {.unit = "Hz", .doc = "pictures a second, as near as it has it"});
  keys.read_integer("buffers", spec.buffers, 2, 32, {.doc = "pictures that the driver may have in work"});
  keys.read_all("control_", spec.controls, -1e12, 1e12,
                {.doc = "a control by its name, e.g. control_exposure_time_absolute", .otherwise = "as it is set"});
  return spec;
}

hal::Result<OpenedDevice> opened(hal::Result<std::unique_ptr<hal::Camera>> camera) {
  if (!camera) return camera.error();
  OpenedDevice device;
  device.camera = camera->get();
  device.report = dynamic_cast<const hal::SelfReport*>(camera->get());
  device.owner = std::shared_ptr<hal::Camera>(std::move(*camera));
  return device;
}

DeviceOpener read_v4l2(DeviceKeys& keys, const DeviceSpecs&) {
  hal::CameraSpec spec = read_camera(keys, "a video device, e.g. \"/dev/video0\" or \"usb-...\"");
  using Memory = hal::CameraSpec::Memory;
  keys.read_choice<Memory>(
      "memory", spec.memory, {{"auto", Memory::automatic}, {"mmap", Memory::mapped}, {"userptr", Memory::lent}},
      {.doc = "who owns the pictures' memory: the driver (mmap), which is copied once, or the topic"});
  keys.read("root", spec.root, "the path of a folder", {.doc = "with dev/ of the machine: a simulated one"});
  keys.claim("path", place_under("camera " + place_of_camera(spec.path), spec.root));
  return [spec](DeviceContext& context, std::string& why) { return opened(context.connectors.v4l2_camera(spec, why)); };
}

DeviceOpener read_libcamera(DeviceKeys& keys, const DeviceSpecs&) {
  const hal::CameraSpec spec = read_camera(keys, "the id of a camera as `cam -l` shows it, or its number, e.g. \"0\"");
  keys.claim("path", "libcamera's camera " + spec.path);
  return [spec](DeviceContext& context, std::string& why) {
    return opened(context.connectors.libcamera_camera(spec, why));
  };
}

DeviceOpener read_grab(DeviceKeys& keys, const DeviceSpecs&) {
  hal::GrabSpec spec;
  keys.read("name", spec.name, "the name of a program that `sinew grab` started, e.g. \"glxgears\"",
            {.doc = "the program's file name, or what `sinew grab --name` says", .required = true});
  keys.read_integer("window", spec.window, -1, kMaxGrabWindow,
                    {.doc = "its number, as `sinew grab --list` shows it; -1: the one that shows pictures"});
  keys.read("title", spec.title, "what the title of a window contains, e.g. \"Front camera\"",
            {.doc = "instead of `window`: the window with this title, else the only one whose title contains it"});
  if (keys.has("title") && keys.has("window")) keys.problem("title", "none beside `window`: one of the two");
  keys.read_integer("x", spec.x, -kMaxGrabSide, kMaxGrabSide, {.unit = "px", .doc = "left border of the region"});
  keys.read_integer("y", spec.y, -kMaxGrabSide, kMaxGrabSide, {.unit = "px", .doc = "top border of the region"});
  keys.read_integer("region_width", spec.region_width, 0, kMaxGrabSide,
                    {.unit = "px", .doc = "of the region; 0: to the window's right border"});
  keys.read_integer("region_height", spec.region_height, 0, kMaxGrabSide,
                    {.unit = "px", .doc = "of the region; 0: to the window's lower border"});
  keys.read_integer("width", spec.width, 16, msg::kMaxImageWidth,
                    {.unit = "px", .doc = "of the pictures in the topic, which the region becomes"});
  keys.read_integer("height", spec.height, 16, msg::kMaxImageHeight,
                    {.unit = "px", .doc = "of the pictures in the topic"});
  keys.read_choice("format", spec.format, msg::kPixelFormats, {.doc = "of the pictures in the topic"});
  keys.read("rate_hz", spec.rate_hz, 0, kMaxCameraHz,
            {.unit = "Hz", .doc = "pictures a second, at most as many as the program shows; 0: all of these"});
  return [spec](DeviceContext& context, std::string& why) { return opened(context.connectors.grab_camera(spec, why)); };
}

DeviceOpener read_usarsim_images(DeviceKeys& keys, const DeviceSpecs&) {
  hal::ImageServerSpec spec;
  const std::string allowed = "the image server's address, e.g. \"tcp:127.0.0.1:5003\"";
  keys.read("to", spec.endpoint, allowed, {.doc = "TCP address of the image server", .required = true});
  if (!spec.endpoint.empty() && !spec.endpoint.starts_with("tcp:")) keys.problem("to", allowed);
  keys.read_integer("x", spec.x, 0, kMaxGrabSide, {.unit = "px", .doc = "left border of the region"});
  keys.read_integer("y", spec.y, 0, kMaxGrabSide, {.unit = "px", .doc = "top border of the region"});
  keys.read_integer("region_width", spec.region_width, 0, kMaxGrabSide,
                    {.unit = "px", .doc = "of the region; 0: the whole picture"});
  keys.read_integer("region_height", spec.region_height, 0, kMaxGrabSide, {.unit = "px", .doc = "of the region"});
  if ((spec.region_width == 0) != (spec.region_height == 0))
    keys.problem("region_width", "with region_height: both or neither");
  keys.read_integer("width", spec.width, 16, msg::kMaxImageWidth,
                    {.unit = "px", .doc = "of its pictures; they are not scaled"});
  keys.read_integer("height", spec.height, 16, msg::kMaxImageHeight, {.unit = "px", .doc = "of its pictures"});
  keys.read_choice<msg::PixelFormat>("format", spec.format,
                                     {{"rgb8", msg::PixelFormat::rgb8}, {"bgr8", msg::PixelFormat::bgr8}},
                                     {.doc = "of the pictures in the topic"});
  keys.read_choice<bool>("raw_order", spec.raw_is_bgr, {{"rgb", false}, {"bgr", true}},
                         {.doc = "the bytes of a pixel of its raw pictures"});
  keys.read("rate_hz", spec.rate_hz, 0, kMaxCameraHz,
            {.unit = "Hz", .doc = "pictures a second that are asked for; 0: as fast as it answers"});
  keys.read_ms("silent_ms", spec.silent, 50, 60000,
               {.doc = "without an answer it is lost, and the connection made anew"});
  return [spec](DeviceContext& context, std::string& why) {
    return opened(context.connectors.image_server_camera(spec, why));
  };
}

constexpr std::array kKernelDrivers{
    DriverKind{"iio", "imu", read_iio},
    DriverKind{"v4l2", "camera", read_v4l2},
    DriverKind{"libcamera", "camera", read_libcamera},
    DriverKind{"grab", "camera", read_grab},
    DriverKind{"usarsim_images", "camera", read_usarsim_images},
};

}  // namespace

std::span<const DriverKind> kernel_drivers() { return kKernelDrivers; }

hal::CameraSpec camera_of(const DeviceSpec& spec) {
  std::vector<rt::Problem> told;
  DeviceKeys keys(spec, "", told);
  return read_camera(keys, "");
}

}  // namespace sinew::drivers
