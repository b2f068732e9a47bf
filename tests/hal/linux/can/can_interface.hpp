#pragma once
// Virtual CAN interfaces of a test: made, taken down, removed. Needs CAP_NET_ADMIN; for the VM bench.
#include <linux/can.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <vector>

namespace sinew::hal {

class VirtualCan {
 public:
  /// Removes an interface of the same name first.
  explicit VirtualCan(std::string name) : name_(std::move(name)) {
    remove();
    error_ = ask(RTM_NEWLINK, NLM_F_CREATE | NLM_F_EXCL, true);
  }
  ~VirtualCan() { remove(); }
  const std::string& name() const { return name_; }
  /// errno of the last failure; 0: none.
  int error() const { return error_; }
  bool create() { return (error_ = ask(RTM_NEWLINK, NLM_F_CREATE | NLM_F_EXCL, true)) == 0; }
  bool remove() { return ask(RTM_DELLINK, 0, false) == 0; }
  bool up(bool on) {
    ifreq request = named();
    if (ioctl(socket_, SIOCGIFFLAGS, &request) != 0) return false;
    request.ifr_flags = static_cast<short>(on ? request.ifr_flags | IFF_UP : request.ifr_flags & ~IFF_UP);
    return ioctl(socket_, SIOCSIFFLAGS, &request) == 0;
  }
  bool mtu(int bytes) {
    ifreq request = named();
    request.ifr_mtu = bytes;
    return ioctl(socket_, SIOCSIFMTU, &request) == 0;
  }

 private:
  ifreq named() const {
    ifreq request{};
    std::strncpy(request.ifr_name, name_.c_str(), IFNAMSIZ - 1);
    return request;
  }
  int ask(unsigned short what, unsigned short flags, bool with_kind) const {
    struct Message {
      nlmsghdr head{};
      ifinfomsg info{};
      char attributes[128]{};
    } m;
    std::size_t used = 0;
    const auto put = [&](unsigned short type, const void* data, std::size_t size) {
      rtattr head{};
      head.rta_type = type, head.rta_len = static_cast<unsigned short>(RTA_LENGTH(size));
      std::memcpy(m.attributes + used, &head, sizeof head);
      std::memcpy(m.attributes + used + sizeof head, data, size);
      used += RTA_ALIGN(head.rta_len);
    };
    put(IFLA_IFNAME, name_.c_str(), name_.size() + 1);
    if (with_kind) {
      struct {
        rtattr head{8, IFLA_INFO_KIND};
        char kind[4] = {'v', 'c', 'a', 'n'};
      } info;
      put(IFLA_LINKINFO, &info, sizeof info);
    }
    m.head.nlmsg_type = what, m.head.nlmsg_flags = static_cast<unsigned short>(NLM_F_REQUEST | NLM_F_ACK | flags);
    m.head.nlmsg_len = static_cast<unsigned>(sizeof m.head + sizeof m.info + used);
    const int fd = socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
    char answer[512]{};
    ssize_t n = send(fd, &m, m.head.nlmsg_len, 0);
    if (n > 0) n = recv(fd, answer, sizeof answer, 0);
    close(fd);
    nlmsgerr error{};
    if (n < static_cast<ssize_t>(sizeof(nlmsghdr) + sizeof error)) return EIO;
    std::memcpy(&error, answer + sizeof(nlmsghdr), sizeof error);
    return -error.error;
  }

  std::string name_;
  int socket_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  int error_ = 0;
};

/// A raw socket that sends anything, also error frames.
class RawCan {
 public:
  explicit RawCan(const std::string& interface) {
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(if_nametoindex(interface.c_str()));
    good_ =
        fd_ >= 0 && address.can_ifindex != 0 && bind(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  }
  ~RawCan() {
    if (fd_ >= 0) close(fd_);
  }
  bool good() const { return good_; }
  bool put(std::uint32_t id_and_flags, const std::vector<std::uint8_t>& data) {
    can_frame frame{};
    frame.can_id = id_and_flags;
    frame.can_dlc = static_cast<__u8>(data.size());
    std::copy(data.begin(), data.end(), frame.data);
    while (write(fd_, &frame, sizeof frame) < 0)
      if (errno != ENOBUFS && errno != EINTR) return false;
    return true;
  }

 private:
  int fd_ = socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, 1 /* CAN_RAW */);
  bool good_ = false;
};

}  // namespace sinew::hal
