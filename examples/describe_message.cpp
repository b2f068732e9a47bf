// A message of one's own: a plain struct, one description next to it; everything else follows from that.
#include <array>
#include <cstdio>

#include "msg/cdr.hpp"
#include "msg/describe.hpp"
#include "msg/json.hpp"
#include "msg/ros2msg.hpp"

namespace demo {
using sinew::msg::Time;

enum class Contact : std::uint32_t { air = 0, touches = 1, stands = 2 };

/// Recordings, `topic echo` and `topic pub` know them.
constexpr sinew::msg::ValueName kContactNames[] = {
    {"air", Contact::air}, {"touches", Contact::touches}, {"stands", Contact::stands}};

/// State of one leg's foot.
struct FootContact {
  Time stamp;
  std::array<float, 4> pressure_pa{};
  Contact contact = Contact::air;
  std::uint32_t cycles = 0;
};
}  // namespace demo

template <>
struct sinew::msg::Description<demo::FootContact> {
  static constexpr std::string_view name = "FootContact", doc = "State of one leg's foot.";
  static constexpr auto fields = describe(  // leaving one out, or misspelling it, does not compile
      field<&demo::FootContact::stamp>("ns"), field<&demo::FootContact::pressure_pa>("Pa", "front left first"),
      enum_field<&demo::FootContact::contact>(demo::kContactNames), field<&demo::FootContact::cycles>("1"));
};

int main() {
  using namespace sinew;
  const msg::TypeInfo& type = msg::type_info<demo::FootContact>();
  demo::FootContact foot;
  foot.stamp = {1'500'000'000};
  foot.pressure_pa = {1.5F, 2, 0, 101325};
  foot.contact = demo::Contact::stands;

  std::string json;
  msg::to_json(type, &foot, json);
  std::printf("JSON:    %s\n", json.c_str());

  std::array<std::uint8_t, 128> wire;
  const std::size_t size = msg::cdr_encode(type, &foot, wire);
  demo::FootContact back;
  const auto decoded = msg::cdr_decode(type, std::span(wire).first(size), &back);
  std::printf("CDR:     %zu bytes, decoded %s\n", size, decoded ? "well" : "badly");

  std::printf("schema:\n%s", msg::ros2msg_schema(type).c_str());
  return decoded && back.pressure_pa == foot.pressure_pa && back.contact == foot.contact ? 0 : 1;
}
