#include "net/ros2/convert.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

#include "msg/cdr.hpp"
#include "msg/json.hpp"
#include "msg/ros2msg.hpp"
#include "msg/text.hpp"
#include "net/ros2/plan.hpp"

namespace sinew::ros2 {
namespace detail {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

template <class T>
double read_as(const std::uint8_t* p) {
  T value;
  std::memcpy(&value, p, sizeof value);
  return static_cast<double>(value);
}

template <class T>
void write_as(std::uint8_t* p, double number) {
  T value{};
  if constexpr (std::is_floating_point_v<T>) {
    value = static_cast<T>(number);
  } else {
    // The nearest value that the type has.
    const double low = static_cast<double>(std::numeric_limits<T>::min());
    const double high = static_cast<double>(std::numeric_limits<T>::max());
    if (number >= high)
      value = std::numeric_limits<T>::max();
    else if (number > low)
      value = static_cast<T>(number);
    else
      value = std::numeric_limits<T>::min();
  }
  std::memcpy(p, &value, sizeof value);
}

}  // namespace

double number_at(const void* message, const Member& member) {
  const auto* p = static_cast<const std::uint8_t*>(message) + member.offset;
  switch (member.kind) {
    case msg::Kind::i8:
      return read_as<std::int8_t>(p);
    case msg::Kind::u8:
      return read_as<std::uint8_t>(p);
    case msg::Kind::i16:
      return read_as<std::int16_t>(p);
    case msg::Kind::u16:
      return read_as<std::uint16_t>(p);
    case msg::Kind::i32:
      return read_as<std::int32_t>(p);
    case msg::Kind::u32:
      return read_as<std::uint32_t>(p);
    case msg::Kind::i64:
      return read_as<std::int64_t>(p);
    case msg::Kind::u64:
      return read_as<std::uint64_t>(p);
    case msg::Kind::f32:
      return read_as<float>(p);
    case msg::Kind::f64:
      return read_as<double>(p);
    case msg::Kind::nested:
      break;
  }
  return 0;
}

void set_number_at(void* message, const Member& member, double value) {
  auto* p = static_cast<std::uint8_t*>(message) + member.offset;
  switch (member.kind) {
    case msg::Kind::i8:
      return write_as<std::int8_t>(p, value);
    case msg::Kind::u8:
      return write_as<std::uint8_t>(p, value);
    case msg::Kind::i16:
      return write_as<std::int16_t>(p, value);
    case msg::Kind::u16:
      return write_as<std::uint16_t>(p, value);
    case msg::Kind::i32:
      return write_as<std::int32_t>(p, value);
    case msg::Kind::u32:
      return write_as<std::uint32_t>(p, value);
    case msg::Kind::i64:
      return write_as<std::int64_t>(p, value);
    case msg::Kind::u64:
      return write_as<std::uint64_t>(p, value);
    case msg::Kind::f32:
      return write_as<float>(p, value);
    case msg::Kind::f64:
      return write_as<double>(p, value);
    case msg::Kind::nested:
      break;
  }
}

std::optional<Member> find_member(const msg::TypeInfo& type, std::string_view path) {
  const auto dot = path.find('.');
  const std::string_view step = path.substr(0, dot);
  const auto open = step.find('[');
  for (const msg::FieldInfo& f : type.fields) {
    if (f.name != step.substr(0, open)) continue;
    std::uint32_t index = 0;
    if (open != step.npos) {
      const char* const last = step.data() + step.size();
      const auto [end, error] = std::from_chars(step.data() + open + 1, last, index);
      if (error != std::errc{} || end + 1 != last || *end != ']' || index >= f.count) return {};
    } else if (f.is_array) {
      return {};
    }
    const std::uint32_t size = f.kind == msg::Kind::nested ? f.nested->size : msg::size_of(f.kind);
    Member found{f.offset + index * size, f.kind};
    if ((f.kind == msg::Kind::nested) != (dot != path.npos)) return {};
    if (f.kind != msg::Kind::nested) return found;
    const auto inner = find_member(*f.nested, path.substr(dot + 1));
    if (!inner) return {};
    return Member{found.offset + inner->offset, inner->kind};
  }
  return {};
}

void put_time(Value& time, std::int64_t ns) {
  const std::int64_t sec = ns / kSecond - (ns % kSecond < 0 ? 1 : 0);
  time.items[0].set_integer(sec);
  time.items[1].set_integer(ns - sec * kSecond);
}

std::optional<std::int64_t> time_of(const Value& time) {
  const std::int64_t sec = time.items[0].integer(), nanosec = time.items[1].integer();
  if ((sec == 0 && nanosec == 0) || nanosec >= kSecond) return {};
  return sec * kSecond + nanosec;
}

std::optional<double> finite(const Value& value) {
  const double number = value.number();
  return std::isfinite(number) ? std::optional(number) : std::nullopt;
}

/// A row with its places.
struct Step {
  What what;
  std::vector<Value*> ros{};  // as many as `own`; of a time its value
  std::vector<Member> own{};
  bool ros_is_float = true;
  double value = 1;
};

enum class Form : std::uint8_t { table, same, json };  // same: the own type's CDR; json: std_msgs/String

struct Plan {
  Plan(const Type& type, const msg::TypeInfo& own_, const MapOptions& options_)
      : message(type), own(own_), options(options_) {}

