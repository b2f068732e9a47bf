#include "hal/linux/can/can_link.hpp"

#include <linux/can.h>
#include <linux/can/netlink.h>
#include <linux/if.h>
#include <linux/if_arp.h>
#include <linux/if_link.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

namespace sinew::hal {
namespace {

using Bytes = std::span<const std::byte>;

/// Copies a struct of the kernel from bytes of any alignment.
template <class T>
bool take(Bytes bytes, T& out) {
  if (bytes.size() < sizeof(T)) return false;
  std::memcpy(&out, bytes.data(), sizeof(T));
  return true;
}

/// Calls each(type, payload) for the attributes in `bytes`; false: they are broken.
template <class Each>
bool each_attribute(Bytes bytes, Each each) {
  while (bytes.size() >= sizeof(rtattr)) {
    rtattr head{};
    if (!take(bytes, head) || head.rta_len < sizeof(rtattr) || head.rta_len > bytes.size()) return false;
    each(head.rta_type & NLA_TYPE_MASK, bytes.subspan(sizeof(rtattr), head.rta_len - sizeof(rtattr)));
    bytes = bytes.subspan(std::min<std::size_t>(RTA_ALIGN(head.rta_len), bytes.size()));
  }
  return true;
}

CanState state_of(std::uint32_t state) {
  switch (state) {
    case CAN_STATE_ERROR_WARNING:
      return CanState::warning;
    case CAN_STATE_ERROR_PASSIVE:
      return CanState::passive;
    case CAN_STATE_BUS_OFF:
      return CanState::bus_off;
    case CAN_STATE_STOPPED:
    case CAN_STATE_SLEEPING:
      return CanState::stopped;
    default:
      return CanState::active;
  }
}

void take_can_attribute(int type, Bytes payload, CanLink& link) {
  std::uint32_t number = 0;
  can_bittiming timing{};
  can_berr_counter errors{};
  switch (type) {
    case IFLA_CAN_STATE:
      if (take(payload, number)) link.state = state_of(number);
      break;
    case IFLA_CAN_RESTART_MS:
      if (take(payload, number)) link.restart_ms = number;
      break;
    case IFLA_CAN_BITTIMING:
      if (take(payload, timing)) link.bit_rate = timing.bitrate;
      break;
    case IFLA_CAN_DATA_BITTIMING:
      if (take(payload, timing)) link.data_bit_rate = timing.bitrate;
      break;
    case IFLA_CAN_BERR_COUNTER:
      if (take(payload, errors)) {
        link.tx_errors = static_cast<std::uint8_t>(std::min<int>(errors.txerr, 255));
        link.rx_errors = static_cast<std::uint8_t>(std::min<int>(errors.rxerr, 255));
      }
      break;
    default:
      break;
  }
}

bool take_link_info(Bytes info, CanLink& link) {
  Bytes data;
  const bool whole = each_attribute(info, [&](int type, Bytes payload) {
    if (type == IFLA_INFO_KIND) {
      const char* text = reinterpret_cast<const char*>(payload.data());
      link.kind.assign(text, strnlen(text, payload.size()));
    }
    if (type == IFLA_INFO_DATA) data = payload;
  });
  if (link.kind != "can") return whole;
  return each_attribute(data, [&](int type, Bytes payload) { take_can_attribute(type, payload, link); }) && whole;
}

Error refused_link(int error, const char* where) {
  if (error == ENODEV) return {Errc::not_found, where, error};
  if (error == EPERM || error == EACCES) return {Errc::denied, where, error};
  if (error == EBUSY || error == EINVAL) return {Errc::busy, where, error};
  return {Errc::io, where, error};
}

struct Request {
  nlmsghdr head{};
  ifinfomsg info{};
  std::array<std::byte, 64> attributes{};
};

/// A rtattr with its payload behind `used` bytes of them; returns where the next one goes.
std::size_t put_attribute(Request& request, std::size_t used, int type, Bytes payload) {
  rtattr head{};
  head.rta_type = static_cast<unsigned short>(type);
  head.rta_len = static_cast<unsigned short>(RTA_LENGTH(payload.size()));
  std::memcpy(&request.attributes[used], &head, sizeof head);
  if (!payload.empty()) std::memcpy(&request.attributes[used + sizeof head], payload.data(), payload.size());
  return used + RTA_ALIGN(head.rta_len);
}

/// Sends `request` and reads one answer into `answer`; its bytes.
Result<Bytes> ask(const Request& request, std::span<std::byte> answer) {
  const int fd = socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
  if (fd < 0) return Error{Errc::io, "netlink socket", errno};
  const timeval patience{1, 0};  // the kernel answers in the call itself; the time-out is only a safeguard
  setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  ssize_t n = send(fd, &request, request.head.nlmsg_len, 0);
  if (n >= 0) n = recv(fd, answer.data(), answer.size(), 0);
  const int why = errno;
  close(fd);
  if (n < 0) return Error{Errc::io, "netlink", why};
  return Bytes(answer.data(), static_cast<std::size_t>(n));
}

/// The errno of an error message, 0 for an acknowledgement; nothing when it is neither.
bool is_error(Bytes answer, int& error) {
  nlmsghdr head{};
  nlmsgerr body{};
  if (!take(answer, head) || head.nlmsg_type != NLMSG_ERROR) return false;
  error = take(answer.subspan(sizeof head), body) ? -body.error : EBADMSG;
  return true;
}

}  // namespace

Result<CanLink> parse_can_link(Bytes answer) {
  int error = 0;
  if (is_error(answer, error)) return refused_link(error, "interface");
  nlmsghdr head{};
  ifinfomsg info{};
  if (!take(answer, head) || head.nlmsg_len > answer.size() || head.nlmsg_type != RTM_NEWLINK ||
      head.nlmsg_len < NLMSG_HDRLEN || !take(answer.subspan(NLMSG_HDRLEN), info))
    return Error{Errc::bad_data, "netlink answer"};
  if (info.ifi_type != ARPHRD_CAN) return Error{Errc::bad_argument, "no CAN interface", info.ifi_type};
  CanLink link;
  link.index = info.ifi_index;
  link.up = (info.ifi_flags & IFF_UP) != 0;
  bool whole = head.nlmsg_len >= NLMSG_LENGTH(sizeof info);
  if (whole) {
    bool inner = true;
    whole =
        each_attribute(answer.first(head.nlmsg_len).subspan(NLMSG_LENGTH(sizeof info)), [&](int type, Bytes payload) {
          std::uint32_t mtu = 0;
          if (type == IFLA_MTU && take(payload, mtu)) link.fd = mtu >= CANFD_MTU;
          if (type == IFLA_LINKINFO) inner = take_link_info(payload, link);
        });
    whole = whole && inner;
  }
  if (!whole) return Error{Errc::bad_data, "netlink attributes"};
  if (!link.up) link.state = CanState::stopped;
  return link;
}

Result<CanLink> read_can_link(const std::string& name) {
  if (name.empty() || name.size() >= IFNAMSIZ) return Error{Errc::bad_argument, "name of an interface"};
  Request request;
  request.head.nlmsg_type = RTM_GETLINK;
  request.head.nlmsg_flags = NLM_F_REQUEST;
  request.info.ifi_family = AF_UNSPEC;
  const std::size_t used =
      put_attribute(request, 0, IFLA_IFNAME, std::as_bytes(std::span(name.c_str(), name.size() + 1)));
  request.head.nlmsg_len = static_cast<std::uint32_t>(offsetof(Request, attributes) + used);
  alignas(nlmsghdr) std::array<std::byte, 16384> answer{};
  const auto got = ask(request, answer);
  if (!got) return got.error();
  return parse_can_link(*got);
}

Status restart_can(int index) {
  Request request;
  request.head.nlmsg_type = RTM_NEWLINK;
  request.head.nlmsg_flags = NLM_F_REQUEST | NLM_F_ACK;
  request.info.ifi_family = AF_UNSPEC;
  request.info.ifi_index = index;
  const std::uint32_t one = 1;
  // LINKINFO { KIND "can", DATA { RESTART 1 } }, from the inside out.
  Request data, info;
  const std::size_t data_size = put_attribute(data, 0, IFLA_CAN_RESTART, std::as_bytes(std::span(&one, 1)));
  std::size_t info_size = put_attribute(info, 0, IFLA_INFO_KIND, std::as_bytes(std::span("can", 3)));
  info_size = put_attribute(info, info_size, IFLA_INFO_DATA, std::span(data.attributes).first(data_size));
  const std::size_t used = put_attribute(request, 0, IFLA_LINKINFO, std::span(info.attributes).first(info_size));
  request.head.nlmsg_len = static_cast<std::uint32_t>(offsetof(Request, attributes) + used);
  alignas(nlmsghdr) std::array<std::byte, 1024> answer{};
  const auto got = ask(request, answer);
  if (!got) return got.error();
  int error = 0;
  if (!is_error(*got, error)) return Error{Errc::bad_data, "netlink answer"};
  if (error != 0) return refused_link(error, "restart");
  return {};
}

}  // namespace sinew::hal
