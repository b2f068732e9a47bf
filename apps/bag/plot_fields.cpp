#include "apps/bag/plot_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>

#include "apps/bag/field_remark.hpp"
#include "hal/did_you_mean.hpp"

namespace sinew::app {

using Json = nlohmann::ordered_json;
using record::Ros2Field;
using record::Ros2Schema;

/// The values of one number of a topic's messages.
struct PlotFields::Column {
  std::string topic{}, name{};       // "x" of p_world_m.x
  std::vector<std::string> steps{};  // the path to it: "p_world_m", "x"
  FieldRemark remark{};
  bool stepped = false;  // an integer does not glide from one value to the next
  std::vector<std::pair<double, double>> points{};
};

struct PlotFields::Expression {
  enum class Kind : std::uint8_t { field, minus, angle, norm } kind = Kind::field;
  std::string text{}, unit{};
  std::vector<std::string> names{};                // of the numbers that come out: "x", "y", "z"; of one: ""
  std::vector<std::shared_ptr<Column>> columns{};  // of a field
  std::unique_ptr<Expression> a{}, b{};            // norm has no b
};

namespace {

using Expression = PlotFields::Expression;
using Column = PlotFields::Column;
using Columns = std::vector<std::shared_ptr<Column>>;
using Points = std::vector<std::pair<double, double>>;

constexpr std::size_t kMostNumbers = 16;  // of one field
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::string trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(' ');
  return begin == text.npos ? std::string() : std::string(text.substr(begin, text.find_last_not_of(' ') - begin + 1));
}

/// "value[0].x" as "value", "0", "x".
std::vector<std::string> steps_of(std::string_view path) {
  std::vector<std::string> steps(1);
  for (const char c : path)
    if (c == '.' || c == '[')
      steps.emplace_back();
    else if (c != ']')
      steps.back() += c;
  return steps;
}

// ---- fields in the definitions

/// All numbers at or inside a field: `column` is the field, with its path.
void add_numbers(const Ros2Schema& schema, const Ros2Field& field, bool whole, const Column& column, Columns& out) {
  if (field.kind == Ros2Field::Kind::text || (whole && field.shape == Ros2Field::Shape::sequence)) return;
  const std::uint32_t count = whole && field.shape == Ros2Field::Shape::array ? field.count : 0;
  for (std::uint32_t i = 0; i < count && out.size() <= kMostNumbers; ++i) {
    Column one = column;
    one.steps.push_back(std::to_string(i));
    one.name = (column.name.empty() ? "" : column.name + ".") + one.steps.back();
    add_numbers(schema, field, false, one, out);
  }
  if (count > 0) return;
  if (field.kind != Ros2Field::Kind::nested) {
    Column one = column;
    FieldRemark own = remark_of(field);
    if (own.unit.empty()) own.unit = column.remark.unit;  // of a vector around it
    one.remark = std::move(own);
    one.stepped = field.kind != Ros2Field::Kind::f32 && field.kind != Ros2Field::Kind::f64;
    out.push_back(std::make_shared<Column>(std::move(one)));
    return;
  }
  for (const Ros2Field& inner : schema.type(field).fields) {
    Column one = column;
    one.remark = remark_of(field);
    one.steps.push_back(inner.name);
    one.name = (column.name.empty() ? "" : column.name + ".") + inner.name;
    add_numbers(schema, inner, true, one, out);
  }
}

/// Follows the path of `column`; empty: all numbers are in `out`, else why not.
std::string find_numbers(const Ros2Schema& schema, Column column, const std::string& text, Columns& out) {
  const std::vector<std::string> path = std::move(column.steps);
  column.steps.clear();
  const Ros2Schema::Type* type = &schema.root();
  const Ros2Field* field = nullptr;
  bool whole = true;  // an array and not an element
  for (const std::string& step : path) {
    if (field && whole && field->shape != Ros2Field::Shape::one) {
      std::uint32_t index = 0;
      const auto read = std::from_chars(step.data(), step.data() + step.size(), index);
      const bool number = read.ec == std::errc() && read.ptr == step.data() + step.size();
      if (!number || (field->shape == Ros2Field::Shape::array && index >= field->count))
        return fmt::format("{}: no \"{}\"; an index from 0{}", text, step,
                           field->shape == Ros2Field::Shape::array ? fmt::format(" to {}", field->count - 1) : "");
      whole = false;
    } else {
      if (field && field->kind != Ros2Field::Kind::nested)
        return fmt::format("{}: no \"{}\": {} is one number", text, step, field->name);
      if (field) type = &schema.type(*field);
      const auto at =
          std::find_if(type->fields.begin(), type->fields.end(), [&](const auto& f) { return f.name == step; });
      std::vector<std::string> names;
      for (const Ros2Field& f : type->fields) names.push_back(f.name);
      if (at == type->fields.end())
        return fmt::format("{}: no \"{}\"; one of {}{}", text, step, fmt::join(names, " "),
                           hal::did_you_mean(step, names));
      if (field && column.remark.unit.empty()) column.remark = remark_of(*field);
      field = &*at;
      whole = true;
    }
    column.steps.push_back(step);
  }
  if (field) {
    add_numbers(schema, *field, whole, column, out);
  } else {
    for (const Ros2Field& inner : type->fields) {
      Column one = column;
      one.steps = {inner.name};
      one.name = inner.name;
      add_numbers(schema, inner, true, one, out);
    }
  }
  if (out.empty()) return text + ": there is no number in it";
  if (out.size() > kMostNumbers) return fmt::format("{}: more than {} numbers: name a part of it", text, kMostNumbers);
  return {};
}

// ---- expressions

class Parser {
 public:
  Parser(const TopicSchemas& topics, std::string& why) : topics_(topics), why_(why) {}

