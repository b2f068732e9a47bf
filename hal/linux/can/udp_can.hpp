#pragma once
#include <netinet/in.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "hal/linux/can/can_port.hpp"
#include "hal/linux/can/can_stamp.hpp"

namespace sinew::hal {

/// A CAN bus made of UDP multicast, as DroneCAN tools and ArduPilot use it: for benches without CAN hardware. Bus B is
/// the group 239.65.82.B, port 57732 (wire/dronecan_udp.hpp), on the loopback interface unless the address names
/// another: "3", "239.65.82.3", "3:eth0". Every member of the group is on the bus, on any machine of that network.
///
/// There is no acknowledgement and no repetition: a frame for which a receiver has no room is lost and counted in its
/// rx_lost. There are no error frames and no arbitration; bit_rate() is that of the spec, for the load. A sent frame
/// cannot be taken back. Own frames are recognised by their sender and come back only with CanSpec::receive_own. These
/// count as malformed: CAN FD frames where data_bit_rate is 0, remote frames, and packets that are no frame.
class UdpCanBus final : public CanPort {
 public:
  /// Errors:  bad_argument: the address; not_found: no such interface; denied, busy, io.
  static Result<std::unique_ptr<CanBus>> open(const CanSpec& spec, Os& os, std::shared_ptr<FdWatch> watch,
                                              std::string& why);
  ~UdpCanBus() override;

  Result<bool> read(msg::CanFrame& out) noexcept override;
  Status send(const msg::CanFrame& frame, Time deadline) noexcept override;
  Status set_filters(std::span<const CanFilter> filters) override;

 private:
  struct Batch;

  UdpCanBus(const CanSpec& spec, Os& os, std::shared_ptr<FdWatch> watch);
  Status open_sockets(std::string& why);
  Status join();
  Result<bool> fill() noexcept;
  bool take(std::size_t i, msg::CanFrame& out) noexcept;

  std::string interface_ = "lo";
  sockaddr_in group_{};
  int in_ = -1, out_ = -1;
  in_port_t own_port_ = 0;  // of out_, network order; with own_address_ it identifies our frames
  in_addr_t own_address_ = 0;
  std::unique_ptr<Batch> batch_;
  std::uint32_t overflow_ = 0;
  Time rejoin_at_;  // send(): after an error, the membership is renewed at most once a second
  std::vector<CanFilter> filters_;
};

}  // namespace sinew::hal