  Message message;
  const msg::TypeInfo& own;
  MapOptions options;
  Form form = Form::table;
  std::vector<Step> steps{};
  WriteRest write = nullptr;
  ReadRest read = nullptr;
  Value* stamp = nullptr;  // of the header, if it has one
  std::optional<Member> own_stamp{};
};

namespace {

constexpr std::string_view kSinew = "sinew_msgs/msg/";
constexpr std::string_view kNumbers[] = {"std_msgs/msg/Bool",   "std_msgs/msg/Int32",  "std_msgs/msg/Int64",
                                         "std_msgs/msg/UInt32", "std_msgs/msg/UInt64", "std_msgs/msg/Float32",
                                         "std_msgs/msg/Float64"};
constexpr std::string_view kText = "std_msgs/msg/String";

bool is_number_type(std::string_view ros) {
  return std::find(std::begin(kNumbers), std::end(kNumbers), ros) != std::end(kNumbers);
}

bool is_missing(const MapOptions& o, std::string_view need) {
  if (need == "frame") return o.frame.empty();
  if (need == "child_frame") return o.child_frame.empty();
  if (need == "joints") return o.joints.empty();
  if (need == "object") return o.object.empty();
  if (need == "camera") return o.camera.size() != 4;
  if (need == "max_m") return !(o.max_m > o.min_m);
  if (need == "geoid_m") return !std::isfinite(o.geoid_m);
  return false;
}

void add_places(Step& step, Plan& plan, const Row& row, std::initializer_list<const char*> parts) {
  for (const char* part : parts) {
    const std::string tail = *part == 0 ? "" : "." + std::string(part);
    const Field* field = nullptr;
    step.ros.push_back(find_value(plan.message.type(), plan.message.root(), std::string(row.ros) + tail, &field));
    step.ros_is_float = field && (field->kind == Kind::f32 || field->kind == Kind::f64);
    if (row.what != What::constant && row.what != What::frame && row.what != What::child_frame)
      step.own.push_back(find_member(plan.own, std::string(row.own) + tail).value_or(Member{}));
  }
}

Step step_of(Plan& plan, const Row& row) {
  Step step{row.what, {}, {}, true, row.value};
  switch (row.what) {
    case What::vector:
      add_places(step, plan, row, {"x", "y", "z"});
      break;
    case What::quaternion:
      add_places(step, plan, row, {"x", "y", "z", "w"});
      break;
    default:
      add_places(step, plan, row, {""});
  }
  return step;
}

void put(const Step& step, Value& value, double number) {
  if (step.ros_is_float)
    value.set(number);
  else
    value.set_integer(static_cast<std::int64_t>(number));
}

void write_step(const Step& step, const Plan& plan, const void* own, std::int64_t to_ros_ns) {
  switch (step.what) {
    case What::frame:
      step.ros[0]->text = plan.options.frame;
      return;
    case What::child_frame:
      step.ros[0]->text = plan.options.child_frame;
      return;
    case What::constant:
      return put(step, *step.ros[0], step.value);
    case What::time: {
      std::int64_t ns;
      std::memcpy(&ns, static_cast<const std::uint8_t*>(own) + step.own[0].offset, sizeof ns);
      return put_time(*step.ros[0], ns + to_ros_ns);
    }
    default:
      for (std::size_t i = 0; i < step.ros.size(); ++i) put(step, *step.ros[i], number_at(own, step.own[i]));
  }
}

/// Null, or why not.
const char* read_step(const Step& step, void* own, std::int64_t to_ros_ns) {
  switch (step.what) {
    case What::frame:
    case What::child_frame:
    case What::constant:
      return nullptr;
    case What::time: {
      const std::int64_t ns = time_of(*step.ros[0]).value_or(to_ros_ns) - to_ros_ns;
      std::memcpy(static_cast<std::uint8_t*>(own) + step.own[0].offset, &ns, sizeof ns);
      return nullptr;
    }
    default:
      for (std::size_t i = 0; i < step.ros.size(); ++i) {
        const double number = step.ros_is_float ? step.ros[i]->number() : static_cast<double>(step.ros[i]->integer());
        if (!std::isfinite(number)) return "a number that is not finite";
        set_number_at(own, step.own[i], number);
      }
      return nullptr;
  }
}

std::string lengthened(std::string_view ros) { return long_name(ros); }

/// The plan of both directions; null: `why`.
std::unique_ptr<Plan> make_plan(Distro distro, std::string_view ros_name, const msg::TypeInfo& own,
                                const MapOptions& options, bool out, std::string& why) {
  const std::string ros = lengthened(ros_name);
  const Type* type = known_types(distro).find(ros);
  if (!type) return why = "unknown ROS 2 type", nullptr;
  auto plan = std::make_unique<Plan>(*type, own, options);
  plan->stamp = plan->message.find("header.stamp");
  plan->own_stamp = find_member(own, "stamp");
  if (ros.starts_with(kSinew)) {
    if (ros != msg::ros2_name(own)) return why = "the topic's messages are " + std::string(own.name), nullptr;
    plan->form = Form::same;
    return plan;
  }
  if (ros == kText && out) {
    if (own.has_bulk()) return why = "messages with pixels have no text", nullptr;
    plan->form = Form::json;
    return plan;
  }
  if (is_number_type(ros)) {
    const auto member = find_member(own, options.field);
    if (!member) return why = "field names a number of " + std::string(own.name), nullptr;
    plan->steps.push_back(step_of(*plan, {What::number, "data", options.field}));
    return plan;
  }
  for (const Pair& pair : pairs()) {
    if (pair.ros != ros || pair.own != own.name || !(out ? pair.out : pair.in)) continue;
    for (const std::string_view need : pair.needs)
      if (is_missing(options, need)) return why = std::string(need) + " is required", nullptr;
    for (const Row& row : pair.rows) plan->steps.push_back(step_of(*plan, row));
    plan->write = pair.write;
    plan->read = pair.read;
    return plan;
  }
  std::string names;
  for (const std::string& name : own_types_for(ros, out)) names += (names.empty() ? "" : ", ") + name;
  why = names.empty() ? "a type that is not translated in this direction"
                      : "goes with messages of " + names + ", and the topic's are " + std::string(own.name);
  return nullptr;
}

}  // namespace
}  // namespace detail

