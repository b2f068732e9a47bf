#include "hal/linux/can/can.hpp"

#include "hal/linux/can/socket_can.hpp"
#include "hal/linux/can/socketcand_can.hpp"
#include "hal/linux/can/udp_can.hpp"

namespace sinew::hal {

Result<std::unique_ptr<CanBus>> open_can(const CanSpec& spec, Os& os, std::shared_ptr<FdWatch> watch,
                                         std::string& why) {
  if (spec.transport == "socketcan") return SocketCanBus::open(spec, os, std::move(watch), why);
  if (spec.transport == "udp") return UdpCanBus::open(spec, os, std::move(watch), why);
  if (spec.transport == "socketcand") return SocketcandCan::open(spec, os, std::move(watch), why);
  why = "'" + spec.transport + "' is no transport of CAN frames: socketcan, udp or socketcand";
  return Error{Errc::bad_argument, "transport"};
}

}  // namespace sinew::hal