  /// Null, with `why`.
  std::unique_ptr<Expression> expression(const std::string& text) {
    int depth = 0;
    for (std::size_t i = 0; i + 2 < text.size(); ++i) {
      depth += (text[i] == '(' ? 1 : 0) - (text[i] == ')' ? 1 : 0);
      if (depth == 0 && text.compare(i, 3, " - ") == 0) return difference(text, i);
    }
    return term(trimmed(text));
  }

 private:
  std::unique_ptr<Expression> refuse(std::string why) {
    why_ = std::move(why);
    return nullptr;
  }

  std::unique_ptr<Expression> difference(const std::string& text, std::size_t at) {
    auto whole = std::make_unique<Expression>();
    whole->kind = Expression::Kind::minus;
    whole->text = trimmed(text);
    whole->a = term(trimmed(std::string_view(text).substr(0, at)));
    whole->b = whole->a ? term(trimmed(std::string_view(text).substr(at + 3))) : nullptr;
    if (!whole->b) return nullptr;
    if (whole->a->names.size() != whole->b->names.size())
      return refuse(fmt::format("{}: {} numbers less {}", text, whole->a->names.size(), whole->b->names.size()));
    if (whole->a->unit != whole->b->unit)
      return refuse(fmt::format("{}: [{}] less [{}]", text, whole->a->unit, whole->b->unit));
    whole->unit = whole->a->unit;
    whole->names = whole->a->names;
    return whole;
  }

  std::unique_ptr<Expression> term(const std::string& text) {
    if (text.starts_with("angle(") && text.ends_with(')')) return angle(text);
    if (text.starts_with("norm(") && text.ends_with(')')) return norm(text);
    return text.find_first_of("() ,") == text.npos && !text.empty()
               ? field(text)
               : refuse(text + ": a FIELD, 'FIELD - FIELD', 'angle(FIELD, FIELD)' or 'norm(FIELD)' is known");
  }

  std::unique_ptr<Expression> angle(const std::string& text) {
    const std::string inside = text.substr(6, text.size() - 7);
    const auto comma = inside.find(',');
    if (comma == inside.npos)
      return refuse(text +
                    ": two attitudes, such as angle(filter.state.q_world_base, "
                    "ground_truth.q_world_base)");
    auto whole = std::make_unique<Expression>();
    whole->kind = Expression::Kind::angle;
    whole->text = text;
    whole->unit = "deg";
    whole->names = {""};
    whole->a = term(trimmed(inside.substr(0, comma)));
    whole->b = whole->a ? term(trimmed(inside.substr(comma + 1))) : nullptr;
    if (!whole->b) return nullptr;
    for (const Expression* one : {whole->a.get(), whole->b.get()})
      if (one->kind != Expression::Kind::field || !is_attitude(one->names))
        return refuse(one->text + ": not an attitude: it needs w, x, y and z");
    return whole;
  }
  static bool is_attitude(std::vector<std::string> names) {
    std::sort(names.begin(), names.end());
    return names == std::vector<std::string>{"w", "x", "y", "z"};
  }

