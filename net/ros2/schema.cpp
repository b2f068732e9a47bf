#include "net/ros2/schema.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <set>
#include <utility>

namespace sinew::ros2 {
namespace {

constexpr std::array<std::pair<std::string_view, Kind>, 14> kPrimitives{{{"bool", Kind::boolean},
                                                                         {"byte", Kind::u8},
                                                                         {"char", Kind::u8},
                                                                         {"int8", Kind::i8},
                                                                         {"uint8", Kind::u8},
                                                                         {"int16", Kind::i16},
                                                                         {"uint16", Kind::u16},
                                                                         {"int32", Kind::i32},
                                                                         {"uint32", Kind::u32},
                                                                         {"int64", Kind::i64},
                                                                         {"uint64", Kind::u64},
                                                                         {"float32", Kind::f32},
                                                                         {"float64", Kind::f64},
                                                                         {"string", Kind::text}}};
constexpr std::uint32_t kMostFixed = 1'000'000;
constexpr std::size_t kRuler = 80;

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_word(std::string_view text) {
  return !text.empty() && is_letter(text.front()) &&
         std::all_of(text.begin(), text.end(), [](char c) { return is_letter(c) || is_digit(c) || c == '_'; });
}

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\r");
  if (begin == text.npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") + 1 - begin);
}

/// Calls `each` with every line.
template <class Each>
void for_lines(std::string_view text, const Each& each) {
  while (!text.empty()) {
    const auto end = text.find('\n');
    each(text.substr(0, end));
    if (end == text.npos) return;
    text.remove_prefix(end + 1);
  }
}

std::optional<std::uint32_t> count_of(std::string_view digits) {
  std::uint32_t count = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), count);
  if (error != std::errc{} || end != digits.data() + digits.size() || count == 0 || count > kMostFixed) return {};
  return count;
}

std::string_view package_of(std::string_view name) { return name.substr(0, name.find('/')); }
std::string_view last_of(std::string_view name) { return name.substr(name.rfind('/') + 1); }

/// "[]", "[9]", "[<=9]" behind the element's type, which is left in `type`.
bool read_shape(std::string_view& type, Field& field) {
  const auto open = type.find('[');
  if (open == type.npos) return true;
  if (!type.ends_with(']')) return false;
  std::string_view inside = type.substr(open + 1, type.size() - open - 2);
  type = type.substr(0, open);
  field.shape = Shape::sequence, field.count = 0;
  if (inside.empty()) return true;
  const bool bound = inside.starts_with("<=");
  if (bound) inside.remove_prefix(2);
  const auto count = count_of(inside);
  if (!count) return false;
  field.shape = bound ? Shape::sequence : Shape::fixed;
  field.count = *count;
  return true;
}

std::uint32_t least_bytes_of(const Field& f) {
  if (f.shape == Shape::sequence) return 4;
  const std::uint32_t one = f.kind == Kind::nested ? f.nested->least_bytes : f.kind == Kind::text ? 4 : size_of(f.kind);
  return one * f.count;
}

/// Nested types, each behind those that it names itself.
void collect(const Type& type, std::vector<const Type*>& seen) {
  for (const Field& f : type.fields)
    if (f.nested && std::find(seen.begin(), seen.end(), f.nested) == seen.end()) {
      collect(*f.nested, seen);
      if (std::find(seen.begin(), seen.end(), f.nested) == seen.end()) seen.push_back(f.nested);
    }
}

/// Source:  OMG IDL 4.2, table 7-6.
constexpr std::string_view kIdlWords[] = {
    "abstract",  "any",      "alias",      "attribute", "bitfield", "bitmask",    "bitset",      "boolean",
    "case",      "char",     "component",  "connector", "const",    "consumes",   "context",     "custom",
    "default",   "double",   "exception",  "emits",     "enum",     "eventtype",  "factory",     "false",
    "finder",    "fixed",    "float",      "getraises", "home",     "import",     "in",          "inout",
    "interface", "local",    "long",       "manages",   "map",      "mirrorport", "module",      "multiple",
    "native",    "object",   "octet",      "oneway",    "out",      "primarykey", "private",     "port",
    "porttype",  "provides", "public",     "publishes", "raises",   "readonly",   "setraises",   "sequence",
    "short",     "string",   "struct",     "supports",  "switch",   "true",       "truncatable", "typedef",
    "typeid",    "typename", "typeprefix", "unsigned",  "union",    "uses",       "valuebase",   "valuetype",
    "void",      "wchar",    "wstring"};