using detail::Form;
using detail::Plan;

Outgoing::Outgoing(std::unique_ptr<Plan> plan) : plan_(std::move(plan)) {}
Outgoing::~Outgoing() = default;
Incoming::Incoming(std::unique_ptr<Plan> plan) : plan_(std::move(plan)) {}
Incoming::~Incoming() = default;

std::unique_ptr<Outgoing> Outgoing::make(Distro distro, std::string_view ros, const msg::TypeInfo& own,
                                         const MapOptions& options, std::string& why) {
  auto plan = detail::make_plan(distro, ros, own, options, true, why);
  if (!plan) return nullptr;
  return std::unique_ptr<Outgoing>(new Outgoing(std::move(plan)));
}

std::unique_ptr<Incoming> Incoming::make(Distro distro, std::string_view ros, const msg::TypeInfo& own,
                                         const MapOptions& options, std::string& why) {
  auto plan = detail::make_plan(distro, ros, own, options, false, why);
  if (!plan) return nullptr;
  return std::unique_ptr<Incoming>(new Incoming(std::move(plan)));
}

const Type& Outgoing::type() const { return plan_->message.type(); }
const Type& Incoming::type() const { return plan_->message.type(); }
bool Outgoing::wants_picture() const { return type().name == "sensor_msgs/msg/CompressedImage"; }

