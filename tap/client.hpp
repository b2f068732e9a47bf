#pragma once
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "hal/linux/shared_memory.hpp"
#include "hal/os.hpp"
#include "hal/stream.hpp"
#include "tap/frames.hpp"
#include "tap/names.hpp"
#include "tap/segment_reader.hpp"

namespace sinew::tap {

/// Another program's connection to a running robot: requests over its socket, topics in its memory.
/// docs/robot-socket.md has all requests and replies.
/// Thread:  owner.
class Client {
 public:
  /// The running robot of this name; the only one when the name is empty. Errors: as find_running(); closed, io;
  /// not_supported: another version of the protocol. `why` has the error in words.
  static hal::Result<std::unique_ptr<Client>> connect(std::string_view robot, std::string& why);
  /// On a connection made elsewhere.
  explicit Client(std::unique_ptr<hal::Stream> stream) : stream_(std::move(stream)) {}

  /// Sends {"request": name, members of `arguments`} and answers the reply, a JSON object with "ok", and with "error"
  /// {"code", "why"} when that is false. `arguments` is a JSON object.
  /// Errors:  closed when the robot ended; timeout after the patience; bad_data: that was no reply; bad_argument:
  ///          no object, or longer than a request may be.
  hal::Result<std::string> request(std::string_view name, std::string_view arguments = "{}");

  /// request(), and hands the memory to the robot with it.
  hal::Result<std::string> request_with_memory(std::string_view name, std::string_view arguments,
                                               const hal::SharedMemory& memory);
  /// True when the robot has closed the connection, between two requests. Does not wait.
  bool ended();

  /// The topics, mapped at the first call. The reader is valid as long as the client.
  /// Errors:  as request(); not_supported: this run has no shared memory; bad_data.
  hal::Result<const SegmentReader*> reader();

  /// Asks to be woken by the named topics, at most once a `period`. Replaces the earlier subscription.
  hal::Status subscribe(std::span<const std::string> topics, hal::Duration period = std::chrono::milliseconds(1));
  /// The count of a topic's doorbell: it changes when messages came. Look at it before reading, wait on it afterwards.
  std::uint32_t bell(std::uint32_t topic) const;
  /// Sleeps until the bell differs from `seen`, at most until `deadline` of the Os. May return early.
  void wait(std::uint32_t topic, std::uint32_t seen, hal::Time deadline) const;
  /// A topic's bell as it was before reading.
  struct Heard {
    std::uint32_t topic, bell;
  };
  /// The same for several topics, and for a word of the caller's own, on which others call hal::wake_shared().
  void wait_any(std::span<const Heard> heard, const hal::SeenWord& own, hal::Time deadline) const;

  const std::string& robot() const { return robot_; }
  int pid() const { return pid_; }

 private:
  hal::Result<std::string> ask(std::string_view name, std::string_view arguments, const hal::SharedMemory* memory);
  hal::Result<std::unique_ptr<hal::SharedMemory>> memory(std::string_view request);
  const hal::WakeWord* bell_word(std::uint32_t topic) const;

  std::unique_ptr<hal::Stream> stream_;
  FrameReader frames_{kMaxReplyBytes};
  std::unique_ptr<hal::SharedMemory> topics_, doorbells_;
  std::optional<SegmentReader> reader_;
  std::string robot_;
  int pid_ = 0;
};

}  // namespace sinew::tap
