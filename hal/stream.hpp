#pragma once
// A two-way byte stream to another process on this or another machine. hal/linux: Unix sockets and TCP.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "hal/clock.hpp"
#include "hal/os.hpp"
#include "hal/result.hpp"

namespace sinew::hal {

/// The process at the other end, as the kernel knows it: the peer cannot forge this.
struct Peer {
  int pid = 0;  // at the connection; may have ended since
  std::uint32_t user = 0;
};

/// One end of a connection. One thread may read while another writes.
/// Errors:  closed when the peer is gone (each call says so again); io with errno in detail.
class Stream {
 public:
  virtual ~Stream() = default;
  /// Waits for at least one byte, as long as set_patience() allows. Errors: closed, timeout, io.
  virtual Result<std::size_t> read(std::span<std::byte> into) noexcept = 0;
  /// Reads what is there already; 0: nothing (normal). RT: yes.
  virtual Result<std::size_t> read_now(std::span<std::byte> into) noexcept = 0;
  /// Writes `head` and then `tail` completely, in one system call when the peer keeps up. Errors: closed, timeout, io.
  virtual Status write(std::span<const std::byte> head, std::span<const std::byte> tail = {}) noexcept = 0;
  /// Writes as much as fits without waiting; says how much. RT: yes.
  virtual Result<std::size_t> write_now(std::span<const std::byte> bytes) noexcept = 0;
  /// How long read() and write() may wait without any progress; zero: for ever. Before the traffic starts.
  virtual void set_patience(Duration patience) noexcept = 0;
  /// From now on one thread reads while others write: a read costs one system call more, but the reader is no longer
  /// woken whenever the peer has taken written bytes.
  virtual void split() noexcept {}
  /// True when the peer runs on this machine and memory can be handed to it.
  virtual bool local() const noexcept = 0;
  /// Like write(), and hands the memory to the peer with these bytes. Errors: not_supported when not local.
  virtual Status write_with_memory(std::span<const std::byte> bytes, const SharedMemory& memory) noexcept = 0;
  /// The memory that came with the bytes read so far: mapped read-only, or only for copying, which costs a system call
  /// per copy and keeps its pages out of this process.
  /// Errors:  not_found when none came; bad_data when its owner could still shrink it under us.
  enum class MemoryAccess : std::uint8_t { mapped, copied };
  virtual Result<std::unique_ptr<SharedMemory>> take_memory(MemoryAccess access) = 0;
  /// Handles are kept until the first take_memory() and dropped afterwards; after this call one more is kept.
  virtual void expect_memory() noexcept {}
  /// The process at the other end. Errors: not_supported when not local.
  virtual Result<Peer> peer() const noexcept { return Error{Errc::not_supported, "peer of this connection"}; }
  /// For waiting on several streams at once; negative: cannot.
  virtual std::intptr_t handle() const noexcept { return -1; }
  /// Ends both directions; a thread that waits in read() returns. Thread: any.
  virtual void shutdown() noexcept = 0;
};

/// Waits for peers.
class Listener {
 public:
  virtual ~Listener() = default;
  /// Errors:  timeout, io.
  virtual Result<std::unique_ptr<Stream>> accept(Duration patience) = 0;
  /// The address of the listener, in the form that connect takes; with the port that the system chose.
  virtual const std::string& endpoint() const = 0;
  /// For waiting on the listener beside streams; negative: cannot.
  virtual std::intptr_t handle() const noexcept { return -1; }
};

}  // namespace sinew::hal
