#pragma once
// System calls beyond POSIX for the POSIX files of this room (posix.txt). A port to a BSD rewrites these functions, and
// none of those files; docs/bsd.md.
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <string>

#include "hal/connectors.hpp"
#include "hal/stream.hpp"

struct sockaddr;

namespace sinew::hal::beyond_posix {

// ---- sockets

/// Ends a TCP connection whose peer's machine or network is gone after `silence`, whether we write or only listen; as
/// far as the system can.
void give_up_on_a_silent_peer(int socket, Duration silence) noexcept;

/// The process at the other end of a Unix socket. Errors: not_supported.
Result<Peer> peer_of(int socket) noexcept;

/// bind() to a Unix socket's path; no other user can connect to the file, not even for a moment. Sets errno.
bool bind_for_its_owner(int socket, const sockaddr* address, unsigned bytes) noexcept;

// ---- serial lines

/// No echo, no flow control, no translation; an empty read differs from a lost line. Errors: io.
Status make_raw(int line, const SerialSpec& spec) noexcept;

/// Any rate that the driver reaches within 3 %; a UART still reads that.
/// Errors:  not_supported, with the driver's rate in detail; closed when the line is gone; io.
Status set_bit_rate(int line, std::uint32_t bits_per_s) noexcept;
/// How long a USB adapter holds bytes back, set to its least, 1 ms. Empty: it is, or the line has no such adapter; else
/// what to do, for people.
std::string set_latency_timer(int line, const SerialSpec& spec);

// ---- locks of a file

/// Locks the open file, not for the process: two locks of one process also exclude each other, and closing another
/// descriptor of the file does not unlock it. False: another holder has it (errno EAGAIN or EACCES), or it failed.
bool lock_file(int file) noexcept;
bool is_locked_by_another(int file) noexcept;

// ---- processes

/// Call in a child between fork and exec: the child gets this signal when its parent dies. Safe there.
void end_with_parent(int signal) noexcept;

/// A descriptor that is readable once this child has ended; programs that are started do not inherit it. -1: not on
/// this system.
int end_of_child(int pid) noexcept;

/// Number of threads of this process. 0: the system does not say.
std::size_t threads() noexcept;

/// Bytes of this process in memory now. 0: the system does not say.
std::uint64_t resident_bytes() noexcept;

/// Opens the target of `file` once more, with flags of its own (O_NONBLOCK). -1: not on this system.
int open_again(int file, int flags) noexcept;

}  // namespace sinew::hal::beyond_posix
