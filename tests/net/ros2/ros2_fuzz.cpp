// For any bytes as any known type: refused, or read to a value that is written and read again. Then into an own
// message. The first two bytes choose the type and the line of the table.
#include <cstdlib>
#include <vector>

#include "msg/all.hpp"
#include "net/ros2/convert.hpp"

using namespace sinew;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const std::span<const std::uint8_t> in(data + 2, size - 2);
  const auto distro = (data[0] & 1) != 0 ? ros2::Distro::humble : ros2::Distro::jazzy;
  const auto& types = ros2::known_types(distro).all();
  const ros2::Type& type = types[data[0] / 2U % types.size()];
  ros2::Message message(type);
  if (ros2::decode(type, in, message.root())) {
    std::vector<std::uint8_t> out;
    ros2::encode(type, message.root(), out);
    ros2::Message again(type);
    if (!ros2::decode(type, out, again.root())) std::abort();
  }

  const auto& table = ros2::map_table();
  const ros2::MapLine& line = table[data[1] % table.size()];
  const msg::TypeInfo* own = msg::find_type(line.own.empty() ? "BaroSample" : line.own);
  if (!line.in || !own) return 0;
  ros2::MapOptions options;
  options.frame = "odom", options.child_frame = "base_link", options.joints = {"a", "b"}, options.object = "ball";
  options.field = "pressure_pa", options.max_m = 10, options.geoid_m = 40, options.camera = {300, 300, 160, 120};
  std::string why;
  const auto incoming = ros2::Incoming::make(distro, line.ros, *own, options, why);
  if (!incoming) std::abort();
  constexpr std::uint32_t kRoom = 4096;
  std::vector<std::uint64_t> slot((own->size + kRoom) / 8 + 1);
  (void)bool(incoming->decode(in, 0, slot.data(), own->has_bulk() ? kRoom : 0));
  return 0;
}