  std::unique_ptr<Expression> norm(const std::string& text) {
    auto whole = std::make_unique<Expression>();
    whole->kind = Expression::Kind::norm;
    whole->text = text;
    whole->a = expression(text.substr(5, text.size() - 6));
    if (!whole->a) return nullptr;
    whole->unit = whole->a->unit;
    whole->names = {""};
    return whole;
  }

  std::unique_ptr<Expression> field(const std::string& text) {
    const std::string* topic = nullptr;
    std::vector<std::string> known;
    for (const auto& [name, schema] : topics_) {
      known.push_back(name);
      const bool begins = text == name || text.starts_with(name + ".") || text.starts_with(name + "[");
      if (begins && (!topic || name.size() > topic->size())) topic = &name;
    }
    if (!topic) {
      std::string hint = hal::did_you_mean(text, known);
      for (auto end = text.rfind('.'); hint.empty() && end != text.npos && end > 0; end = text.rfind('.', end - 1))
        hint = hal::did_you_mean(text.substr(0, end), known);
      return refuse(fmt::format("{}: no such topic; there are {}{}", text, fmt::join(known, " "), hint));
    }
    auto one = std::make_unique<Expression>();
    one->text = text;
    Column column;
    column.topic = *topic;
    if (text.size() > topic->size()) column.steps = steps_of(text.substr(topic->size() + 1));
    if (why_ = find_numbers(topics_.at(*topic), column, text, one->columns); !why_.empty()) return nullptr;
    one->unit = one->columns[0]->remark.unit;
    for (const auto& c : one->columns) {
      one->names.push_back(c->name);
      if (c->remark.unit != one->unit) mixed(*one, c->remark.unit);
    }
    return why_.empty() ? std::move(one) : nullptr;
  }
  void mixed(const Expression& one, const std::string& other) {
    why_ = fmt::format("{}: [{}] and [{}] do not go on one axis: name a part of it", one.text, one.unit, other);
  }

  const TopicSchemas& topics_;
  std::string& why_;
};

// ---- values

double number_at(const Json& message, const std::vector<std::string>& steps) {
  const Json* at = &message;
  for (const std::string& step : steps) {
    if (at->is_array()) {
      std::size_t index = 0;
      std::from_chars(step.data(), step.data() + step.size(), index);
      if (index >= at->size()) return kNaN;  // a shorter list
      at = &(*at)[index];
    } else {
      const auto inner = at->is_object() ? at->find(step) : at->end();
      if (inner == at->end()) return kNaN;
      at = &*inner;
    }
  }
  if (at->is_boolean()) return at->get<bool>() ? 1 : 0;
  return at->is_number() ? at->get<double>() : kNaN;
}

/// The value between the points on both sides of `t`; NaN outside of them. Of whole numbers the last one before.
double value_at(const Points& points, double t, bool stepped) {
  const auto after =
      std::lower_bound(points.begin(), points.end(), t, [](const auto& p, double v) { return p.first < v; });
  if (after == points.end()) return stepped && !points.empty() ? points.back().second : kNaN;
  if (after->first == t) return after->second;
  if (after == points.begin()) return kNaN;
  const auto before = after - 1;
  if (stepped) return before->second;
  return before->second + (after->second - before->second) * (t - before->first) / (after->first - before->first);
}

bool is_stepped(const Expression& e) {
  switch (e.kind) {
    case Expression::Kind::field:
      return e.columns[0]->stepped;
    case Expression::Kind::minus:
      return is_stepped(*e.a) && is_stepped(*e.b);
    case Expression::Kind::angle:
    case Expression::Kind::norm:
      return false;
  }
  return false;
}

/// The rotation from one attitude to the other, 0 to 180 deg. B between its messages: the shorter way, normalised.
double angle_deg(const std::array<double, 4>& a, const std::array<double, 4>& b) {
  double dot = 0, aa = 0, bb = 0;
  for (std::size_t i = 0; i < 4; ++i) dot += a[i] * b[i], aa += a[i] * a[i], bb += b[i] * b[i];
  return 2 * std::acos(std::min(1.0, std::abs(dot) / std::sqrt(aa * bb))) * 180 / std::numbers::pi;
}

std::vector<Points> values_of(const Expression& e);

Points angles_of(const Expression& e) {
  std::array<const Points*, 4> a{}, b{};
  for (std::size_t i = 0; i < 4; ++i) {
    const std::string name(1, "wxyz"[i]);
    for (std::size_t c = 0; c < 4; ++c) {
      if (e.a->names[c] == name) a[i] = &e.a->columns[c]->points;
      if (e.b->names[c] == name) b[i] = &e.b->columns[c]->points;
    }
  }
  Points angles;
  for (std::size_t n = 0; n < a[0]->size(); ++n) {
    const double t = (*a[0])[n].first;
    std::array<double, 4> qa{}, qb{};
    for (std::size_t i = 0; i < 4; ++i) qa[i] = (*a[i])[n].second, qb[i] = value_at(*b[i], t, false);
    if (std::isnan(qb[0])) continue;  // outside of what the other has
    angles.emplace_back(t, angle_deg(qa, qb));
  }
  return angles;
}

std::vector<Points> values_of(const Expression& e) {
  std::vector<Points> values;
  switch (e.kind) {
    case Expression::Kind::field:
      for (const auto& column : e.columns) values.push_back(column->points);
      return values;
    case Expression::Kind::minus: {
      values = values_of(*e.a);
      const auto less = values_of(*e.b);
      for (std::size_t i = 0; i < values.size(); ++i)
        for (auto& [t, v] : values[i]) v -= value_at(less[i], t, is_stepped(*e.b));
      return values;
    }
    case Expression::Kind::angle:
      return {angles_of(e)};
    case Expression::Kind::norm: {
      const auto parts = values_of(*e.a);
      values.push_back(parts[0]);
      for (std::size_t n = 0; n < values[0].size(); ++n) {
        double sum = 0;
        for (const Points& part : parts) sum += part[n].second * part[n].second;
        values[0][n].second = std::sqrt(sum);
      }
      return values;
    }
  }
  return values;
}

std::string y_label(const Expression& e) {
  if (e.unit == "enum") return "";  // the names of its values need the room
  return e.unit.empty() || e.unit == "1" ? "" : e.unit;
}

/// Whether an expression goes on this plot: the same unit, and names of its own for its values.
bool shares(const Expression& a, const Expression& b) { return a.unit == b.unit && a.unit != "enum"; }

void collect(const Expression& e, std::map<std::string, Columns>& columns) {
  for (const auto& column : e.columns) columns[column->topic].push_back(column);
  for (const Expression* inner : {e.a.get(), e.b.get()})
    if (inner) collect(*inner, columns);
}

}  // namespace

