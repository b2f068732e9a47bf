#pragma once
// What the POSIX files of this room (posix.txt) need of the system and POSIX does not have. Whoever ports to a BSD
// writes these again, and none of those files; docs/bsd.md.
#include <sys/types.h>

#include <cstddef>
#include <cstdint>

#include "hal/connectors.hpp"
#include "hal/stream.hpp"

struct sockaddr;

namespace sinew::hal::beyond_posix {

// ---- sockets

/// A TCP peer whose machine or network is gone is noticed after `silence`, whether we write or only listen; as far as
/// the system can.
void give_up_on_a_silent_peer(int socket, Duration silence) noexcept;

/// The process at the other end of a Unix socket. Errors: not_supported.
Result<Peer> peer_of(int socket) noexcept;

/// bind() to a Unix socket's path, with a file that nobody else can connect to, not even for a moment. Sets errno.
bool bind_for_its_owner(int socket, const sockaddr* address, unsigned bytes) noexcept;

// ---- serial lines

/// No echo, no flow control, no translation; a read of nothing and a line that is gone differ. Errors: io.
Status make_raw(int line, const SerialSpec& spec) noexcept;

/// Any rate that the driver can do within 3 %, which is what a UART still reads.
/// Errors:  not_supported, with the rate that it does in detail; closed when the line is gone; io.
Status set_bit_rate(int line, std::uint32_t bits_per_s) noexcept;

// ---- locks of a file

/// Of the open file, not of the process: also two of one process exclude each other, and closing another descriptor of
/// the file does not let go. False: somebody has it (errno EAGAIN or EACCES), or it failed.
bool lock_file(int file) noexcept;
bool is_locked_by_another(int file) noexcept;

// ---- processes

/// In a child, between fork and exec: it gets SIGTERM when its parent dies. Safe there.
void end_with_parent() noexcept;

/// Of this process. 0: the system does not tell.
std::size_t threads() noexcept;

/// Memory of this process that is there now. 0: the system does not tell.
std::uint64_t resident_bytes() noexcept;

/// What `file` is, opened once more, so that its flags (O_NONBLOCK) are not those of others. -1: not on this system.
int open_again(int file, int flags) noexcept;

}  // namespace sinew::hal::beyond_posix