/// IDL takes a word of its own as a name with _ before it, which is not part of the name.
std::string idl_name(const std::string& name) {
  const bool is_word = std::find(std::begin(kIdlWords), std::end(kIdlWords), name) != std::end(kIdlWords);
  return (is_word ? "_" : "") + name;
}

std::string idl_element(const Field& f) {
  switch (f.kind) {
    case Kind::boolean:
      return "boolean";
    case Kind::i8:
      return "int8";
    case Kind::u8:
      return f.written == "byte" ? "octet" : "uint8";
    case Kind::i16:
      return "short";
    case Kind::u16:
      return "unsigned short";
    case Kind::i32:
      return "long";
    case Kind::u32:
      return "unsigned long";
    case Kind::i64:
      return "long long";
    case Kind::u64:
      return "unsigned long long";
    case Kind::f32:
      return "float";
    case Kind::f64:
      return "double";
    case Kind::text:
      return f.longest_text == 0 ? "string" : "string<" + std::to_string(f.longest_text) + ">";
    case Kind::nested:
      break;
  }
  std::string name = f.nested->name;
  for (auto at = name.find('/'); at != name.npos; at = name.find('/')) name.replace(at, 1, "::");
  return name;
}

}  // namespace

std::uint32_t size_of(Kind kind) {
  switch (kind) {
    case Kind::boolean:
    case Kind::i8:
    case Kind::u8:
      return 1;
    case Kind::i16:
    case Kind::u16:
      return 2;
    case Kind::i32:
    case Kind::u32:
    case Kind::f32:
      return 4;
    case Kind::i64:
    case Kind::u64:
    case Kind::f64:
      return 8;
    case Kind::text:
    case Kind::nested:
      break;
  }
  return 0;
}

const Field* Type::find(std::string_view field) const {
  for (const Field& f : fields)
    if (f.name == field) return &f;
  return nullptr;
}

bool Types::read_field(std::string_view line, std::string_view package, Type& type, std::string& why) const {
  const auto gap = line.find_first_of(" \t");
  std::string_view element = line.substr(0, gap);
  const std::string_view rest = gap == line.npos ? std::string_view{} : trimmed(line.substr(gap));
  const auto name_end = rest.find_first_of(" \t=");
  const std::string_view name = rest.substr(0, name_end);
  if (!is_word(name)) return why = "a line is TYPE NAME", false;
  if (name_end != rest.npos && rest.find('=') != rest.npos && trimmed(rest.substr(name_end)).starts_with('='))
    return true;  // a constant: nothing on the wire
  Field field;
  field.name = name;
  if (!read_shape(element, field)) return why = "an array is TYPE[], TYPE[N] or TYPE[<=N]", false;
  if (const auto bound = element.find("<="); bound != element.npos) {
    const auto longest = count_of(element.substr(bound + 2));
    if (element.substr(0, bound) != "string" || !longest) return why = "a bound is string<=N", false;
    field.longest_text = *longest;
    element = element.substr(0, bound);
  }
  if (type.find(name)) return why = std::string(name) + " is there twice", false;
  const auto known =
      std::find_if(kPrimitives.begin(), kPrimitives.end(), [&](const auto& p) { return p.first == element; });
  if (known != kPrimitives.end()) {
    field.kind = known->second;
    field.written = element;
  } else {
    std::string full = element == "Header" ? "std_msgs/Header" : std::string(element);
    if (full.find('/') == full.npos) full = std::string(package) + "/" + full;
    field.nested = find(full);
    if (!field.nested) return why = "type " + full + " is not known", false;
    field.kind = Kind::nested;
    field.written = std::string(package_of(full)) + "/" + std::string(last_of(full));
  }
  type.fields.push_back(std::move(field));
  return true;
}

