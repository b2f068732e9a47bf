#pragma once
// The connectors of a computer, by name: hal/linux opens the kernel's, sim_hil the plant's, the Windows CE stub none.
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/buses.hpp"
#include "hal/can_bus.hpp"
#include "hal/device.hpp"
#include "hal/radio.hpp"
#include "hal/udp_address.hpp"

namespace sinew::hal {

/// A CAN bus to open. `transport`:
/// - "socketcan": the kernel's interface of that name ("can0", "vcan0");
/// - "udp": DroneCAN's multicast framing, address "239.65.82.B" or just the bus number B, optional ":INTERFACE";
/// - "socketcand": a socketcand server, address "HOST:PORT/BUS".
struct CanSpec {
  std::string transport, address;
  std::uint32_t bit_rate = 1'000'000;  // for the bus load; the system sets up the interface itself
  std::uint32_t data_bit_rate = 0;     // CAN FD; 0: classic frames only
  bool receive_own = false;            // tests: what this bus object sends comes back to it
};

struct SerialSpec {
  std::string path;
  std::uint32_t bit_rate = 115200;
  bool even_parity = false, two_stop_bits = false, inverted = false;  // SBUS: 100000 8E2, inverted in hardware
  /// The latency timer of a USB adapter (FTDI: 16 ms) is set to 1 ms; where that is not permitted, the open succeeds
  /// and `why` names the file.
  bool low_latency = false;
  std::string root = "/";  // the tree with sys/: a simulated one in tests
};

struct SpiSpec {
  std::string path;  // "/dev/spidev0.0"
  std::uint32_t hz = 1'000'000;
  std::uint8_t mode = 0;  // 0..3
};

struct GpioSpec {
  std::string chip;  // "/dev/gpiochip0", or the chip's label
  std::string line;  // number or name of the line
  bool output = false, active_low = false, initial = false;
  bool rising = false, falling = false;  // edges to wait for
};

/// A sensor behind the kernel's Industrial I/O.
struct IioSpec {
  std::string name;        // of the device ("mpu6050"), its label, or "iio:deviceN"
  std::string root = "/";  // the tree with sys/bus/iio/devices and dev/: a simulated one in tests
  double rate_hz = 0;      // 0: as it is
  std::string trigger;     // current_trigger; empty: as it is
  /// True: read from the buffer; false: poll the *_raw files at rate_hz. Empty: from the buffer if there is one that
  /// can be started, else polled if there is a rate_hz; with a `trigger` from the buffer.
  std::optional<bool> buffered;
  std::uint32_t buffer_length = 64;  // scans
  int fifo_priority = 0;             // SCHED_FIFO of the reading thread; 0: ordinary
};

/// A camera behind V4L2 or libcamera.
struct CameraSpec {
  std::string path;  // "/dev/video0", "usb-...": see hal/linux/camera/v4l2_camera.hpp; libcamera: its id
  std::uint32_t width = 640, height = 480;
  msg::PixelFormat format = msg::PixelFormat::yuyv;
  double rate_hz = 30;
  std::uint32_t buffers = 4;
  /// Where the driver puts pictures. Only for V4L2: hal/camera_memory.hpp.
  enum class Memory : std::uint8_t {
    automatic,  // lent by the reader where both sides can, else mapped
    mapped,     // the driver's own; copied once
    lent,       // lent by the reader, or an error
  } memory = Memory::automatic;
  std::map<std::string, double, std::less<>> controls;  // by name, "exposure_time_absolute" = 100
  std::string root =
      "/";  // V4L2: the folder with dev/: a simulated one holds sockets (hal/linux/camera/v4l2_tree_port.hpp)
};

/// A window of a program started by `sinew grab` (docs/grab.md).
struct GrabSpec {
  std::string name;                                   // of the session: the program's, or what --name says
  std::int32_t window = -1;                           // its number; -1: the one that shows pictures
  std::string title = {};                             // or what the window's title contains; empty: any
  std::int32_t x = 0, y = 0;                          // region of the window, from its top left
  std::uint32_t region_width = 0, region_height = 0;  // 0: to the border
  std::uint32_t width = 640, height = 480;            // of the images that the region becomes
  msg::PixelFormat format = msg::PixelFormat::yuyv;
  double rate_hz = 30;  // 0: every picture that the program shows
};

/// The picture of a simulator's image server: USARSim's (docs/camera.md).
struct ImageServerSpec {
  std::string endpoint;                               // "tcp:HOST:5003"
  std::uint32_t x = 0, y = 0;                         // region of its picture, from the top left
  std::uint32_t region_width = 0, region_height = 0;  // 0: the whole picture
  std::uint32_t width = 320, height = 240;            // of the images, which are not scaled
  msg::PixelFormat format = msg::PixelFormat::rgb8;   // or bgr8
  bool raw_is_bgr = false;                            // the bytes of its raw pictures
  double rate_hz = 15;                                // 0: as fast as it answers
  Duration silent = std::chrono::seconds(2);          // without a picture that was asked for: it is lost
};

/// A radio made of UDP: datagrams to a multicast group, which everyone on the network hears, or to peers one by one
/// where there is no multicast (also to the broadcast address of a network). Or one that a program beside the robot
/// has.
struct RadioSpec {
  UdpAddress group{0xEF480101, 4580};  // 239.72.1.1: of those that are for local use (RFC 2365)
  /// Of the group. Empty: the one to which the route to the group leads; if there is none the first that is up and has
  /// an address; if there is no network the loopback interface.
  std::string interface;
  int ttl = 1;                    // of the group: how many networks a datagram reaches
  std::vector<UdpAddress> peers;  // not empty: datagrams go to each of these, and the group is not used
  std::uint16_t port = 4580;      // with peers: where this radio listens, and sends from; with `listens`, too
  /// Neither group nor peers: whatever comes in at `port` is heard, broadcasts also where other programs of this
  /// machine listen there. Only Radio::send_to() sends.
  bool listens = false;
  /// Not empty: nothing of the above, but the program `sinew net` of the robot with this name, which has DDS.
  std::string net{};
};

/// Opens buses, ports and kernel devices. An opened object lives as long as the caller keeps it, and not longer than
/// this.
/// Thread:  owner, configure only.
/// Errors:  not_found, denied, busy, not_supported, bad_argument, io; `why` has it in words with the path and the
///          remedy.
class Connectors {
 public:
  virtual ~Connectors() = default;
  virtual Result<std::unique_ptr<CanBus>> can(const CanSpec& spec, std::string& why) = 0;
  virtual Result<std::unique_ptr<I2cBus>> i2c(const std::string& path, std::string& why) = 0;
  virtual Result<std::unique_ptr<SpiBus>> spi(const SpiSpec& spec, std::string& why) = 0;
  virtual Result<std::unique_ptr<Serial>> serial(const SerialSpec& spec, std::string& why) = 0;
  virtual Result<std::unique_ptr<Gpio>> gpio(const GpioSpec& spec, std::string& why) = 0;
  virtual Result<std::unique_ptr<Imu>> iio_imu(const IioSpec& spec, std::string& why) = 0;
  virtual Result<std::unique_ptr<Camera>> v4l2_camera(const CameraSpec& spec, std::string& why) = 0;
  virtual Result<std::unique_ptr<Camera>> libcamera_camera(const CameraSpec& spec, std::string& why) = 0;
  /// Not where there is no `sinew grab`.
  virtual Result<std::unique_ptr<Camera>> grab_camera(const GrabSpec& spec, std::string& why) {
    why = "no program is grabbed here: '" + spec.name + "'";
    return Error{Errc::not_supported, "grabbed program"};
  }
  /// Not where there are no image servers.
  virtual Result<std::unique_ptr<Camera>> image_server_camera(const ImageServerSpec& spec, std::string& why) {
    why = "no image server is read here: '" + spec.endpoint + "'";
    return Error{Errc::not_supported, "image server"};
  }
  virtual Result<std::unique_ptr<Radio>> radio(const RadioSpec& spec, std::string& why) = 0;
};

}  // namespace sinew::hal