PlotFields::PlotFields() = default;
PlotFields::PlotFields(PlotFields&&) noexcept = default;
PlotFields& PlotFields::operator=(PlotFields&&) noexcept = default;
PlotFields::~PlotFields() = default;

std::optional<PlotFields> PlotFields::make(const std::vector<std::string>& expressions, const TopicSchemas& topics,
                                           std::string& why) {
  PlotFields fields;
  for (const std::string& text : expressions) {
    auto expression = Parser(topics, why).expression(text);
    if (!expression) return std::nullopt;
    collect(*expression, fields.columns_);
    fields.expressions_.push_back(std::move(expression));
  }
  return fields;
}

std::vector<std::string> PlotFields::topics() const {
  std::vector<std::string> names;
  for (const auto& [topic, columns] : columns_) names.push_back(topic);
  return names;
}

void PlotFields::add(const std::string& topic, double time_s, const Json& message) {
  const auto wanted = columns_.find(topic);
  if (wanted == columns_.end()) return;
  for (const auto& column : wanted->second) column->points.emplace_back(time_s, number_at(message, column->steps));
}

std::vector<Plot> PlotFields::plots() const {
  std::vector<Plot> plots;
  std::vector<const Expression*> first;  // of each plot
  for (const auto& e : expressions_) {
    auto at = std::find_if(first.begin(), first.end(), [&](const Expression* other) { return shares(*other, *e); });
    if (at == first.end()) {
      first.push_back(e.get());
      at = first.end() - 1;
      plots.emplace_back().y_label = y_label(*e);
    }
    Plot& plot = plots[static_cast<std::size_t>(at - first.begin())];
    const auto values = values_of(*e);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const char* const between = e->kind == Expression::Kind::field ? "." : ": ";
      const std::string name = e->text + (values.size() == 1 ? "" : between + e->names[i]);
      plot.series.push_back({name + (values[i].empty() ? " (no message)" : ""), values[i], is_stepped(*e)});
    }
    if (e->kind == Expression::Kind::field && !e->columns[0]->remark.bits)
      for (const auto& [value, name] : e->columns[0]->remark.names) plot.y_names[static_cast<double>(value)] = name;
  }
  return plots;
}

}  // namespace sinew::app
