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

/// The properties of the simulated camera.
struct V4l2SourceSpec {
  std::string root;     // the folder that stands for "/"; made where it is missing
  unsigned number = 0;  // dev/videoN
  std::string by_id = "usb-Sinew_Plant_Camera-video-index0";  // its name in dev/v4l/by-id
  std::string card = "Plant Camera", bus_info = "sim:plant-1";
  msg::PixelFormat format = msg::PixelFormat::yuyv;
  std::uint32_t width = 320, height = 240;
  double rate_hz = 30;
};

/// A camera whose pictures a simulated world draws, for a robot in another process: a socket in the place of
/// /dev/videoN, which V4l2TreePort makes a V4L2 device of. Pictures lie in shared memory and are not copied here. Any
/// number of openers may look at it; one at a time streams.
/// Thread:  canvas() and deliver(): one; the others: any. Its own thread talks to the openers.
class V4l2Source {
 public:
  /// Errors:  bad_argument, busy (the socket is in use already), denied, io, out_of_memory; `why` says it in words.
  static Result<std::unique_ptr<V4l2Source>> open(Os& os, const V4l2SourceSpec& spec, const ThreadOptions& thread,
                                                  std::string& why);
  ~V4l2Source();  // also unplugs it

  /// Memory for the next picture, rows without padding, until deliver(). RT: yes.
  std::span<std::uint8_t> canvas() noexcept;
  /// The drawn picture is frame `number` of the sensor, exposed around `middle` of this system's clock. It is sent if
  /// an opener streams and a slot was free; otherwise it is lost, which the receiver sees by the numbers.
  /// RT: yes, one system call.
  void deliver(Time middle, std::uint32_t number) noexcept;

  /// Unplugs it, or plugs it in (it is plugged in at the start): takes effect within the thread's next round.
  void set_plugged(bool plugged) noexcept;
  bool streams() const { return streams_.load(std::memory_order_acquire); }
  /// Frames that were handed over; frames without a free slot while an opener streamed.
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

  // One bit a slot. free: not in use (cleared by deliver(), set by the thread); filled: drawn, on its way to the
  // thread.
  std::atomic<std::uint32_t> free_{(1u << kCableSlots) - 1}, filled_{0};
  std::atomic<bool> plugged_{true}, stop_{false}, streams_{false};
  Tally sent_, lost_;
  std::unique_ptr<Stream> bell_, bell_heard_;

  // Only for the thread:
  std::unique_ptr<Listener> listener_;
  std::vector<std::unique_ptr<Client>> clients_;
  const Client* owner_ = nullptr;  // the opener that claimed it
  std::uint32_t lent_ = 0;         // slots at the owner
  std::unique_ptr<Thread> thread_;
};

}  // namespace sinew::hal
