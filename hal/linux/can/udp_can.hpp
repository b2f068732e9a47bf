#pragma once
#include <netinet/in.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "hal/linux/can/can_port.hpp"
#include "hal/linux/udp_batch.hpp"

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
  UdpCanBus(const CanSpec& spec, Os& os, std::shared_ptr<FdWatch> watch);
  Status open_sockets(std::string& why);
  Status join();
  Result<bool> fill() noexcept;
  bool take(const UdpPacket& packet, msg::CanFrame& out) noexcept;

  std::string interface_ = "lo";
  sockaddr_in group_{};
  int in_ = -1, out_ = -1;
  std::uint16_t own_port_ = 0;  // of out_; with own_ipv4_ it identifies our frames
  std::uint32_t own_ipv4_ = 0;
  UdpBatch batch_;
  std::size_t next_ = 0, count_ = 0;  // of the batch: read next, filled
  Time rejoin_at_;                    // send(): after an error, the membership is renewed at most once a second
  std::vector<CanFilter> filters_;
};

}  // namespace sinew::hal
