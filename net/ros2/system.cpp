#include "net/ros2/system.hpp"

#include <algorithm>

#include "net/ros2/plan.hpp"

namespace sinew::ros2 {
namespace {

using detail::put_time;

constexpr std::size_t kServiceHead = 16;

/// A message of a type that both distributions have alike.
Message of(std::string_view type) { return Message(*known_types(Distro::humble).find(type)); }

Bytes bytes_of(const Message& message) {
  Bytes out;
  encode(message.type(), message.root(), out);
  return out;
}

/// `count` elements of the sequence at `path`, at their defaults.
std::vector<Value>& make_items(Message& message, std::string_view path, std::size_t count) {
  const Field* field = nullptr;
  Value* const list = find_value(message.type(), message.root(), path, &field);
  list->items.assign(count, Value());
  if (field->nested)
    for (Value& item : list->items) Message::make_default(*field->nested, item);
  return list->items;
}

// ---- parameters: {name, value}, value {type, bool_value, integer_value, double_value, string_value, ...}

enum ParameterType : std::uint8_t { kNotSet = 0, kBool = 1, kInteger = 2, kDouble = 3, kString = 4 };

std::uint8_t type_of(const ParameterValue& value) { return static_cast<std::uint8_t>(value.index()); }
static_assert(std::is_same_v<std::variant_alternative_t<kBool, ParameterValue>, bool> &&
              std::is_same_v<std::variant_alternative_t<kInteger, ParameterValue>, std::int64_t> &&
              std::is_same_v<std::variant_alternative_t<kDouble, ParameterValue>, double> &&
              std::is_same_v<std::variant_alternative_t<kString, ParameterValue>, std::string>);

void put_value(Value& ros, const ParameterValue& value) {
  ros.items[0].set_integer(type_of(value));
  if (const bool* b = std::get_if<bool>(&value)) ros.items[1].set_integer(*b ? 1 : 0);
  if (const std::int64_t* i = std::get_if<std::int64_t>(&value)) ros.items[2].set_integer(*i);
  if (const double* d = std::get_if<double>(&value)) ros.items[3].set(*d);
  if (const std::string* s = std::get_if<std::string>(&value)) ros.items[4].text = *s;
}
void put_parameter(Value& ros, const Parameter& parameter) {
  ros.items[0].text = parameter.name;
  put_value(ros.items[1], parameter.value);
}
void put_parameters(Message& message, std::string_view path, std::span<const Parameter> all) {
  std::vector<Value>& items = make_items(message, path, all.size());
  for (std::size_t i = 0; i < all.size(); ++i) put_parameter(items[i], all[i]);
}

bool read_parameter(const Value& ros, Parameter& out) {
  out.name = ros.items[0].text;
  const std::vector<Value>& value = ros.items[1].items;
  switch (value[0].integer()) {
    case kNotSet:
      out.value = {};
      return true;
    case kBool:
      out.value = value[1].integer() != 0;
      return true;
    case kInteger:
      out.value = value[2].integer();
      return true;
    case kDouble:
      out.value = value[3].number();
      return true;
    case kString:
      out.value = value[4].text;
      return true;
    default:
      return false;
  }
}

constexpr std::string_view name_of(ParameterService service) {
  switch (service) {
    case ParameterService::get:
      return "rcl_interfaces/srv/GetParameters";
    case ParameterService::get_types:
      return "rcl_interfaces/srv/GetParameterTypes";
    case ParameterService::set:
      return "rcl_interfaces/srv/SetParameters";
    case ParameterService::list:
      return "rcl_interfaces/srv/ListParameters";
    case ParameterService::describe:
      break;
  }
  return "rcl_interfaces/srv/DescribeParameters";
}

std::string half(ParameterService service, bool request) {
  return std::string(name_of(service)) + (request ? "_Request" : "_Response");
}

/// Puts the request's head in front of the reply. Both are multiples of 8: nothing behind it moves.
Bytes with_head(const ServiceRequest& request, const Message& reply) {
  Bytes body = bytes_of(reply);
  body.insert(body.begin() + 4, request.head.begin(), request.head.end());
  return body;
}

const ParameterInfo* info_of(std::span<const ParameterInfo> known, std::string_view name) {
  const auto it =
      std::find_if(known.begin(), known.end(), [&](const ParameterInfo& p) { return p.parameter.name == name; });
  return it == known.end() ? nullptr : &*it;
}

/// ROS 2's rule: without prefixes all; with them what begins with "PREFIX.", or is PREFIX.
bool is_listed(const std::string& name, const std::vector<std::string>& prefixes) {
  return prefixes.empty() || std::any_of(prefixes.begin(), prefixes.end(), [&](const std::string& prefix) {
           return name == prefix || name.starts_with(prefix + ".");
         });
}

}  // namespace

Bytes discovery_info(Distro distro, const Guid& participant, std::span<const NodeInfo> nodes) {
  Message message(*known_types(distro).find("rmw_dds_common/msg/ParticipantEntitiesInfo"));
  const std::size_t size = known_types(distro).find("rmw_dds_common/msg/Gid")->fields[0].count;
  std::vector<Bytes> gids;  // what values look at
  std::size_t count = 1;
  for (const NodeInfo& node : nodes) count += node.readers.size() + node.writers.size();
  gids.reserve(count);
  const auto gid = [&](const Guid& guid) -> std::span<const std::uint8_t> {
    Bytes& bytes = gids.emplace_back(guid.begin(), guid.end());
    bytes.resize(size);  // humble's has 24 bytes, of which 8 are 0
    return bytes;
  };
  message.find("gid.data")->bytes = gid(participant);
  make_items(message, "node_entities_info_seq", nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const std::string at = "node_entities_info_seq[" + std::to_string(i) + "].";
    message.find(at + "node_namespace")->text = nodes[i].name_space;
    message.find(at + "node_name")->text = nodes[i].name;
    const auto put = [&](const char* list, const std::vector<Guid>& guids) {
      std::vector<Value>& items = make_items(message, at + list, guids.size());
      for (std::size_t k = 0; k < guids.size(); ++k) items[k].items[0].bytes = gid(guids[k]);
    };
    put("reader_gid_seq", nodes[i].readers);
    put("writer_gid_seq", nodes[i].writers);
  }
  return bytes_of(message);
}

Bytes clock_message(std::int64_t ns) {
  Message message = of("rosgraph_msgs/msg/Clock");
  put_time(*message.find("clock"), ns);
  return bytes_of(message);
}

std::optional<std::int64_t> read_clock(std::span<const std::uint8_t> in) {
  Message message = of("rosgraph_msgs/msg/Clock");
  if (!decode(message.type(), in, message.root())) return {};
  return detail::time_of(*message.find("clock"));
}

Bytes log_message(std::int64_t stamp_ns, LogLevel level, std::string_view node, std::string_view text) {
  Message message = of("rcl_interfaces/msg/Log");
  put_time(*message.find("stamp"), stamp_ns);
  message.find("level")->set_integer(static_cast<std::uint8_t>(level));
  message.find("name")->text = node;
  message.find("msg")->text = text;
  return bytes_of(message);
}

Bytes diagnostics_message(std::int64_t stamp_ns, std::span<const Diagnosis> all) {
  Message message = of("diagnostic_msgs/msg/DiagnosticArray");
  put_time(*message.find("header.stamp"), stamp_ns);
  std::vector<Value>& items = make_items(message, "status", all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    std::vector<Value>& status = items[i].items;  // level, name, message, hardware_id, values
    status[0].set_integer(static_cast<std::uint8_t>(all[i].health));
    status[1].text = all[i].name;
    status[2].text = all[i].message;
    status[3].text = all[i].hardware;
    std::vector<Value>& values = make_items(message, "status[" + std::to_string(i) + "].values", all[i].values.size());
    for (std::size_t k = 0; k < values.size(); ++k) {
      values[k].items[0].text = all[i].values[k].first;
      values[k].items[1].text = all[i].values[k].second;
    }
  }
  return bytes_of(message);
}

Bytes static_frames_message(std::int64_t stamp_ns, std::span<const StaticFrame> frames) {
  Message message = of("tf2_msgs/msg/TFMessage");
  std::vector<Value>& items = make_items(message, "transforms", frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    std::vector<Value>& t = items[i].items;  // header, child_frame_id, transform
    put_time(t[0].items[0], stamp_ns);
    t[0].items[1].text = frames[i].parent;
    t[1].text = frames[i].child;
    for (std::size_t k = 0; k < 3; ++k) t[2].items[0].items[k].set(frames[i].xyz_m[k]);
    const auto& q = frames[i].quat_wxyz;
    const double xyzw[] = {q[1], q[2], q[3], q[0]};
    for (std::size_t k = 0; k < 4; ++k) t[2].items[1].items[k].set(xyzw[k]);
  }
  return bytes_of(message);
}

Bytes parameter_event(std::int64_t stamp_ns, std::string_view node, std::span<const Parameter> added,
                      std::span<const Parameter> changed) {
  Message message = of("rcl_interfaces/msg/ParameterEvent");
  put_time(*message.find("stamp"), stamp_ns);
  message.find("node")->text = node;
  put_parameters(message, "new_parameters", added);
  put_parameters(message, "changed_parameters", changed);
  return bytes_of(message);
}

std::optional<ParameterEvent> read_parameter_event(std::span<const std::uint8_t> in) {
  Message message = of("rcl_interfaces/msg/ParameterEvent");
  if (!decode(message.type(), in, message.root())) return {};
  ParameterEvent event;
  event.node = message.find("node")->text;
  for (const char* list : {"new_parameters", "changed_parameters"})
    for (const Value& ros : message.find(list)->items)
      if (!read_parameter(ros, event.set.emplace_back())) return {};
  return event;
}

std::string service_type(ParameterService service, bool request) { return dds_type_name(half(service, request)); }

std::optional<ServiceRequest> read_request(ParameterService service, std::span<const std::uint8_t> in) {
  if (in.size() < 4 + kServiceHead) return {};
  ServiceRequest request;
  std::copy_n(in.begin() + 4, kServiceHead, request.head.begin());
  Bytes body(in.begin(), in.begin() + 4);
  body.insert(body.end(), in.begin() + 4 + kServiceHead, in.end());
  Message message = of(half(service, true));
  if (!decode(message.type(), body, message.root())) return {};
  if (service == ParameterService::set) {
    for (const Value& ros : message.find("parameters")->items)
      if (!read_parameter(ros, request.set.emplace_back())) return {};
    return request;
  }
  for (const Value& name : message.root().items[0].items) request.names.push_back(name.text);
  return request;
}

Bytes service_reply(ParameterService service, const ServiceRequest& request, std::span<const ParameterInfo> known) {
  Message reply = of(half(service, false));
  Bytes types;  // what a value looks at
  switch (service) {
    case ParameterService::get: {
      std::vector<Value>& values = make_items(reply, "values", request.names.size());
      for (std::size_t i = 0; i < values.size(); ++i)
        if (const ParameterInfo* info = info_of(known, request.names[i])) put_value(values[i], info->parameter.value);
      break;
    }
    case ParameterService::get_types: {
      for (const std::string& name : request.names) {
        const ParameterInfo* info = info_of(known, name);
        types.push_back(info ? type_of(info->parameter.value) : static_cast<std::uint8_t>(kNotSet));
      }
      reply.find("types")->bytes = types;
      break;
    }
    case ParameterService::list: {
      std::vector<Value>& names = reply.find("result.names")->items;
      for (const ParameterInfo& info : known)
        if (is_listed(info.parameter.name, request.names)) names.emplace_back().text = info.parameter.name;
      break;
    }
    case ParameterService::describe: {
      std::vector<Value>& all = make_items(reply, "descriptors", request.names.size());
      for (std::size_t i = 0; i < all.size(); ++i) {
        const std::string at = "descriptors[" + std::to_string(i) + "].";
        reply.find(at + "name")->text = request.names[i];
        const ParameterInfo* info = info_of(known, request.names[i]);
        if (!info) continue;
        reply.find(at + "type")->set_integer(type_of(info->parameter.value));
        reply.find(at + "description")->text = info->doc;
        if (!info->min || !info->max) continue;
        if (std::holds_alternative<double>(info->parameter.value)) {
          std::vector<Value>& range = make_items(reply, at + "floating_point_range", 1)[0].items;
          range[0].set(*info->min), range[1].set(*info->max);
        } else if (std::holds_alternative<std::int64_t>(info->parameter.value)) {
          std::vector<Value>& range = make_items(reply, at + "integer_range", 1)[0].items;
          range[0].set_integer(static_cast<std::int64_t>(*info->min));
          range[1].set_integer(static_cast<std::int64_t>(*info->max));
        }
      }
      break;
    }
    case ParameterService::set:
      break;
  }
  return with_head(request, reply);
}

Bytes set_reply(const ServiceRequest& request, std::span<const std::string> refused) {
  Message reply = of(half(ParameterService::set, false));
  std::vector<Value>& results = make_items(reply, "results", request.set.size());
  for (std::size_t i = 0; i < results.size(); ++i) {
    const std::string why = i < refused.size() ? refused[i] : "";
    results[i].items[0].set_integer(why.empty() ? 1 : 0);
    results[i].items[1].text = why;
  }
  return with_head(request, reply);
}

}  // namespace sinew::ros2
