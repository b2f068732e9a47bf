#include "apps/bag/schema_quantities.hpp"

#include <optional>
#include <utility>

#include "apps/bag/field_remark.hpp"
#include "msg/text.hpp"

namespace sinew::app {
namespace {

using record::Quantity;
using record::Ros2Field;
using record::Ros2Schema;

// A definition may come from anywhere.
constexpr std::size_t kMostQuantities = 10'000;
constexpr std::uint32_t kMostBytes = 1 << 17;

/// Of a number; nothing for what is none.
std::optional<msg::Kind> number_kind(Ros2Field::Kind kind) {
  using K = Ros2Field::Kind;
  switch (kind) {
    case K::boolean:
    case K::u8:
      return msg::Kind::u8;
    case K::i8:
      return msg::Kind::i8;
    case K::i16:
      return msg::Kind::i16;
    case K::u16:
      return msg::Kind::u16;
    case K::i32:
      return msg::Kind::i32;
    case K::u32:
      return msg::Kind::u32;
    case K::i64:
      return msg::Kind::i64;
    case K::u64:
      return msg::Kind::u64;
    case K::f32:
      return msg::Kind::f32;
    case K::f64:
      return msg::Kind::f64;
    case K::text:
    case K::nested:
      break;
  }
  return std::nullopt;
}

bool is_quat(const Ros2Schema::Type& type) {
  if (type.name != "sinew_msgs/Quat" || type.fields.size() != 4) return false;
  for (std::size_t i = 0; i < 4; ++i) {
    const Ros2Field& f = type.fields[i];
    if (f.kind != Ros2Field::Kind::f64 || f.shape != Ros2Field::Shape::one || f.name != std::string(1, "wxyz"[i]))
      return false;
  }
  return true;
}

/// Walks through a message as CDR lays it out: each number is aligned to its own size.
class Layout {
 public:
  explicit Layout(const Ros2Schema& schema) : schema_(schema) {}

  /// False when the rest has no fixed place.
  bool add(const Ros2Schema::Type& type, const std::string& prefix, const std::string& unit) {
    if (type.fields.empty()) ++end;  // a struct has at least one member
    for (const Ros2Field& f : type.fields) {
      if (f.shape == Ros2Field::Shape::sequence || f.kind == Ros2Field::Kind::text) return false;
      const std::string said = remark_of(f).unit, &own = said.empty() ? unit : said;
      const bool is_array = f.shape == Ros2Field::Shape::array;
      for (std::uint32_t i = 0; i < (is_array ? f.count : 1); ++i) {
        const std::string path = prefix + f.name + (is_array ? "[" + std::to_string(i) + "]" : std::string());
        if (all.size() >= kMostQuantities || end >= kMostBytes || !add(f, path, own)) return false;
      }
    }
    return true;
  }

  std::vector<Quantity> all;
  std::uint32_t end = 0;  // of what was walked through

 private:
  bool add(const Ros2Field& f, const std::string& path, const std::string& unit) {
    if (const auto kind = number_kind(f.kind)) {
      const std::uint32_t size = msg::size_of(*kind), at = (end + size - 1) / size * size;
      all.push_back({path, unit, Quantity::What::number, *kind, at});
      end = at + size;
      return true;
    }
    const Ros2Schema::Type& type = schema_.type(f);
    if (!add(type, path + ".", unit)) return false;
    if (!is_quat(type)) return true;
    const std::uint32_t at = all[all.size() - type.fields.size()].offset;
    all.push_back({path + ".angle", "deg", Quantity::What::angle, msg::Kind::f64, at});
    all.push_back({path + ".tilt", "deg", Quantity::What::tilt, msg::Kind::f64, at});
    return true;
  }

  const Ros2Schema& schema_;
};

}  // namespace

std::vector<Quantity> schema_quantities(const Ros2Schema& schema, std::uint32_t& size) {
  Layout layout(schema);
  static_cast<void>(layout.add(schema.root(), "", ""));  // what it could place is there
  size = layout.end;
  return std::move(layout.all);
}

}  // namespace sinew::app
