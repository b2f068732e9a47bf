// refused: a field is an integer .not bool., an enumeration
#include "msg/describe.hpp"

namespace sinew::msg {

struct Probe {
  Time stamp;
  bool flags[8] = {};
};

template <>
struct Description<Probe> {
  static constexpr std::string_view name = "Probe", doc = "A message of this test.";
  static constexpr auto fields = describe(field<&Probe::stamp>("ns"), field<&Probe::flags>("1"));
};

const TypeInfo& probe() { return type_info<Probe>(); }

}  // namespace sinew::msg
