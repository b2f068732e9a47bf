#include "net/local_link.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "hal/linux/devices/net_radio.hpp"
#include "wire/net_link.hpp"

namespace sinew::net {
namespace {

using wire::NetLinkKind;

constexpr int kAtATime = 64;  // packets of a client, before others have their turn

bool send_packet(int fd, const wire::NetLinkPacket& packet, std::span<std::uint8_t> room) {
  const std::size_t size = wire::write_net_link(packet, room);
  return size > 0 && send(fd, room.data(), size, MSG_DONTWAIT | MSG_NOSIGNAL) == static_cast<ssize_t>(size);
}

std::span<const std::uint8_t> bytes_of(const std::string& text, std::size_t most) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), std::min(text.size(), most)};
}

}  // namespace

hal::Result<std::unique_ptr<LocalLink>> LocalLink::open(const std::string& robot, std::string& why) {
  const auto path = hal::net_socket_path(robot, why);
  if (!path) return path.error();
  std::unique_ptr<LocalLink> link(new LocalLink());
  link->path_ = *path;
  auto lock = hal::FileLock::take(*path + "-lock");
  if (!lock) {
    why = lock.error().code == hal::Errc::busy ? "a program for the robot '" + robot + "' runs already, as process " +
                                                     std::to_string(lock.error().detail)
                                               : *path + "-lock: " + hal::to_string(lock.error().code);
    return lock.error();
  }
  link->lock_ = std::move(*lock);
  sockaddr_un own{};
  own.sun_family = AF_UNIX;
  std::copy(path->begin(), path->end(), own.sun_path);
  unlink(path->c_str());  // of one that was killed: we have the lock
  link->listen_ = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (link->listen_ < 0 || bind(link->listen_, reinterpret_cast<const sockaddr*>(&own), sizeof own) != 0 ||
      listen(link->listen_, static_cast<int>(kMostClients)) != 0) {
    why = *path + ": " + std::strerror(errno);
    return hal::Error{hal::Errc::io, "socket", errno};
  }
  return link;
}

LocalLink::~LocalLink() {
  for (const Client& client : clients_) close(client.fd);
  if (listen_ < 0) return;
  close(listen_);
  unlink(path_.c_str());
}

void LocalLink::add_fds(std::vector<pollfd>& fds) const {
  fds.push_back({listen_, POLLIN, 0});
  for (const Client& client : clients_) fds.push_back({client.fd, POLLIN, 0});
}

void LocalLink::look() {
  for (;;) {
    const int fd = accept4(listen_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (fd < 0) break;
    if (clients_.size() == kMostClients)
      close(fd);
    else
      clients_.push_back({fd, false, 0});
  }
  std::erase_if(clients_, [&](Client& client) {
    if (receive(client)) return false;
    close(client.fd);
    return true;
  });
}

/// False: it is gone, or does not keep to the protocol.
bool LocalLink::receive(Client& client) {
  std::array<std::uint8_t, 2048> bytes;
  for (int i = 0; i < kAtATime; ++i) {
    const ssize_t n = recv(client.fd, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (n < 0) return errno == EAGAIN || errno == EINTR;
    const auto packet = wire::read_net_link({bytes.data(), static_cast<std::size_t>(n)});
    if (n == 0 || !packet) return false;
    if (packet->kind == NetLinkKind::say) {
      if (on_say_) on_say_(packet->payload);
    } else if (packet->kind == NetLinkKind::hello) {
      client.is_robot = true;
      if (!send_state(client)) return false;
    } else if (packet->kind == NetLinkKind::ask) {
      const std::string text = on_ask_ ? on_ask_() : "{}";
      std::vector<std::uint8_t> room(wire::kNetLinkHeadBytes + wire::kNetLinkMostText);
      if (!send_packet(client.fd, {NetLinkKind::answer, 0, 0, 0, bytes_of(text, wire::kNetLinkMostText)}, room))
        return false;
    } else {
      return false;
    }
  }
  return true;
}

void LocalLink::hear(std::uint32_t sender, std::int64_t stamp_ns, std::span<const std::uint8_t> datagram) {
  std::array<std::uint8_t, wire::kNetLinkHeadBytes + wire::kNetLinkMostDatagram> room;
  for (Client& client : clients_) {
    if (!client.is_robot) continue;
    if (send_packet(client.fd, {NetLinkKind::heard, sender, client.lost, stamp_ns, datagram}, room))
      client.lost = 0;
    else
      ++client.lost, ++lost_;
  }
}

bool LocalLink::send_state(const Client& client) const {
  std::array<std::uint8_t, wire::kNetLinkHeadBytes + wire::kNetLinkMostDatagram> room;
  return send_packet(client.fd, {NetLinkKind::state, 0, 0, 0, bytes_of(state_, wire::kNetLinkMostDatagram)}, room);
}

void LocalLink::set_state(const std::string& trouble) {
  if (trouble == state_) return;
  state_ = trouble;
  // One that does not take it is so far behind that it finds out by itself: its connection ends.
  std::erase_if(clients_, [&](const Client& client) {
    if (!client.is_robot || send_state(client)) return false;
    close(client.fd);
    return true;
  });
}

std::size_t LocalLink::robots() const {
  return static_cast<std::size_t>(
      std::count_if(clients_.begin(), clients_.end(), [](const Client& c) { return c.is_robot; }));
}

}  // namespace sinew::net
