#pragma once
// One client of the server. Inside of the room only.
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "hal/linux/socket.hpp"
#include "tap/frames.hpp"
#include "tap/request.hpp"

namespace sinew::tap {

inline constexpr std::size_t kShortReplyBytes = 128 * 1024;  // shorter replies are never refused

/// The share of the server that one client may use.
struct Allowance {
  std::uint32_t requests_per_s = 200;
  hal::Duration patience{};
};

/// Reads one request, answers it, writes the reply, and only then reads on: a client that does not take its replies is
/// not read. No call here waits.
/// Thread:  the server's.
class Connection {
 public:
  enum class End : std::uint8_t { open, gone, garbage, slow, out_of_memory };

  Connection(std::uint64_t id, std::unique_ptr<hal::Stream> stream, int pid, const Allowance& allowance, hal::Time now);

  /// What it waits for: nothing (-1), room to write, or something to read.
  hal::Waiting waiting(hal::Time now);
  /// Reads what is there, as far as one request. A complete one, or nothing. The text is valid until reply().
  std::optional<std::string_view> read(hal::Time now);
  /// False: the reply is longer than `room` bytes, and `busy` is answered instead.
  bool reply(const Reply& reply, std::size_t room, hal::Time now);
  void settle(const Json& json, hal::Time now);
  void write();
  /// Ends the connection when its time for a whole request, a whole reply or a change is over.
  void look_at_time(hal::Time now);
  /// After a failure midway: nothing more is sent.
  void give_up() { end_ = End::out_of_memory; }

  std::uint64_t id() const { return id_; }
  /// For the memory that came with a request.
  hal::Stream& stream() { return *stream_; }
  int pid() const { return pid_; }
  End end() const { return end_; }
  bool waits_for_change() const { return change_.has_value(); }
  const Change& change() const { return *change_; }
  bool change_is_late(hal::Time now) const { return now - since_ > allowance_.patience; }
  bool throttled() const { return tokens_ < 1; }
  /// Bytes of the reply that the client is taking.
  std::size_t held() const { return out_.size(); }
  hal::Time last_request() const { return last_request_; }

 private:
  void send(const std::string& text, const hal::SharedMemory* memory, hal::Time now);

  const std::uint64_t id_;
  std::unique_ptr<hal::Stream> stream_;
  const int pid_;
  const Allowance allowance_;
  FrameReader frames_{kMaxRequestBytes};
  std::string out_;  // head and frame of the reply
  std::size_t sent_ = 0;
  const hal::SharedMemory* memory_ = nullptr;  // goes with the first bytes of out_
  std::optional<Change> change_;
  hal::Time since_;  // begin of the half request, the reply or the change under way
  bool half_ = false;
  double tokens_;
  hal::Time refilled_, last_request_;
  unsigned strikes_ = 0;
  End end_ = End::open;
};

}  // namespace sinew::tap
