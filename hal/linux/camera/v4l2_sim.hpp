#pragma once
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "hal/clock.hpp"
#include "hal/linux/camera/v4l2_port.hpp"
#include "msg/image.hpp"

namespace sinew::hal {

/// A simulated camera's properties. The default is a small USB camera.
struct V4l2SimCamera {
  struct Size {
    std::uint32_t width, height;
  };
  struct Offer {
    std::uint32_t code;  // of V4L2: v4l2_code(PixelFormat), or another format that images cannot have
    std::string text;
    std::vector<Size> sizes;    // with `steps`: the smallest and the largest
    std::vector<double> rates;  // with `steps`: the lowest and the highest
    bool steps = false;         // in steps of 2 pixels
  };
  struct Control {
    std::uint32_t id, type;
    std::string name;
    std::int64_t min, max, step, value;
    std::uint32_t flags = 0;
  };
  V4l2SimCamera();

  std::string node = "/dev/video0", by_id = "usb-Sinew_Simulated_Camera-video-index0";
  std::string card = "Simulated Camera", driver = "sinew-sim", bus_info = "usb-sim-1.2";
  std::vector<Offer> offers;
  std::vector<Control> controls;
  std::uint32_t capabilities;       // V4L2_CAP_*
  std::uint32_t stamp_flags;        // V4L2_BUF_FLAG_TIMESTAMP_* | V4L2_BUF_FLAG_TSTAMP_SRC_*
  std::uint32_t padding_bytes = 0;  // behind each row
  bool user_pointers = true;        // takes memory of the user
  std::uint32_t fewest_buffers = 2;
  std::uint32_t pointer_alignment = 1;  // of its user's memory
  bool exposure_in_period = false;      // the longest exposure is the period of the frames, as with many sensors
  bool lists_sizes = true;              // false: a program finds what fits only by asking for it
};

/// A fault of the camera, until changed.
enum class V4l2Fault : std::uint8_t {
  none,
  silent,       // nothing comes any more
  loses,        // every second frame is missing; the driver's count goes on
  corrupt,      // the driver marks each frame as faulty
  short_frame,  // half of each picture is missing
  stuck,        // the last frame again and again, with its old stamp
  slow,         // only every fourth frame is made
  io_error,     // taking a frame fails, until the device is opened again
};

/// A V4L2 capture device in memory that answers the requests of V4l2Camera. The real driver code runs on it, fed by a
/// test or by the plant. Its descriptors are pipes, so that epoll sees frames come and the device go.
/// Thread:  any (locks).   RT: no; it is a simulator.
class V4l2Sim final : public V4l2Port {
 public:
  explicit V4l2Sim(V4l2SimCamera camera = {});
  ~V4l2Sim() override;

  /// Puts a picture in the agreed format and size into the oldest queued buffer, stamped as the driver would stamp it.
  /// False: there is no stream, no buffer was free (the frame counts as lost), or a fault swallowed it.
  bool deliver(const msg::Image& picture, Time stamp);
  /// The same for a camera in MJPEG mode: takes these bytes unchanged.
  bool deliver_jpeg(std::span<const std::uint8_t> jpeg, Time stamp);
  /// So many frames were taken and did not arrive: the driver's count goes on.
  void lose(std::uint32_t frames);
  void set_fault(V4l2Fault fault);
  /// Unplugs it: open descriptors are dead from now on, the node is gone.
  void unplug();
  /// Plugs it in again, as this node.
  void plug_in(const std::string& node = "/dev/video0");
  /// From now on this request answers with an error; 0: normal again. Request 0 is opening.
  void refuse(unsigned long request, int error);
  /// Changes a control's range, as if another camera were plugged in. Its value moves into the range.
  void set_range(const std::string& name, std::int64_t min, std::int64_t max);
  /// True: another program streams.
  void set_busy(bool busy);

  std::int64_t control(const std::string& name) const;
  bool streams() const;
  std::size_t descriptors() const;     // open now
  std::size_t mapped() const;          // pieces of memory that are mapped now
  std::size_t queued() const;          // buffers that wait for a frame
  const std::uint8_t* filled() const;  // where the newest frame was put

  std::vector<std::string> nodes() override;
  std::vector<std::string> links(const std::string& folder) override;
  int open(const std::string& path) override;
  void close(int fd) noexcept override;
  int ioctl(int fd, unsigned long request, void* argument) noexcept override;
  void* map(int fd, std::size_t bytes, std::int64_t offset) override;
  void unmap(void* memory, std::size_t bytes) noexcept override;

 private:
  using Memory = std::shared_ptr<std::vector<std::uint8_t>>;  // mapped memory outlives its descriptor, as the kernel's
  struct Done {
    std::uint32_t index, used, flags, sequence;
    Time stamp;
  };
  struct File {
    int pipe_in = -1;  // a byte for each frame that waits
    bool gone = false, streaming = false;
    std::uint32_t code = 0, width = 0, height = 0, line = 0, image_bytes = 0;
    double rate_hz = 0;
    std::vector<Memory> buffers;
    std::vector<std::uint8_t*> users;  // instead of `buffers`: the user's memory, by index; null: none yet
    std::deque<std::uint32_t> queued;
    std::deque<Done> done;
    std::uint32_t sequence = 0, made = 0;
  };
  int answer(File& file, unsigned long request, void* argument);
  int enumerate(unsigned long request, void* argument) const;
  int formats(File& file, unsigned long request, void* argument);
  int buffers(File& file, unsigned long request, void* argument);
  int controls(unsigned long request, void* argument);
  /// `fill` writes a picture into a buffer of so many bytes, and answers how many it used; 0: it does not fit.
  using Fill = std::function<std::uint32_t(const File& file, std::uint8_t* memory, std::uint32_t room)>;
  bool deliver(const Fill& fill, Time stamp);
  bool put(File& file, const Fill& fill, Time stamp, std::uint32_t sequence);
  File* streaming();

  mutable std::mutex mutex_;
  V4l2SimCamera camera_;
  bool plugged_ = true, busy_ = false;
  V4l2Fault fault_ = V4l2Fault::none;
  Time last_stamp_;
  std::uint32_t last_sequence_ = 0;
  const std::uint8_t* filled_ = nullptr;
  std::map<int, File> files_;
  std::map<void*, Memory> mapped_;
  std::map<unsigned long, int> refused_;
};

}  // namespace sinew::hal