bool Types::add(std::string_view name, std::string_view text, std::string& why) {
  Type type;
  type.name = long_name(name);
  if (by_name_.contains(type.name)) return why = type.name + " is known already", false;
  type.lines = text;
  if (!type.lines.empty() && type.lines.back() != '\n') type.lines += '\n';
  int number = 0;
  bool good = true;
  for_lines(text, [&](std::string_view line) {
    ++number;
    if (!good) return;
    line = trimmed(line.substr(0, line.find('#')));
    if (line.empty()) return;
    std::string wrong;
    if (read_field(line, package_of(name), type, wrong)) return;
    good = false;
    why = type.name + ", line " + std::to_string(number) + ": " + wrong;
  });
  if (!good) return false;
  for (const Field& f : type.fields) {
    const std::uint64_t bytes = std::uint64_t{type.least_bytes} + least_bytes_of(f);
    if (bytes > kMostFixed * 8ULL) return why = type.name + ": larger than a message may be", false;
    type.least_bytes = static_cast<std::uint32_t>(bytes);
  }
  const Type& kept = types_.emplace_back(std::move(type));
  by_name_.emplace(kept.name, &kept);
  return true;
}

bool Types::add_with_nested(std::string_view name, std::string_view text, std::string& why) {
  std::vector<std::pair<std::string, std::string>> parts{{long_name(name), {}}};
  for_lines(text, [&](std::string_view line) {
    const std::string_view bare = trimmed(line);
    if (bare.size() == kRuler && bare.find_first_not_of('=') == bare.npos)
      parts.emplace_back();
    else if (parts.back().first.empty() && bare.starts_with("MSG: "))
      parts.back().first = long_name(trimmed(bare.substr(5)));
    else
      parts.back().second.append(line).append("\n");
  });
  // A nested type may stand before those that it names: each pass adds those whose types are known.
  for (bool added = true; added;) {
    added = false;
    for (auto& [part, lines] : parts) {
      if (part.empty() || find(part)) continue;
      added = add(part, lines, why) || added;
    }
  }
  if (find(long_name(name))) return why.clear(), true;
  return false;
}

const Type* Types::find(std::string_view name) const {
  const auto it = by_name_.find(long_name(name));
  return it == by_name_.end() ? nullptr : it->second;
}

std::string long_name(std::string_view name) {
  if (std::count(name.begin(), name.end(), '/') != 1) return std::string(name);
  return std::string(package_of(name)) + "/msg/" + std::string(last_of(name));
}

std::string dds_type_name(std::string_view ros_name) {
  const std::string full = long_name(ros_name);
  std::string name;
  for (const char c : std::string_view(full).substr(0, full.rfind('/')))
    name += c == '/' ? std::string("::") : std::string(1, c);
  return name + "::dds_::" + std::string(last_of(full)) + "_";
}

std::string with_nested(const Type& type) {
  std::string text = type.lines;
  std::vector<const Type*> nested;
  collect(type, nested);
  for (const Type* t : nested)
    text += std::string(kRuler, '=') + "\nMSG: " + std::string(package_of(t->name)) + "/" +
            std::string(last_of(t->name)) + "\n" + t->lines;
  return text;
}

std::string idl_of(const Type& type) {
  std::vector<const Type*> all;
  collect(type, all);
  all.push_back(&type);
  std::string text;
  for (const Type* t : all) {
    const std::string_view package = package_of(t->name);
    const std::string_view folder =
        std::string_view(t->name).substr(package.size() + 1, t->name.rfind('/') - package.size() - 1);
    text += "module " + std::string(package) + " { module " + std::string(folder) + " {\n  struct " +
            std::string(last_of(t->name)) + " {\n";
    for (const Field& f : t->fields) {
      std::string element = idl_element(f);
      if (f.shape == Shape::sequence)
        element = "sequence<" + element + (f.count == 0 ? "" : ", " + std::to_string(f.count)) + ">";
      text += "    " + element + " " + idl_name(f.name) +
              (f.shape == Shape::fixed ? "[" + std::to_string(f.count) + "]" : "") + ";\n";
    }
    text += "  };\n}; };\n";
  }
  return text;
}

}  // namespace sinew::ros2
