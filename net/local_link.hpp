#pragma once
#include <poll.h>

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hal/linux/run_dir.hpp"
#include "hal/result.hpp"

namespace sinew::net {

/// What the program says to the robot beside it and hears from it: the socket that hal::NetRadio looks for. Nobody can
/// make it wait: what a client does not take is lost and counted.
/// Thread:  owner.
class LocalLink {
 public:
  /// Errors:  bad_argument: the name; busy: a program for this robot runs already; denied, io. `why` has it in words.
  static hal::Result<std::unique_ptr<LocalLink>> open(const std::string& robot, std::string& why);
  ~LocalLink();
  LocalLink(const LocalLink&) = delete;
  LocalLink& operator=(const LocalLink&) = delete;

  void on_say(std::function<void(std::span<const std::uint8_t>)> use) { on_say_ = std::move(use); }
  void on_ask(std::function<std::string()> answer) { on_ask_ = std::move(answer); }

  void add_fds(std::vector<pollfd>& fds) const;
  /// Takes new clients and what they said.
  void look();
  /// One datagram for the robot, which came by DDS at `stamp_ns` of CLOCK_MONOTONIC.
  void hear(std::uint32_t sender, std::int64_t stamp_ns, std::span<const std::uint8_t> datagram);
  /// What is wrong now; sent when it changes, and to each new client.
  void set_state(const std::string& trouble);

  std::size_t robots() const;
  std::uint64_t lost() const { return lost_; }

  static constexpr std::size_t kMostClients = 16;

 private:
  struct Client {
    int fd = -1;
    bool is_robot = false;   // it said hello
    std::uint32_t lost = 0;  // datagrams that it did not take, since the last that it took
  };
  LocalLink() = default;
  bool receive(Client& client);
  bool send_state(const Client& client) const;

  std::unique_ptr<hal::FileLock> lock_;
  std::string path_;
  int listen_ = -1;
  std::vector<Client> clients_;
  std::string state_;
  std::uint64_t lost_ = 0;
  std::function<void(std::span<const std::uint8_t>)> on_say_;
  std::function<std::string()> on_ask_;
};

}  // namespace sinew::net
