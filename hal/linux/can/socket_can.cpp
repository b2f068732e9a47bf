#include "hal/linux/can/socket_can.hpp"

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/errqueue.h>
#include <linux/net_tstamp.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "hal/linux/can/can_error.hpp"
#include "hal/linux/can/can_stamp.hpp"
#include "hal/linux/realtime_stamps.hpp"
#include "wire/can_check.hpp"

namespace sinew::hal {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kCanBatch = 16;
constexpr int kCanReceiveBytes = 1 << 20, kCanSendBytes = 16 << 10;  // the kernel doubles both

bool gone(int error) { return error == ENETDOWN || error == ENODEV || error == ENXIO || error == ENETUNREACH; }

template <class T>
Status set_option(int fd, int level, int name, const T& value, const char* where) {
  if (setsockopt(fd, level, name, &value, sizeof value) == 0) return {};
  return Error{Errc::io, where, errno};
}

void from_kernel(const canfd_frame& in, bool fd, msg::CanFrame& out) {
  const bool error = (in.can_id & CAN_ERR_FLAG) != 0, extended = (in.can_id & CAN_EFF_FLAG) != 0 && !error;
  out.id = in.can_id & (error || extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  out.flags = (extended ? msg::kCanExtended : 0u) | (error ? msg::kCanError : 0u) |
              ((in.can_id & CAN_RTR_FLAG) != 0 && !error ? msg::kCanRemote : 0u) | (fd ? msg::kCanFd : 0u) |
              (fd && (in.flags & CANFD_BRS) != 0 ? msg::kCanBitRateSwitch : 0u);
  out.size = in.len;
  out.data.fill(0);
  std::copy_n(in.data, std::min<std::size_t>(in.len, fd ? CANFD_MAX_DLEN : CAN_MAX_DLEN), out.data.begin());
}

canfd_frame to_kernel(const msg::CanFrame& frame) {
  canfd_frame out{};
  out.can_id = frame.id | (frame.extended() ? CAN_EFF_FLAG : 0u) | (frame.remote() ? CAN_RTR_FLAG : 0u);
  out.len = static_cast<__u8>(frame.size);
  if (frame.fd() && (frame.flags & msg::kCanBitRateSwitch) != 0) out.flags = CANFD_BRS;
  std::copy_n(frame.data.begin(), frame.size, out.data);
  return out;
}

}  // namespace

/// The memory that one recvmmsg() fills, made once.
struct SocketCanBus::Batch {
  explicit Batch(Time now) : realtime(now) {
    for (std::size_t i = 0; i < kCanBatch; ++i) {
      parts[i] = {&frames[i], sizeof frames[i]};
      heads[i].msg_hdr.msg_iov = &parts[i];
      heads[i].msg_hdr.msg_iovlen = 1;
    }
  }
  alignas(cmsghdr) std::array<std::array<std::byte, 128>, kCanBatch> control{};
  std::array<canfd_frame, kCanBatch> frames{};
  std::array<iovec, kCanBatch> parts{};
  std::array<mmsghdr, kCanBatch> heads{};
  std::size_t next = 0, count = 0;
  Time read_at;
  RealtimeStamps realtime;
  HardwareStamps hardware;
};

SocketCanBus::SocketCanBus(const CanSpec& spec, Os& os, std::shared_ptr<FdWatch> watch)
    : CanPort(spec, os, std::move(watch)) {}

Result<std::unique_ptr<CanBus>> SocketCanBus::open(const CanSpec& spec, Os& os, std::shared_ptr<FdWatch> watch,
                                                   std::string& why) {
  why.clear();
  std::unique_ptr<SocketCanBus> bus(new SocketCanBus(spec, os, std::move(watch)));
  if (const Status opened = bus->open_socket(why); !opened) return opened.error();
  ThreadOptions options;
  options.name = spec.address + " keeper";
  auto keeper = os.start_thread(options, [b = bus.get()] { b->keep(); });
  if (!keeper) return keeper.error();
  bus->keeper_ = std::move(*keeper);
  return std::unique_ptr<CanBus>(std::move(bus));
}

SocketCanBus::~SocketCanBus() {
  stop_.store(true, std::memory_order_release);
  keeper_word_.fetch_add(1, std::memory_order_release);
  os_.wake(keeper_word_);
  keeper_.reset();
  if (fd_ < 0) return;
  watch_->remove(fd_);
  close(fd_);
}

Status SocketCanBus::open_socket(std::string& why) {
  const std::string& name = spec_.address;
  fd_ = socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
  if (fd_ < 0) {
    const int error = errno;
    if (error == EAFNOSUPPORT || error == EPROTONOSUPPORT) {
      why = name +
            ": this kernel has no CAN (PF_CAN): load it with 'modprobe can-raw', or use the transport \"udp\" or "
            "\"socketcand\", which need none";
      return Error{Errc::not_supported, "PF_CAN", error};
    }
    why = name + ": no CAN socket: " + std::strerror(error);
    if (error == EPERM || error == EACCES)
      why +=
          "; a sandbox keeps it from us: of systemd (RestrictAddressFamilies= has to list AF_CAN), a container's "
          "seccomp profile, or SELinux";
    return Error{error == EPERM || error == EACCES ? Errc::denied : Errc::io, "PF_CAN", error};
  }
  const auto link = read_can_link(name);
  if (!link) {
    why = name + (link.error().code == Errc::not_found
                      ? ": there is no such interface ('ip link' lists them); a virtual one: 'ip link add dev " + name +
                            " type vcan'"
                  : link.error().code == Errc::bad_argument
                      ? ": is no CAN interface"
                      : ": cannot be looked at: " + std::string(std::strerror(static_cast<int>(link.error().detail))));
    return link.error();
  }
  batch_ = std::make_unique<Batch>(os_.now());
  if (const Status set = set_options(*link, why); !set) return set;
  if (const Status bound = bind_to(link->index); !bound) {
    why = name + ": cannot be opened: " + std::strerror(static_cast<int>(bound.error().detail));
    return bound;
  }
  if (const Status watched = watch_->add(fd_, line_); !watched) return watched;
  std::string trouble;
  follow_controller(*link, counters_.error_frames(), trouble);
  if (!link->up) lost_.store(true, std::memory_order_release);
  if (link->kind == "can" && link->bit_rate != 0 && link->bit_rate != spec_.bit_rate)
    trouble = name + ": runs at " + std::to_string(link->bit_rate) + " bit/s, and the robot file says " +
              std::to_string(spec_.bit_rate) + (trouble.empty() ? "" : "; " + trouble);
  why = trouble;
  const std::lock_guard lock(mutex_);
  trouble_ = trouble;
  return {};
}

Status SocketCanBus::set_options(const CanLink& link, std::string& why) {
  const int on = 1;
  if (spec_.data_bit_rate > 0) {
    if (!link.fd) {
      why = spec_.address + ": CAN FD is asked for, and the interface does not carry it: 'ip link set " +
            spec_.address +
            (link.kind == "can" ? " type can fd on dbitrate " + std::to_string(spec_.data_bit_rate) : " mtu 72") + "'";
      return Error{Errc::not_supported, "CAN FD"};
    }
    if (const Status s = set_option(fd_, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, on, "CAN_RAW_FD_FRAMES"); !s) return s;
  }
  const can_err_mask_t errors = CAN_ERR_MASK;
  const int own = spec_.receive_own ? 1 : 0;
  if (const Status s = set_option(fd_, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, errors, "CAN_RAW_ERR_FILTER"); !s) return s;
  if (const Status s = set_option(fd_, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, own, "CAN_RAW_RECV_OWN_MSGS"); !s) return s;
  if (const Status s = set_option(fd_, SOL_SOCKET, SO_RXQ_OVFL, on, "SO_RXQ_OVFL"); !s) return s;
  const int stamps = SOF_TIMESTAMPING_RX_SOFTWARE | SOF_TIMESTAMPING_SOFTWARE | SOF_TIMESTAMPING_RX_HARDWARE |
                     SOF_TIMESTAMPING_RAW_HARDWARE;
  if (const Status s = set_option(fd_, SOL_SOCKET, SO_TIMESTAMPING, stamps, "SO_TIMESTAMPING"); !s) return s;
  // A large receive queue, beyond net.core.rmem_max where permitted; a short send queue, so that no frame grows old
  // there.
  const int in = kCanReceiveBytes, out = kCanSendBytes;
  if (setsockopt(fd_, SOL_SOCKET, SO_RCVBUFFORCE, &in, sizeof in) != 0)
    if (const Status s = set_option(fd_, SOL_SOCKET, SO_RCVBUF, in, "SO_RCVBUF"); !s) return s;
  return set_option(fd_, SOL_SOCKET, SO_SNDBUF, out, "SO_SNDBUF");
}

Status SocketCanBus::bind_to(int index) {
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = index;
  if (bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return Error{errno == ENODEV ? Errc::not_found : Errc::io, "bind", errno};
  bound_.store(index, std::memory_order_relaxed);
  return {};
}

Status SocketCanBus::set_filters(std::span<const CanFilter> filters) {
  const std::lock_guard lock(mutex_);
  std::vector<CanFilter> before(filters.begin(), filters.end());
  filters_.swap(before);
  Status set = apply_filters();
  if (!set) filters_.swap(before);
  return set;
}

Status SocketCanBus::apply_filters() {
  if (filters_.size() > CAN_RAW_FILTER_MAX)
    return Error{Errc::not_supported, "more filters than the kernel takes", CAN_RAW_FILTER_MAX};
  std::vector<can_filter> raw;
  for (const CanFilter& f : filters_)
    raw.push_back({f.id | (f.extended ? CAN_EFF_FLAG : 0u), (f.mask & CAN_EFF_MASK) | CAN_EFF_FLAG});
  if (raw.empty()) raw.push_back({0, 0});  // everything; an empty list would receive nothing
  if (setsockopt(fd_, SOL_CAN_RAW, CAN_RAW_FILTER, raw.data(), static_cast<socklen_t>(raw.size() * sizeof raw[0])) != 0)
    return Error{Errc::io, "CAN_RAW_FILTER", errno};
  return {};
}

Result<bool> SocketCanBus::read(msg::CanFrame& out) noexcept {
  for (;;) {
    if (batch_->next == batch_->count) {
      const auto filled = fill();
      if (!filled || !*filled) return filled;
    }
    if (take(batch_->next++, out)) return true;
  }
}

Result<bool> SocketCanBus::fill() noexcept {
  Batch& b = *batch_;
  b.next = b.count = 0;
  for (std::size_t i = 0; i < kCanBatch; ++i) {
    b.heads[i].msg_hdr.msg_control = b.control[i].data();
    b.heads[i].msg_hdr.msg_controllen = b.control[i].size();
  }
  const Time asked = os_.now();
  const int n = recvmmsg(fd_, b.heads.data(), kCanBatch, MSG_DONTWAIT, nullptr);
  if (n > 0) {
    b.count = static_cast<std::size_t>(n);
    const ClockReading clocks = read_clocks(os_);
    b.read_at = clocks.before;
    b.realtime.begin(clocks);
    return true;
  }
  if (n < 0 && errno == EINTR) return false;
  if (n < 0 && errno != EAGAIN) {
    const int error = errno;
    if (!gone(error)) return Error{Errc::io, "recvmmsg", error};
    lose();
    return Error{Errc::closed, "interface", error};
  }
  b.realtime.begin(read_clocks(os_));
  b.realtime.drained(asked);
  if (lost_.load(std::memory_order_acquire)) return Error{Errc::closed, "interface"};
  return false;
}

bool SocketCanBus::take(std::size_t i, msg::CanFrame& out) noexcept {
  const Batch& b = *batch_;
  const std::size_t size = b.heads[i].msg_len;
  const Time stamp = stamp_of(i);
  if (size != CAN_MTU && size != CANFD_MTU) {
    counters_.malformed();
    return false;
  }
  from_kernel(b.frames[i], size == CANFD_MTU, out);
  out.stamp = stamp;
  if (out.error()) {
    count_error_frame(out, counters_);
    if (counters_.state() == CanState::bus_off) {  // the keeper brings it back
      keeper_word_.fetch_add(1, std::memory_order_release);
      os_.wake(keeper_word_);
    }
    return true;
  }
  if (!wire::is_can_frame(out)) {
    counters_.malformed();
    return false;
  }
  counters_.received(out);
  return true;
}

Time SocketCanBus::stamp_of(std::size_t i) noexcept {
  Batch& b = *batch_;
  msghdr& head = b.heads[i].msg_hdr;
  Time kernel = b.read_at;
  std::int64_t hardware = 0;
  for (cmsghdr* c = CMSG_FIRSTHDR(&head); c != nullptr; c = CMSG_NXTHDR(&head, c)) {
    if (c->cmsg_level != SOL_SOCKET) continue;
    if (c->cmsg_type == SO_RXQ_OVFL) {
      std::uint32_t seen = 0;
      std::memcpy(&seen, CMSG_DATA(c), sizeof seen);
      counters_.rx_lost(seen - overflow_);
      overflow_ = seen;
    } else if (c->cmsg_type == SO_TIMESTAMPING) {
      timespec stamps[3]{};  // software, (unused), hardware: struct scm_timestamping
      std::memcpy(stamps, CMSG_DATA(c), sizeof stamps);
      if (ns_of(stamps[0]) != 0) kernel = b.realtime.convert(ns_of(stamps[0]));
      hardware = ns_of(stamps[2]);
    }
  }
  return hardware != 0 ? b.hardware.convert(hardware, kernel) : kernel;
}

Status SocketCanBus::send(const msg::CanFrame& frame, Time deadline) noexcept {
  if (const Status may = may_leave(frame, deadline); !may) return may;
  if (counters_.state() == CanState::bus_off) return lost(Errc::closed, "bus-off");
  const canfd_frame raw = to_kernel(frame);
  const ssize_t n = ::send(fd_, &raw, frame.fd() ? CANFD_MTU : CAN_MTU, MSG_DONTWAIT);
  if (n > 0) {
    counters_.sent(frame);
    return Status{};
  }
  const int error = errno;
  if (error == EAGAIN || error == ENOBUFS || error == EINTR) return lost(Errc::timeout, "no room", error);
  if (!gone(error)) return lost(Errc::io, "send", error);
  lose();
  return lost(Errc::closed, "interface", error);
}

}  // namespace sinew::hal
