#pragma once
#include <array>
#include <atomic>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hal/linux/camera/v4l2_cable.hpp"
#include "hal/os.hpp"
#include "hal/stream.hpp"
#include "hal/wide.hpp"

namespace sinew::hal {

/// The camera that a V4l2Source pretends to be.
struct V4l2SourceSpec {
  std::string root;     // the folder that stands for "/"; made where it is missing
  unsigned number = 0;  // dev/videoN
  std::string by_id = "usb-Sinew_Plant_Camera-video-index0";  // its name below dev/v4l/by-id
  std::string card = "Plant Camera", bus_info = "sim:plant-1";
  msg::PixelFormat format = msg::PixelFormat::yuyv;
  std::uint32_t width = 320, height = 240;
  double rate_hz = 30;
};

/// A camera whose pictures a simulated world draws, for a robot in another process: a socket in the place of
/// /dev/videoN, which V4l2TreePort makes a V4L2 device of. Pictures lie in shared memory and are not copied here.
/// Any number may look at it; one at a time streams.
/// Thread:  canvas() and deliver(): one; the others: any. A thread of its own does the talking.
class V4l2Source {
 public:
  /// Errors:  bad_argument, busy (somebody listens there already), denied, io, out_of_memory; `why` says it in words.
  static Result<std::unique_ptr<V4l2Source>> open(Os& os, const V4l2SourceSpec& spec, const ThreadOptions& thread,
                                                  std::string& why);
  ~V4l2Source();  // unplugged

  /// Where the next picture is drawn, rows without padding, until deliver(). RT: yes.
  std::span<std::uint8_t> canvas() noexcept;
  /// What was drawn is frame `number` of the sensor, exposed around `middle` of this system's clock. It is on its way
  /// when somebody streams and had a place left; otherwise it is lost, which the receiver sees by the numbers.
  /// RT: yes, one system call.
  void deliver(Time middle, std::uint32_t number) noexcept;

  /// The plug is pulled, or put in again (it is at the start): takes effect within the thread's next round.
  void set_plugged(bool plugged) noexcept;
  bool streams() const { return streams_.load(std::memory_order_acquire); }
  /// Frames that were handed over; frames that found no place while somebody streamed.
  std::uint64_t sent() const { return sent_.value(); }
  std::uint64_t lost() const { return lost_.value(); }

 private:
  struct Client {
    std::unique_ptr<Stream> line;
    std::array<std::byte, sizeof(CableMessage)> partial{};
    std::size_t have = 0;
  };
  explicit V4l2Source(V4l2SourceSpec spec) : spec_(std::move(spec)) {}
  Status prepare(std::string& why);
  Status listen(std::string& why);
  void work() noexcept;
  void welcome();
  bool hear(Client& client);
  bool obey(Client& client, const CableMessage& message);
  void send_filled();
  void drop(const Client* client);
  void close_all();
  msg::Image& image(std::uint32_t slot) noexcept;

  const V4l2SourceSpec spec_;
  std::string node_, link_;
  std::unique_ptr<SharedMemory> memory_;
  std::size_t slot_bytes_ = 0;
  std::uint32_t drawing_ = kCableSlots;  // slot of the canvas; kCableSlots: the one that is never sent

  // A bit a slot. free: nobody has it (cleared by deliver(), set by the thread); filled: drawn, on its way to the
  // thread.
  std::atomic<std::uint32_t> free_{(1u << kCableSlots) - 1}, filled_{0};
  std::atomic<bool> plugged_{true}, stop_{false}, streams_{false};
  Tally sent_, lost_;
  std::unique_ptr<Stream> bell_, bell_heard_;

  // The thread's own.
  std::unique_ptr<Listener> listener_;
  std::vector<std::unique_ptr<Client>> clients_;
  const Client* owner_ = nullptr;  // who claimed it
  std::uint32_t lent_ = 0;         // slots that the owner has
  std::unique_ptr<Thread> thread_;
};

}  // namespace sinew::hal