bool Outgoing::encode(const void* message, std::int64_t to_ros_ns, std::vector<std::uint8_t>& out,
                      std::span<const std::uint8_t> picture) {
  Plan& p = *plan_;
  if (p.form == Form::same) {
    out.resize(msg::cdr_size(p.own, message));
    return msg::cdr_encode(p.own, message, out) == out.size();
  }
  if (p.form == Form::json) {
    std::string& text = p.message.root().items[0].text;
    text.clear();
    msg::to_json(p.own, message, text);
  } else {
    for (const detail::Step& step : p.steps) detail::write_step(step, p, message, to_ros_ns);
    const detail::Context context{p.options, p.own, p.message, to_ros_ns, picture, 0, nullptr};
    if (p.write && !p.write(context, message)) return false;
  }
  ros2::encode(p.message.type(), p.message.root(), out);
  return true;
}

Incoming::Result Incoming::decode(std::span<const std::uint8_t> in, std::int64_t to_ros_ns, void* message,
                                  std::uint32_t bulk_capacity, const ReadPicture& read_picture) {
  Plan& p = *plan_;
  if (p.form == Form::same) {
    const msg::CdrDecoded decoded = msg::cdr_decode(p.own, in, message, bulk_capacity);
    return decoded ? Result{} : Result{decoded.error, {}, false};
  }
  p.own.reset(message);
  if (p.own.has_bulk()) p.own.set_bulk_capacity(message, bulk_capacity);
  if (const Decoded decoded = ros2::decode(p.message.type(), in, p.message.root()); !decoded)
    return {decoded.error, {}, false};
  for (const detail::Step& step : p.steps)
    if (const char* error = detail::read_step(step, message, to_ros_ns)) return {error, {}, false};
  const detail::Context context{p.options, p.own, p.message, to_ros_ns, {}, bulk_capacity, &read_picture};
  if (const char* error = p.read ? p.read(context, message) : nullptr)
    return *error == 0 ? Result{{}, {}, true} : Result{error, {}, false};
  return {{}, p.stamp ? detail::time_of(*p.stamp) : std::nullopt, false};
}

const std::vector<MapLine>& map_table() {
  static const std::vector<MapLine> table = [] {
    std::vector<MapLine> lines;
    for (const detail::Pair& pair : detail::pairs()) {
      MapLine line{pair.ros, pair.own, pair.out, pair.in, pair.needs, pair.remark, {}};
      for (const detail::Row& row : pair.rows) {
        std::string from(row.own);
        if (row.what == detail::What::frame) from = "`frame`";
        if (row.what == detail::What::child_frame) from = "`child_frame`";
        if (row.what == detail::What::constant) {
          from.clear();
          msg::append_number(msg::Kind::f64, &row.value, from);
        }
        line.fields.emplace_back(row.ros, from);
      }
      for (const auto& [ros, from] : pair.by_code) line.fields.emplace_back(ros, from);
      lines.push_back(std::move(line));
    }
    for (const std::string_view ros : detail::kNumbers)
      lines.push_back({ros,
                       "",
                       true,
                       true,
                       {"field"},
                       "One number of any message; in: all others at their defaults.",
                       {{"data", "`field`"}}});
    lines.push_back(
        {detail::kText, "", true, false, {}, "The message as JSON, as `sinew topic echo --json` prints it.", {}});
    return lines;
  }();
  return table;
}

std::vector<std::string> own_types_for(std::string_view ros_name, bool out) {
  const std::string ros = long_name(ros_name);
  std::vector<std::string> names;
  for (const MapLine& line : map_table())
    if (line.ros == ros && (out ? line.out : line.in))
      names.push_back(line.own.empty() ? "any" : std::string(line.own));
  return names;
}

std::vector<std::string> ros_types(bool out) {
  std::vector<std::string> names;
  for (const MapLine& line : map_table())
    if ((out ? line.out : line.in) && std::find(names.begin(), names.end(), line.ros) == names.end())
      names.emplace_back(line.ros);
  return names;
}

}  // namespace sinew::ros2
