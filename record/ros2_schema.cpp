#include "record/ros2_schema.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

namespace sinew::record {
namespace {

using Kind = Ros2Field::Kind;
using Shape = Ros2Field::Shape;

constexpr std::string_view kMark = "MSG: ";
constexpr std::array<std::pair<std::string_view, Kind>, 15> kPrimitives{{{"bool", Kind::boolean},
                                                                         {"int8", Kind::i8},
                                                                         {"uint8", Kind::u8},
                                                                         {"byte", Kind::u8},
                                                                         {"char", Kind::u8},
                                                                         {"int16", Kind::i16},
                                                                         {"uint16", Kind::u16},
                                                                         {"int32", Kind::i32},
                                                                         {"uint32", Kind::u32},
                                                                         {"int64", Kind::i64},
                                                                         {"uint64", Kind::u64},
                                                                         {"float32", Kind::f32},
                                                                         {"float64", Kind::f64},
                                                                         {"float", Kind::f32},
                                                                         {"string", Kind::text}}};

constexpr std::size_t kMaxDepth = 64;  // of types inside types: decoding them takes stack

// Every program of ROS 2 knows these.
constexpr std::string_view kTimes[] = {"builtin_interfaces/Time", "builtin_interfaces/Duration"};

std::string_view trimmed(std::string_view s) {
  constexpr std::string_view kSpace = " \t\r";
  const auto begin = s.find_first_not_of(kSpace);
  if (begin == std::string_view::npos) return {};
  return s.substr(begin, s.find_last_not_of(kSpace) - begin + 1);
}

/// "package/Name" from "package/msg/Name".
std::string short_name(std::string_view name) {
  const auto at = name.find("/msg/");
  return at == std::string_view::npos ? std::string(name)
                                      : std::string(name.substr(0, at)) + std::string(name.substr(at + 4));
}

struct Line {
  std::string_view type, name, remark;
  bool constant = false;
};

/// "float64[3] x 0 0 0" as its type and name; an empty type: the line is empty.
Line taken_apart(std::string_view line) {
  Line out;
  const auto remark_at = line.find('#');
  if (remark_at != std::string_view::npos) out.remark = trimmed(line.substr(remark_at + 1));
  line = trimmed(line.substr(0, remark_at));
  const auto end = line.find_first_of(" \t");
  out.type = line.substr(0, end);
  if (end == std::string_view::npos) return out;
  line = trimmed(line.substr(end));
  const auto name_end = line.find_first_of(" \t=");
  out.name = line.substr(0, name_end);
  out.constant = name_end != std::string_view::npos && trimmed(line.substr(name_end)).starts_with('=');
  return out;
}

/// Takes the array and bound suffixes off the type; false: they are not understood.
bool take_shape(std::string_view& type, Ros2Field& field) {
  if (type.ends_with(']')) {
    const auto open = type.rfind('[');
    if (open == std::string_view::npos) return false;
    const std::string_view inside = type.substr(open + 1, type.size() - open - 2);
    type = type.substr(0, open);
    if (inside.empty() || inside.starts_with("<=")) {
      field.shape = Shape::sequence;
    } else {
      field.shape = Shape::array;
      const auto read = std::from_chars(inside.data(), inside.data() + inside.size(), field.count);
      if (read.ec != std::errc() || read.ptr != inside.data() + inside.size()) return false;
    }
  }
  type = type.substr(0, type.find("<="));  // bound of a string
  return !type.empty();
}

class Parser {
 public:
  Parser(std::vector<Ros2Schema::Type>& types, std::string& why) : types_(types), why_(why) {}

  bool run(std::string_view name, std::string_view text) {
    types_.push_back({short_name(name), {}});
    for (bool first = true; !text.empty() || first; first = false) {
      const auto end = std::min(text.find('\n'), text.size());
      line(text.substr(0, end));
      text.remove_prefix(std::min(end + 1, text.size()));
    }
    for (const std::string_view time : kTimes)
      if (!find(time)) types_.push_back({std::string(time), {{"sec", Kind::i32}, {"nanosec", Kind::u32}}});
    return why_.empty() && resolve() && ends(0, 0);
  }

 private:
  struct Reference {
    std::size_t type, field;
    std::string name;
  };

  void line(std::string_view raw) {
    if (raw.starts_with(kMark)) {
      types_.push_back({short_name(trimmed(raw.substr(kMark.size()))), {}});
      return;
    }
    if (raw.starts_with("===")) return;
    const Line parts = taken_apart(raw);
    if (parts.type.empty() || parts.constant) return;
    Ros2Field field;
    field.name = parts.name;
    field.remark = parts.remark;
    std::string_view type = parts.type;
    if (parts.name.empty() || !take_shape(type, field)) return fail("not a field: " + std::string(raw));
    const auto* known =
        std::find_if(kPrimitives.begin(), kPrimitives.end(), [&](const auto& p) { return p.first == type; });
    field.kind = known == kPrimitives.end() ? Kind::nested : known->second;
    if (field.kind == Kind::nested)
      references_.push_back({types_.size() - 1, types_.back().fields.size(), short_name(type)});
    types_.back().fields.push_back(std::move(field));
  }

  std::optional<std::uint32_t> find(std::string_view name) const {
    for (std::uint32_t i = 0; i < types_.size(); ++i)
      if (types_[i].name == name) return i;
    return std::nullopt;
  }

  std::optional<std::uint32_t> find_in_any_package(const std::string& name) const {
    for (std::uint32_t i = 0; i < types_.size(); ++i)
      if (types_[i].name.ends_with("/" + name)) return i;
    return std::nullopt;
  }

  bool resolve() {
    for (const Reference& r : references_) {
      const std::string& from = types_[r.type].name;
      auto at = find(r.name);
      if (!at && r.name.find('/') == std::string::npos) at = find(from.substr(0, from.find('/') + 1) + r.name);
      if (!at && r.name.find('/') == std::string::npos) at = find_in_any_package(r.name);
      if (!at) {
        fail("the type " + r.name + " is not defined");
        return false;
      }
      types_[r.type].fields[r.field].nested = *at;
    }
    return true;
  }

  /// True if this type is of finite depth.
  bool ends(std::uint32_t type, std::size_t depth) {
    if (depth > kMaxDepth) {
      fail(types_[type].name + " contains itself, or too many others inside others");
      return false;
    }
    if (done_.size() < types_.size()) done_.resize(types_.size());
    if (done_[type]) return true;
    for (const Ros2Field& f : types_[type].fields)
      if (f.kind == Kind::nested && !ends(f.nested, depth + 1)) return false;
    return done_[type] = true;
  }

  void fail(std::string why) {
    if (why_.empty()) why_ = std::move(why);
  }

  std::vector<Ros2Schema::Type>& types_;
  std::string& why_;
  std::vector<Reference> references_;
  std::vector<bool> done_;
};

/// Takes the next line that says something, without its remark.
std::string_view next_line(std::string_view& text) {
  std::string_view line;
  while (line.empty() && !text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    const std::string_view raw = text.substr(0, end);
    line = trimmed(raw.substr(0, raw.find('#')));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return line;
}

}  // namespace

bool same_definition(std::string_view a, std::string_view b) {
  while (!a.empty() || !b.empty())
    if (next_line(a) != next_line(b)) return false;
  return true;
}

std::optional<Ros2Schema> Ros2Schema::parse(std::string_view name, std::string_view text, std::string& why) {
  why.clear();
  Ros2Schema schema;
  if (!Parser(schema.types_, why).run(name, text)) return std::nullopt;
  return schema;
}

}  // namespace sinew::record
